"""The environment, batched: many worlds advance by one control step at a time.

The adapters in ``envs`` only translate.
"""

import pickle
from collections.abc import Sequence
from typing import Any

import numpy as np

from asv_env import arguments, threads
from asv_env.checks import Whole, called
from asv_env.geometry import plane, xy
from asv_env.numerics import numerics
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import grouping
from asv_env.physics import water
from asv_env.physics.dynamics import Dynamics
from asv_env.sensing import observation
from asv_env.sensing.knowledge import Knowledge
from asv_env.tasks import initial_state, metrics, standing
from asv_env.tasks.formation import Relations, relate
from asv_env.tasks.referee import Referee
from asv_env.tasks.standing import Events
from asv_env.tasks.task import InitialStates, Task
from asv_env.text import shown
from asv_env.types import (
    Bool,
    Ending,
    Float,
    InitialState,
    Observation,
    Sensed,
    Snapshot,
    State,
    TimeStep,
    copied,
    frozen,
)

MOST_WORLDS = 1_000_000  #: largest number of worlds
REMEMBERED = (
    *("_state", "_ending", "_rngs", "_failure_tick", "_failure_delay", "_steps_over"),
    *("_relative_goal", "_roles_may_change", "some_over"),
)  #: names of what a simulation itself remembers from step to step


