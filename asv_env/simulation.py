"""The environment, batched: many worlds advance by one control step at a time.

The adapters in ``envs`` only translate.
"""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from asv_env.geometry import plane, wrap, xy
from asv_env.params import EnvParams
from asv_env.physics import water
from asv_env.physics.dynamics import Dynamics
from asv_env.sensing import observation
from asv_env.sensing.sensors import Sensors
from asv_env.tasks import formation, metrics, reward, termination
from asv_env.tasks.formation import Relations, relate
from asv_env.tasks.reward import Transition
from asv_env.tasks.task import InitialStates, Task
from asv_env.types import (
    Bool,
    Ending,
    Float,
    Observation,
    Sensed,
    Situation,
    State,
    TimeStep,
    copied,
    put_rows,
    rows,
)

WORLDS_PER_SPACE = 128  #: number of worlds that share a Pymunk Space by default
SITUATION = tuple(f.name for f in fields(Situation))  #: names of what boats know exactly


class Simulation:
    """``num_worlds`` independent worlds of one task.

    W worlds, A boats, K features: observation (W, A, K) float32, action (W, A, 2) in [-1, 1],
    reward (W, A). Every world has its own random Generator, and worlds do not affect each other.
    After the end of its episode a world can be stepped once more, with no meaning; then it has
    to be reset.

    Args:
        params: Parameters of the environment, the task among them; see ``presets.make_params``.
        num_worlds: W.
        worlds_per_space: Number of worlds that share a Pymunk Space. 128 is fastest; with 1 every
            world computes at the origin and its results do not depend on the batch.
        initial_states: Distribution of initial states that replaces the task's, such as a
            curriculum.
    """

    state: State  #: true state; not to be written to
    relations: Relations  #: relations of the true motion
    ending: Ending  #: whether and why episodes ended at the last step

    def __init__(
        self,
        params: EnvParams,
        num_worlds: int = 1,
        worlds_per_space: int = WORLDS_PER_SPACE,
        initial_states: InitialStates | None = None,
    ) -> None:
        for name, value in (("num_worlds", num_worlds), ("worlds_per_space", worlds_per_space)):
            if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
                raise ValueError(f"{name} = {value!r}: must be a whole number of at least 1")
        self.params = params
        self.num_worlds = num_worlds
        self._task: Task = params.definition
        self._initial_states = initial_states or self._task.initial_states
        self._dynamics = Dynamics(params, num_worlds, worlds_per_space)
        self._sensors = Sensors(params, num_worlds)
        self._features = observation.features(params)
        self._rngs: dict[int, np.random.Generator] = {}
        self._failure_tick = np.full((num_worlds, params.num_boats), metrics.NEVER)
        self._steps_over = np.full(num_worlds, 2)
        self._make_records()

    def _make_records(self) -> None:
        """Allocates the records of all worlds; ``reset`` fills them."""
        worlds, team = self.num_worlds, self.params.num_boats
        none = np.zeros(worlds, dtype=np.bool_)
        self.ending = Ending(none, none, none)
        self.state = State(
            motion=np.zeros((worlds, 1 + team, 6)),
            goal=np.zeros((worlds, 3)),
            tick=np.zeros(worlds, dtype=np.int64),
            thrust=np.zeros((worlds, team, 2)),
            working=np.ones((worlds, team), dtype=np.bool_),
            slot=np.zeros((worlds, team), dtype=np.complex128),
            side=np.ones(worlds),
            touching=np.zeros((worlds, team, 2), dtype=np.bool_),
            closed=none.copy(),
            occupied_ticks=np.zeros(worlds, dtype=np.int64),
            anchored=none.copy(),
        )
        self._relative_goal = np.zeros((worlds, 3))
        self.relations = _relations(self.state)
        self._occupied = formation.occupied(self.relations, self.params.task)
        self._potentials = self._potentials_of(self.relations, self.state)
        self._tally = metrics.Tallies(self.relations, self.state)

    def reset(
        self, mask: Bool | None = None, seeds: Sequence[int | None] | None = None, goal: Any = None
    ) -> Observation:
        """Begins new episodes in some worlds or all.

        Args:
            mask: (W,) bool, worlds to reset; None resets all.
            seeds: One seed for each world that is reset; with None a world continues with its
                own Generator.
            goal: (3,) pose that replaces the goals of these episodes, m, m, rad.

        Returns:
            Observations (n, A, K) of the worlds that were reset.

        Raises:
            ValueError: a mask or seeds of the wrong shape, a bad seed or goal.
        """
        index = self._rows_to_reset(mask)
        self._seed(index, [None] * len(index) if seeds is None else seeds)
        if goal is not None:
            goal = np.array(self.params.checked_goal(goal))
        self.state = copied(self.state)  # What was handed out stays as it was.
        for world in index:
            self._begin(int(world), goal)
        self._restart(index)
        some = rows(self.state, index)
        put_rows(self._tally, index, metrics.Tallies(rows(self.relations, index), some))
        self._steps_over[index] = 0
        fails = (self._failure_tick != metrics.NEVER).any()
        self._roles_may_change = bool(fails or not self.state.anchored.all())
        self._sensors.reset(index, some.motion, self._rngs)
        return self._observe(index)

    def _rows_to_reset(self, mask: Bool | None) -> np.ndarray:
        if mask is None:
            return np.arange(self.num_worlds)
        mask = np.asarray(mask)
        if mask.shape != (self.num_worlds,) or mask.dtype != np.bool_:
            raise ValueError(
                f"mask of shape {mask.shape} and type {mask.dtype}: must be bool of shape "
                f"({self.num_worlds},)"
            )
        return np.flatnonzero(mask)

    def _seed(self, index: np.ndarray, seeds: Sequence[int | None]) -> None:
        if len(seeds) != len(index):
            raise ValueError(f"{len(seeds)} seeds for {len(index)} worlds: give one for each")
        for seed in seeds:
            whole = isinstance(seed, int | np.integer) and not isinstance(seed, bool)
            if seed is not None and not (whole and seed >= 0):
                raise ValueError(f"seed = {seed!r}: must be a whole number of at least 0 or None")
        for world, seed in zip(index, seeds, strict=True):
            if seed is not None or world not in self._rngs:
                self._rngs[world] = np.random.default_rng(seed)

    def _begin(self, world: int, goal: Float | None) -> None:
        """Places one world at the beginning of an episode."""
        state, grasped = self.state, self._task.starts_grasped
        start = self._initial_states(self.params, self._rngs[world], goal)
        self._dynamics.place(world, start)
        self._failure_tick[world] = start.failure_tick
        self._relative_goal[world] = start.goal
        state.motion[world] = start.motion
        state.goal[world] = start.goal
        state.tick[world] = state.occupied_ticks[world] = 0
        state.thrust[world] = 0.0
        state.working[world] = True
        state.touching[world] = False
        state.side[world] = start.side
        state.closed[world] = grasped
        state.anchored[world] = grasped or self.params.task.goal_anchor == "world"
        self._assign(world)

    def _assign(self, world: int) -> None:
        slot, state = self.state.slot, rows(self.state, world)
        slot[world] = formation.assign_slots(self.params, state.motion, state.working, state.side)

    def step(self, action: Any) -> TimeStep:
        """Advances every world by one control step and returns its ``TimeStep``.

        Args:
            action: (W, A, 2), finite; clipped to [-1, 1]. Speed and yaw rate with
                ``action_mode="tracking"``, left and right thruster with "thrusters".

        Raises:
            RuntimeError: a world was never reset, or was stepped after its end.
            ValueError: an action of the wrong shape, or not finite.
        """
        self._check_running()
        command = self._checked(action)
        before = State(**vars(self.state))
        self._move(command)
        state = self.state
        state.tick = state.tick + 1
        self.relations = _relations(state)
        self._judge_closure()
        flow = water.current(self.params.water, self.relations.position[:, 0])
        self.ending = termination.ending(self.relations, state, flow, self.params)
        self._steps_over += self.ending.terminated | self.ending.truncated | (self._steps_over > 0)

        after = self._potentials_of(self.relations, state)
        transition = Transition(self.relations, before, state, self.ending, self.params)
        terms = reward.weighted(self._task.reward, self._potentials, after, transition)
        rewards = reward.total(self._task.reward, terms, self.params.num_boats)
        self._potentials = after
        metrics.update(self._tally, transition, self._occupied, rewards)
        self._change_roles()
        return TimeStep(self._observe(), rewards, self.ending, terms)

    def _check_running(self) -> None:
        if (self._steps_over > 1).any():
            world = int(np.argmax(self._steps_over))
            raise RuntimeError(
                f"step: world {world} has not been reset since its episode ended or the "
                "simulation was made; call reset first"
            )

    def _checked(self, action: Any) -> Float:
        try:
            command = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise TypeError(f"action of type {type(action).__name__}: give numbers") from error
        shape = self.state.thrust.shape
        if command.shape != shape:
            raise ValueError(f"action of shape {command.shape}: must be {shape}")
        if not np.isfinite(command).all():
            world, boat, _ = np.argwhere(~np.isfinite(command))[0]
            raise ValueError(
                f"action {command[world, boat]} of boat {boat} in world {world}: must be finite; "
                "check the policy for NaN"
            )
        return np.minimum(np.maximum(command, -1.0), 1.0)

    def _move(self, command: Float) -> None:
        """Physics and sensing of one control step."""
        clock, state = self.params.clock, self.state
        for _ in range(clock.sensing // clock.control):
            motion = self._dynamics.advance(command, state.working, clock.physics // clock.sensing)
            motion[..., 2] = wrap(motion[..., 2])
            self._sensors.sense(motion)
        state.motion = motion
        state.thrust = self._dynamics.motors.thrust.copy()
        state.touching = self._dynamics.basin.touching()

    def _judge_closure(self) -> None:
        """Updates which boats occupy their slots, ``closed`` and ``occupied_ticks``."""
        state, task = self.state, self.params.task
        self._occupied = formation.occupied(self.relations, task)
        formed = formation.everyone(self._occupied, state.working)
        state.closed = formation.closure(self.relations, formed, state.closed, state.working, task)
        state.occupied_ticks = (state.occupied_ticks + 1) * formed

    def _change_roles(self) -> None:
        """Applies failures, new slots and the anchoring of goals from the next step on."""
        state = self.state
        swaps = formation.misassigned(self.relations, state.closed, state.working, self.params.task)
        if not (self._roles_may_change or swaps.any()):
            return
        fails = self._failure_tick == state.tick[:, None]
        anchors = state.closed & ~state.anchored
        changed = np.flatnonzero(fails.any(axis=1) | anchors | swaps)
        if not len(changed):
            return
        self.state = state = copied(state)
        state.working &= ~fails
        for world in map(int, changed):
            if fails[world].any() or swaps[world]:
                self._assign(world)
            if anchors[world]:
                state.goal[world] = _anchored(self._relative_goal[world], state.motion[world, 0])
        state.anchored |= anchors
        self._restart(changed)
        metrics.restart_errors(self._tally, self.relations, np.flatnonzero(anchors))

    def _restart(self, index: np.ndarray) -> None:
        """Derives again what depends on slots and goals, so that their change earns no reward."""
        state = rows(self.state, index)
        relations = _relations(state)
        put_rows(self.relations, index, relations)
        self._occupied[index] = formation.occupied(relations, self.params.task)
        self._potentials[index] = self._potentials_of(relations, state)

    def _potentials_of(self, relations: Relations, state: State) -> Float:
        return reward.potentials(self._task.reward, relations, state, self.params)

    @property
    def sensed(self) -> Sensed:
        """What the boats know now: the input of every policy."""
        known = {name: getattr(self.state, name) for name in SITUATION}
        return Sensed(measured=self._sensors.measured, estimate=self._sensors.estimate, **known)

    def _observe(self, index: np.ndarray | None = None) -> Observation:
        sensed, relations, occupied = self.sensed, self.relations, self._occupied
        if index is not None:
            sensed, relations = rows(sensed, index), rows(relations, index)
            occupied = occupied[index]
        if not self.params.sensors.exact:
            relations = relate(sensed.estimate, sensed.goal, sensed.slot, sensed.side)
            occupied = formation.occupied(relations, self.params.task)
        return observation.observe(self._features, sensed, relations, occupied, self.params)

    def summary(self) -> dict[str, Any]:
        """Returns the metrics of the episodes so far, each (W,); see ``metrics.summary``."""
        return metrics.summary(self._tally, self.state, self.relations, self.ending, self.params)

    def current(self, position: Float) -> Float:
        """Returns the velocity (..., 2) of the water at positions (..., 2) of a world, m/s."""
        points = plane(np.ascontiguousarray(position, dtype=np.float64))
        return xy(water.current(self.params.water, points))


def _relations(state: State) -> Relations:
    return relate(state.motion, state.goal, state.slot, state.side)


def _anchored(relative: Float, vessel: Float) -> Float:
    """Returns a goal (3,) that is given in the frame of the vessel's motion (6,), in the world."""
    turn = np.exp(1j * vessel[2])
    point = vessel[0] + 1j * vessel[1] + turn * (relative[0] + 1j * relative[1])
    return np.array([point.real, point.imag, float(wrap(vessel[2] + relative[2]))])
