"""The motion of all hulls under motors, water and contact: the physics of one control step."""

from __future__ import annotations

import numpy as np

from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.physics import water
from asv_env.physics.autopilot import Autopilot
from asv_env.physics.basin import Basin
from asv_env.physics.thrusters import MIX, Motors, from_command, limited
from asv_env.types import Bool, Complex, Float, InitialState


class Dynamics:
    """Bodies, motors and water of ``num_worlds`` worlds.

    Attributes:
        motors: of all boats.
    """

    def __init__(self, params: EnvParams, num_worlds: int, worlds_per_space: int) -> None:
        self._params = params
        self._basin = Basin(params, num_worlds, worlds_per_space)
        vessel, self._boat = params.hulls()
        hulls = [vessel] + [self._boat] * params.num_boats
        self._mass = np.array([hull.total_mass for hull in hulls])
        self._inertia = np.array([hull.total_inertia for hull in hulls])
        self._drag = water.coefficients(hulls)
        self._autopilot = Autopilot(self._boat)
        self.motors = Motors(self._boat, num_worlds, params.num_boats)

        shape = (num_worlds, len(hulls))
        self._linear, self._quadratic = np.ones((*shape, 3)), np.ones((*shape, 3))
        self._dt_per_mass = np.ones((*shape, 3))
        self._softened = np.ones((*shape, 3))
        self._make_workspace(shape)

    def _make_workspace(self, shape: tuple[int, int]) -> None:
        """Arrays of a physics step and the views into them that it needs.

        They are made once: for few worlds NumPy's calls cost more than the physics.
        """
        motion, force = self._basin.motion, self._basin.force
        self._angle, self._course, self._spin = motion[..., 2], plane(motion, 3), motion[..., 5]
        self._pull, self._twist = plane(force), force[..., 2]
        self._heading = np.empty(shape, dtype=np.complex128)
        self._cos, self._sin = self._heading.real, self._heading.imag
        self._velocity = np.zeros((*shape, 3))
        self._through_water, self._yaw_rate = plane(self._velocity), self._velocity[..., 2]
        self._tracked = self._velocity[:, 1:, ::2]
        self._wrench = np.zeros((*shape, 3))
        self._surge, self._yaw = self._wrench[:, 1:, 0], self._wrench[:, 1:, 2]
        self._demand, self._wanted = np.zeros((2, shape[0], shape[1] - 1, 2))
        self._demand_pair, self._wanted_pair = plane(self._demand), plane(self._wanted)
        self._total = np.zeros((*shape, 3))
        self._planar_total, self._yaw_total = plane(self._total), self._total[..., 2]

    def place(self, world: int, start: InitialState) -> None:
        """Puts one world at the start of an episode, motors off."""
        mass, inertia = self._mass * start.mass_gain, self._inertia * start.mass_gain
        self._basin.place(world, start.motion, mass, inertia, start.friction)
        dt = self._params.clock.dt
        self._dt_per_mass[world] = dt / np.stack([mass, mass, inertia], axis=-1)
        linear, quadratic = self._drag
        self._linear[world] = linear * start.drag_gain[:, None]
        self._quadratic[world] = quadratic * start.drag_gain[:, None]
        self._softened[world] = water.softening(self._linear[world], self._dt_per_mass[world])
        self.motors.start(world, start.thrust_gain, dt / start.lag)

    def advance(self, action: Float, working: Bool, steps: int) -> Float:
        """Physics steps under one action.

        Args:
            action: (W, A, 2) in [-1, 1].
            working: (W, A) boats whose thrusters answer.
            steps: number of physics steps.

        Returns:
            Motion (W, B, 6) in each world's own coordinates; headings are not wrapped.
        """
        self.motors.enable(working)
        tracks = self._params.action_mode == "tracking"
        if tracks:
            at_rest, gains = self._autopilot.demand_at_rest(action), self._autopilot.gains
        else:
            wanted = from_command(action, self._boat)
        for _ in range(steps):
            self._take_bearings()
            if tracks:
                np.multiply(gains, self._tracked, out=self._demand)
                np.subtract(at_rest, self._demand, out=self._demand)
                np.multiply(MIX, self._demand_pair, out=self._wanted_pair)
                wanted = limited(self._wanted, self._boat)
            self.motors.drive(wanted, self._surge, self._yaw)
            self._exert()
            self._basin.step()
        return self._basin.world_motion()

    def _take_bearings(self) -> None:
        """Headings, and velocities in the hulls' own frames over the ground."""
        np.cos(self._angle, out=self._cos)
        np.sin(self._angle, out=self._sin)
        np.multiply(self._course, self._heading.conj(), out=self._through_water)
        self._yaw_rate[...] = self._spin

    def _exert(self) -> None:
        """Hands motors and water, in the world's frame, to the basin."""
        if self._params.water.current != "still":
            flow = self.current(plane(self._basin.world_motion()))
            self._through_water -= flow * self._heading.conj()
        water.damped(
            self._wrench,
            self._velocity,
            self._linear,
            self._quadratic,
            self._dt_per_mass,
            self._softened,
            out=self._total,
        )
        np.multiply(self._planar_total, self._heading, out=self._pull)
        self._twist[...] = self._yaw_total

    def current(self, position: Complex) -> Complex:
        """Velocity of the water (...) at positions (...) of a world, m/s."""
        return water.current(self._params.water, position)

    def touching(self) -> Bool:
        """(W, A, 2) whether each boat's hull touches the vessel, another boat or a wall."""
        return self._basin.touching()
