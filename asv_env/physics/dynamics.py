"""The motion of all hulls under motors, water and contact: the physics of a control step."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asv_env.compiled import bound
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.physics import autopilot, hull, kernel, thrusters, water
from asv_env.physics.basin import Basin, BasinSnapshot
from asv_env.physics.gusts import Gusts
from asv_env.physics.kernel import Plant
from asv_env.physics.shelter import cover
from asv_env.threads import spread
from asv_env.types import Bool, Complex, Float, InitialState, Int, State, frozen


@dataclass(frozen=True)
class DynamicsSnapshot:
    """All that a ``Dynamics`` remembers from one step to the next."""

    basin: BasinSnapshot
    arrays: tuple[Float, ...]
    gusts: dict[str, Any]


class Dynamics:
    """Bodies in a ``basin`` and the ``plant`` that moves them, of ``num_worlds`` worlds.

    Args:
        params: parameters of the environment.
        num_worlds: W.
        num_threads: number of threads over which the worlds are spread.
    """

    def __init__(self, params: EnvParams, num_worlds: int, num_threads: int = 1) -> None:
        self._dt, self._water = params.clock.dt, params.water
        self._num_threads = max(1, min(num_threads, num_worlds))
        self.basin = Basin(params, num_worlds, self._num_threads)
        vessel, boat = params.hulls()
        hulls = [vessel] + [boat] * params.num_boats
        self._kinds = hull.kinds(hulls)
        self._scale = autopilot.scale(boat)
        surge, yaw = autopilot.axes(boat)
        self._gusts = Gusts(params, num_worlds)
        self.plant = Plant(
            per_step=np.ones((num_worlds, len(hulls), 2)),
            hulls=hull.hulls(num_worlds, len(hulls)),
            motors=thrusters.motors(num_worlds, params.num_boats),
            drive=thrusters.drive(boat),
            surge=surge,
            yaw=yaw,
            reference=np.zeros((num_worlds, params.num_boats, 2)),
            flow=water.flow(params.water),
            gust=self._gusts.velocity,
            cover=cover(params),
            dt=params.clock.dt,
            tracking=params.action_mode != "thrusters",
        )
        self._bound = bound((self.plant, self.basin.bodies, self.basin.wires))
        self._still = np.zeros(num_worlds, dtype=np.complex128)
        # Factor that turns an impulse into its part of a control step's mean force.
        self._share = float(params.clock.control)
        # Commands on their way to the boats, the next one first.
        late = params.clock.ticks(params.variation.actuation_delay)
        self._commands = np.zeros((late, num_worlds, params.num_boats, 2))

    def place(self, world: int, initial: InitialState) -> None:
        """Places one world in its initial state, motors off, autopilots at the boats' motion."""
        gain = initial.mass_gain
        root = math.sqrt(initial.friction)  # Chipmunk multiplies those of two shapes.
        self.basin.clear(world, root)
        if initial.obstacle is not None:
            self.basin.put_obstacles(world, initial.obstacle)
        size = np.ones(len(gain))
        if initial.boat_size is not None:
            size[1:] = initial.boat_size
            self.basin.resize(world, size[1:])
        hulls = np.empty((len(gain), 9))
        hulls[:, :6], hulls[:, 8] = initial.motion, root
        hulls[:, 6] = self._kinds.contact_mass * gain * size**3
        hulls[:, 7] = self._kinds.mass[:, 2] * gain * size**5
        keep = float(np.exp(-self._dt / initial.lag))
        kernel.begin(world, hulls, initial.thrust_gain, keep, self._bound)
        self.plant.motors.arm_gain[world] = size[1:]
        gains = gain, initial.drag_gain, size
        hull.equip(self.plant.hulls, world, self._kinds, *gains, self._dt)
        if len(self._commands):
            self._commands[:, world] = 0.0

    def snapshot(self) -> DynamicsSnapshot:
        """Returns all that the next steps depend on, for the simulation to copy."""
        return DynamicsSnapshot(self.basin.snapshot(), self._changing(), self._gusts.snapshot())

    def restore(self, snapshot: DynamicsSnapshot) -> None:
        """Continues as the dynamics did, with the same arguments, whose ``snapshot`` this is."""
        self.basin.restore(snapshot.basin)
        for array, remembered in zip(self._changing(), snapshot.arrays, strict=True):
            array[...] = remembered
        self._gusts.restore(snapshot.gusts)

    def _changing(self) -> tuple[Float, ...]:
        """Returns the arrays that change from step to step, or from episode to episode."""
        plant = self.plant
        per_episode = plant.per_step, *plant.hulls
        return *per_episode, *plant.motors, plant.reference, self._commands

    def delayed(self, command: Float) -> Float:
        """Returns the command (W, A, 2) that reaches the boats when this one is given."""
        if not len(self._commands):
            return command
        arriving = self._commands[0].copy()
        self._commands[:-1] = self._commands[1:]
        self._commands[-1] = command
        return arriving

    def water(self) -> Complex:
        """Returns the velocity (W,) of the water at the vessels, m/s, not to be written to."""
        current: Complex = self._still
        if self.plant.flow.kind != water.STILL:
            current = water.current(self._water, plane(self.basin.motion[:, 0]))
        return current + plane(self._gusts.velocity) if self._gusts.blow else current

    def blown(self, state: State, index: Int, rngs: Mapping[int, np.random.Generator]) -> State:
        """Begins the gusts of the worlds ``index`` (n,); returns the state with them.

        ``rngs`` are the Generators of all worlds.
        """
        if not self._gusts.blow:
            return state
        self._gusts.reset(index, rngs)
        return frozen(replace(state, gust=self._gusts.velocity.copy()))

    def begin(self) -> None:
        """Begins a control step, over which contact forces are averaged and gusts are steady."""
        self._gusts.advance()
        self.basin.bodies.contact_force.fill(0.0)

    def advance(self, action: Float, working: Bool, steps: int) -> Float:
        """Advances all worlds by some physics steps of a control step, under one action.

        Args:
            action: (W, A, 2) in [-1, 1].
            working: (W, A) boats whose thrusters answer, read-only.
            steps: number of physics steps.

        Returns:
            Motion (W, B, 6) in the worlds' frames, headings wrapped; read-only.
        """
        motion: Float = np.empty_like(self.basin.motion, order="C")

        def run(steps: int) -> None:
            def advance(first: int, last: int, thread: int) -> None:
                span = first, last, thread, steps, self._share
                kernel.advance(*span, action, working, self._bound, motion)

            spread(advance, len(action), self._num_threads)

        if self.basin.moved:
            run(1)
            self.basin.settle()
            steps -= 1
        run(steps)
        motion.setflags(write=False)
        return motion

    def felt(self) -> dict[str, Any]:
        """Returns the fields of ``State`` that hold thrust, contacts and gusts, read-only.

        They are those after a control step.
        """
        bodies, thrust = self.basin.bodies, self.plant.motors.thrust
        fields = {
            "thrust": thrust.copy(),
            "touching": bodies.touching.copy(),
            "contact_force": bodies.contact_force.copy(),
            "gust": self._gusts.velocity.copy(),
            "aground": bodies.aground.copy(),
        }
        for array in fields.values():
            array.setflags(write=False)
        return fields
