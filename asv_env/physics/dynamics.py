"""The motion of all hulls under motors, water and contact: the physics of a control step."""

import numpy as np

from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.physics import water
from asv_env.physics.autopilot import Autopilot
from asv_env.physics.basin import Basin, BasinSnapshot
from asv_env.physics.thrusters import MIX, Motors, from_command, limited
from asv_env.types import Bool, Float, InitialState


class Dynamics:
    """Bodies in a ``basin``, their ``motors``, and the water, of ``num_worlds`` worlds."""

    def __init__(self, params: EnvParams, num_worlds: int, worlds_per_space: int) -> None:
        self._params = params
        self.basin = Basin(params, num_worlds, worlds_per_space)
        vessel, self._boat = params.hulls()
        hulls = [vessel] + [self._boat] * params.num_boats
        self._mass = np.array([hull.total_mass for hull in hulls])
        self._inertia = np.array([hull.total_inertia for hull in hulls])
        self._drag = water.coefficients(hulls)
        self._autopilot = Autopilot(self._boat)
        self.motors = Motors(self._boat, num_worlds, params.num_boats)

        shape = (num_worlds, len(hulls))
        self._linear, self._quadratic = np.ones((2, *shape, 3))
        self._dt_per_mass, self._softening = np.ones((2, *shape, 3))
        self._make_buffers(shape)

    def _make_buffers(self, shape: tuple[int, int]) -> None:
        """Makes the arrays of a physics step for ``shape`` = (W, B), and views of them.

        They are made once: for few worlds NumPy's calls cost more than the physics.
        """
        motion, force = self.basin.motion, self.basin.force  # world frame
        self._heading, self._yaw_rate = motion[..., 2], motion[..., 5]
        self._velocity = plane(motion, 3)
        self._force, self._moment = plane(force), force[..., 2]
        self._direction = np.empty(shape, dtype=np.complex128)
        self._cos, self._sin = self._direction.real, self._direction.imag
        # In the hulls' own frames: velocity relative to the water, thrust, all that acts.
        self._relative_velocity, self._thrust_wrench, self._wrench = np.zeros((3, *shape, 3))
        self._relative_planar = plane(self._relative_velocity)
        self._relative_yaw_rate = self._relative_velocity[..., 2]
        self._boat_speeds = self._relative_velocity[:, 1:, ::2]
        self._surge_force = self._thrust_wrench[:, 1:, 0]
        self._yaw_moment = self._thrust_wrench[:, 1:, 2]
        self._wrench_planar, self._wrench_yaw = plane(self._wrench), self._wrench[..., 2]
        self._demand, self._thrust = np.zeros((2, shape[0], shape[1] - 1, 2))
        self._demand_pair, self._thrust_pair = plane(self._demand), plane(self._thrust)

    def place(self, world: int, initial: InitialState) -> None:
        """Places one world in its initial state, motors off."""
        mass, inertia = self._mass * initial.mass_gain, self._inertia * initial.mass_gain
        self.basin.place(world, initial.motion, mass, inertia, initial.friction)
        dt = self._params.clock.dt
        self._dt_per_mass[world] = dt / np.stack([mass, mass, inertia], axis=-1)
        linear, quadratic = self._drag
        self._linear[world] = linear * initial.drag_gain[:, None]
        self._quadratic[world] = quadratic * initial.drag_gain[:, None]
        self._softening[world] = water.softening(self._linear[world], self._dt_per_mass[world])
        self.motors.reset(world, initial.thrust_gain, dt / initial.lag)

    def snapshot(self) -> tuple[BasinSnapshot, tuple[Float, ...]]:
        """Returns all that the next steps depend on, for the simulation to copy."""
        return self.basin.snapshot(), self._changing()

    def restore(self, memory: tuple[BasinSnapshot, tuple[Float, ...]]) -> None:
        """Continues as the dynamics did, with the same arguments, whose ``snapshot`` this is."""
        basin, arrays = memory
        self.basin.restore(basin)
        for array, remembered in zip(self._changing(), arrays, strict=True):
            array[...] = remembered

    def _changing(self) -> tuple[Float, ...]:
        """Returns the arrays that change from step to step, or from episode to episode."""
        gains = self._linear, self._quadratic, self._dt_per_mass, self._softening
        return *gains, *self.motors.changing()

    def advance(self, action: Float, working: Bool, steps: int) -> Float:
        """Advances all worlds by some physics steps under one action.

        Args:
            action: (W, A, 2) in [-1, 1].
            working: (W, A) boats whose thrusters answer.
            steps: number of physics steps.

        Returns:
            Motion (W, B, 6) in each world's own coordinates; headings are not wrapped.
        """
        self.motors.enable(working)
        tracking = self._params.action_mode == "tracking"
        if tracking:
            at_rest, gains = self._autopilot.demand_at_rest(action), self._autopilot.gains
        else:
            thrust = from_command(action, self._boat)
        for _ in range(steps):
            self._update_velocities()
            if tracking:
                np.multiply(gains, self._boat_speeds, out=self._demand)
                np.subtract(at_rest, self._demand, out=self._demand)
                np.multiply(MIX, self._demand_pair, out=self._thrust_pair)
                thrust = limited(self._thrust, self._boat)
            self.motors.drive(thrust, self._surge_force, self._yaw_moment)
            self._apply_forces()
            self.basin.step()
        return self.basin.world_motion()

    def _update_velocities(self) -> None:
        """Computes the directions of the hulls and, in their own frames, velocities over ground."""
        np.cos(self._heading, out=self._cos)
        np.sin(self._heading, out=self._sin)
        np.multiply(self._velocity, self._direction.conj(), out=self._relative_planar)
        self._relative_yaw_rate[...] = self._yaw_rate

    def _apply_forces(self) -> None:
        """Writes the force of motors and water, in the world frame, into the basin's array."""
        if self._params.water.current != "still":
            flow = water.current(self._params.water, plane(self.basin.world_motion()))
            self._relative_planar -= flow * self._direction.conj()
        velocity, drag = self._relative_velocity, (self._linear, self._quadratic)
        step = self._dt_per_mass, self._softening
        water.damped(self._thrust_wrench, velocity, *drag, *step, out=self._wrench)
        np.multiply(self._wrench_planar, self._direction, out=self._force)
        self._moment[...] = self._wrench_yaw