class Simulation:
    """``num_worlds`` independent worlds of one task.

    W worlds, A boats, K features: observation (W, A, K) float32, action (W, A, 2) in [-1, 1],
    reward (W, A). Every world has its own random Generator, and worlds do not affect each other.
    After the end of its episode a world can be stepped once more, with no meaning; then it has
    to be reset.

    A simulation can be copied and pickled at any time; the copy continues to the bit as the
    original does. ``snapshot`` and ``restore`` do the same faster, for a search over actions.

    Args:
        params: Parameters of the environment, the task among them; see ``presets.make_params``.
        num_worlds: W.
        num_threads: Number of threads over which the worlds' physics is spread; None takes all
            cores for large batches and one thread for small ones. Results do not depend on it.
        initial_states: Distribution of initial states that replaces the task's, such as a
            curriculum.
    """

    def __init__(
        self,
        params: EnvParams,
        num_worlds: int = 1,
        num_threads: int | None = None,
        initial_states: InitialStates | None = None,
    ) -> None:
        worlds = Whole(1, MOST_WORLDS)
        self.params = params
        self.num_worlds = worlds.checked("num_worlds", num_worlds)
        self.num_threads = threads.checked(num_threads, self.num_worlds)
        self._task: Task = params.definition
        self._initial_states = initial_states or self._task.initial_states
        self._dynamics = Dynamics(params, self.num_worlds, self.num_threads)
        self._features = observation.features(params)
        self._rngs: dict[int, np.random.Generator] = {}
        self._failure_tick = np.full((self.num_worlds, params.num_boats), metrics.NEVER)
        # Ticks from the first closure to a failure, of worlds in which it has yet to be formed.
        self._failure_delay = self._failure_tick.copy()
        self._steps_over = np.full(self.num_worlds, 2)
        #: whether any world has to be reset, or was not yet
        self.some_over = True
        self._roles_may_change = False
        self._make_records()

    def _make_records(self) -> None:
        """Allocates the records of all worlds; ``reset`` fills them."""
        worlds, team = self.num_worlds, self.params.num_boats
        none = np.zeros(worlds, dtype=np.bool_)
        state = State(
            motion=np.zeros((worlds, 1 + team, 6)),
            goal=np.zeros((worlds, 3)),
            tick=np.zeros(worlds, dtype=np.int64),
            thrust=np.zeros((worlds, team, 2)),
            working=np.ones((worlds, team), dtype=np.bool_),
            slot=np.zeros((worlds, team), dtype=np.complex128),
            side=np.ones(worlds),
            occupied=np.zeros((worlds, team), dtype=np.bool_),
            touching=np.zeros((worlds, team, 2), dtype=np.bool_),
            closed=none,
            obstacle=np.zeros((worlds, int(grouping(self.params).groups[-1]), 5)),
            contact_force=np.zeros((worlds, team)),
            gust=np.zeros((worlds, 2)),
            boat_size=np.ones((worlds, team)),
            aground=none,
            occupied_ticks=np.zeros(worlds, dtype=np.int64),
            delivered_ticks=np.zeros(worlds, dtype=np.int64),
            anchored=none,
        )
        self._ending = frozen(Ending(none, none, none))
        self._state = frozen(state)
        self._relative_goal = np.zeros((worlds, 3))
        self._referee = Referee(self.params, worlds, self.num_threads)
        self._referee.begin(np.arange(worlds), state)
        self._knowledge = Knowledge(self.params, state, self.num_threads)

    @property
    def state(self) -> State:
        """True state, read-only; the next step makes a new one."""
        return self._state

    @property
    def relations(self) -> Relations:
        """Relations of the true motion, read-only."""
        state = self._state
        return frozen(relate(state.motion, state.goal, state.slot, state.side))

    @property
    def ending(self) -> Ending:
        """Whether and why episodes ended at the last step, read-only."""
        return self._ending

    @property
    def sensed(self) -> Sensed:
        """What the boats know now, the input of every policy: copies, for it to write to.

        Boats with sensors of their own have a row each, see ``Sensed``.
        """
        return copied(self._knowledge.sensed)

    @numerics()
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
        index = arguments.worlds_to_reset(mask, self.num_worlds)
        checked = arguments.checked_seeds(seeds, len(index))
        goal = None if goal is None else self.params.checked_goal(goal)
        worlds = index.tolist()
        starts = [
            self._sample(world, seed, goal) for world, seed in zip(worlds, checked, strict=True)
        ]
        state = copied(self._state)
        for world, start in zip(worlds, starts, strict=True):
            self._begin(state, world, start)
        standing.begun(state, state.motion, index, self.params)
        self._state = frozen(state)
        others = np.ones(self.num_worlds, dtype=np.bool_)
        others[index] = False
        self._ending = frozen(self._ending.within(others))
        self._referee.begin(index, self._state)
        self._steps_over[index] = 0
        self.some_over = bool(self._steps_over.any())
        fails = (np.maximum(self._failure_tick, self._failure_delay) != metrics.NEVER).any()
        self._roles_may_change = bool(fails or not state.anchored.all())
        self._knowledge.reset(index, self._state, self._rngs)
        # After the sensors, whose noise is the same with and without gusts.
        self._state = self._dynamics.blown(self._state, index, self._rngs)
        return self._observe(index)

    def _sample(self, world: int, seed: int | None, goal: Sequence[float] | None) -> InitialState:
        """Samples the initial state of one world, with its own Generator or one of a seed."""
        if seed is not None or world not in self._rngs:
            self._rngs[world] = np.random.default_rng(seed)
        given = None if goal is None else np.array(goal)
        function, task = self._initial_states, self._task.name
        sampled = self.params, self._rngs[world], given
        start = called("initial states of task", task, function, *sampled)
        return initial_state.checked(start, self.params, self._rngs[world])

    def _begin(self, state: State, world: int, start: InitialState) -> None:
        """Places one world of a state at the beginning of an episode, in place."""
        self._dynamics.place(world, start)
        at_once = self.params.variation.failure_clock == "start"
        self._failure_tick[world] = start.failure_tick if at_once else metrics.NEVER
        self._failure_delay[world] = metrics.NEVER if at_once else start.failure_tick
        self._relative_goal[world] = start.goal
        state.motion[world] = start.motion
        state.goal[world] = start.goal
        state.tick[world] = state.occupied_ticks[world] = state.delivered_ticks[world] = 0
        state.thrust[world] = 0.0
        state.working[world] = self._failure_tick[world] != 0
        state.touching[world] = False
        state.contact_force[world] = 0.0
        state.aground[world] = False
        state.obstacle[world], state.boat_size[world] = start.obstacle, start.boat_size
        state.side[world] = start.side
        anchored = self.params.task.goal_anchor == "world"
        state.anchored[world] = anchored or self._task.starts_grasped

    @numerics()
    def step(self, action: Any) -> TimeStep:
        """Advances every world by one control step and returns its ``TimeStep``.

        Args:
            action: (W, A, 2), finite; clipped to [-1, 1]. Speed and yaw rate with
                ``action_mode="tracking"``, left and right thruster with "thrusters". With
                "discrete" (W, A), numbers of ``DISCRETE_ACTIONS``.

        Raises:
            RuntimeError: a world was never reset, or was stepped after its end.
            ValueError: an action of the wrong shape, not finite, or no number of an action.
        """
        self._check_running()
        checked = arguments.CHECKED_ACTION[self.params.action_mode]
        command = checked(action, self._state.working.shape)
        before = self._state
        moved = self._move(command)
        water = self._dynamics.water()
        judged = self._referee.tick(before, moved, water)
        self._state, self._ending, terms, rewards = judged
        ending = self._ending
        if self._referee.ended or self.some_over:
            self._steps_over += ending.terminated | ending.truncated | (self._steps_over > 0)
            self.some_over = True
        self._change_roles()
        return TimeStep(self._observe(), rewards, ending, terms)

    def _check_running(self) -> None:
        if self.some_over and (self._steps_over > 1).any():
            world = int(np.argmax(self._steps_over))
            raise RuntimeError(
                f"step: world {world} has not been reset since its episode ended or the "
                "simulation was made; call reset first"
            )

    def _move(self, command: Float) -> dict[str, Any]:
        """Physics and sensing of one control step; returns the fields of ``State`` it decides."""
        clock, dynamics = self.params.clock, self._dynamics
        command = dynamics.delayed(command)
        dynamics.begin()
        for _ in range(clock.sensing // clock.control):
            steps = clock.physics // clock.sensing
            motion = dynamics.advance(command, self._state.working, steps)
            self._knowledge.sense(motion)
        return {"motion": motion, **dynamics.felt()}

    def _change_roles(self) -> None:
        """Applies failures, new slots and the anchoring of goals from the next step on.

        Their change earns no reward. A goal is anchored when the team believes to be in closure, at
        the pose that it believes the vessel to have; see ``Knowledge.advance``.
        """
        state, knowledge, events = self._state, self._knowledge, None
        closed, vessel = knowledge.advance(state)
        if self._roles_may_change:
            fails = self._failures(state)
            anchors, goal = closed & ~state.anchored, state.goal.copy()
            for world in np.flatnonzero(anchors):
                goal[world] = standing.anchored(self._relative_goal[world], vessel[world])
            assigns = np.logical_or.reduce(fails, axis=1)
            events = Events(
                assigns, state.working & ~fails, state.anchored | anchors, goal, anchors
            )
        index = standing.NOWHERE
        if events is not None or self._referee.some_misassigned:
            now = state, state.motion, self._referee.misassigned
            self._state, index = standing.changed(*now, events, self.params)
        if len(index):
            anchored = index[:0] if events is None else np.flatnonzero(events.moved)
            self._referee.change(index, anchored, self._state)
        knowledge.change(events, self._state)

    def _failures(self, state: State) -> Bool:
        """Returns the boats (W, A) whose thrusters fail now."""
        due = state.closed[:, None] & (self._failure_delay != metrics.NEVER)
        if due.any():
            self._failure_tick[due] = (self._failure_delay + state.tick[:, None])[due]
            self._failure_delay[due] = metrics.NEVER
        fails: Bool = self._failure_tick == state.tick[:, None]
        return fails

    def _observe(self, index: np.ndarray | None = None) -> Observation:
        threads = self.num_threads if index is None else 1
        known = self._features, self._knowledge.sensed, self.params
        return observation.observe(*known, threads, index, not self.params.sensors.shared)

    def summary(self) -> dict[str, Any]:
        """Returns the metrics of the episodes so far, each (W,); see ``metrics.summary``."""
        return metrics.by_name(self.metrics())

    def metrics(self) -> list[metrics.Block]:
        """Returns the same by type: names (n,) and values (n, W)."""
        return self._referee.summary(self._state, self._ending)

    def snapshot(self) -> Snapshot:
        """Returns everything that the simulation remembers, for ``restore``.

        A distribution of initial states that was given, and functions of a task, belong to the
        user: what they remember is not part of it.
        """
        own = {name: vars(self)[name] for name in REMEMBERED}
        parts = self._referee, self._knowledge, self._dynamics
        memory = pickle.dumps((own, *(part.snapshot() for part in parts)))
        return Snapshot(self.params, self.num_worlds, memory)

    def restore(self, snapshot: Snapshot) -> None:
        """Returns to a snapshot, this simulation's or that of one with the same arguments.

        What follows is the same to the bit, as often as it is restored.

        Raises:
            TypeError: not a snapshot.
            ValueError: the snapshot is that of a simulation with other arguments.
        """
        if not isinstance(snapshot, Snapshot):
            raise TypeError(
                f"restore: {shown(snapshot)} is not a Snapshot, as ``snapshot()`` returns"
            )
        for name in ("num_worlds", "params"):
            mine, other = getattr(self, name), getattr(snapshot, name)
            if mine != other:
                raise ValueError(
                    f"restore: the snapshot has {name} = {shown(other)}, not {shown(mine)}"
                )
        own, referee, knowledge, dynamics = pickle.loads(snapshot.memory)
        vars(self).update(own)
        for record in (self._state, self._ending):
            frozen(record)
        self._referee.restore(referee)
        self._knowledge.restore(knowledge)
        self._dynamics.restore(dynamics)

    def __getstate__(self) -> dict[str, Any]:
        own = {"initial_states": self._initial_states, "num_threads": self.num_threads}
        return {**own, "snapshot": self.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        snapshot, initial_states = state["snapshot"], state["initial_states"]
        shape = snapshot.num_worlds, state["num_threads"]
        Simulation.__init__(self, snapshot.params, *shape, initial_states)
        self.restore(snapshot)

    def current(self, position: Float) -> Float:
        """Returns the velocity (..., 2) of the water at positions (..., 2) of a world, m/s."""
        points = plane(np.ascontiguousarray(position, dtype=np.float64))
        return xy(water.current(self.params.water, points))
