"""Runs policies on seeded episodes; one row an episode.

An episode is its seed: goals, starts, disturbances and noise follow from it, so that every
policy meets the same ones. Every world computes alone at the origin of a Space of its own, so
that a row does not depend on which other episodes ran beside it.

A policy that raises, or whose action is of no use, fails the episode in which it does so, and
no other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.types import Action, Bool, Float, Observation
from baselines import dubins
from baselines.policy import Policy

TRACK_EVERY = 2
"""Control ticks between two poses of a recorded track."""


@dataclass(frozen=True)
class Label:
    """What a row says of itself besides what happened.

    Attributes:
        policy: its name.
        training_seed: which of its trainings it comes from; None where there is one or none.
        arm: the condition's name in its suite.
        scenario: what disturbed the world.
    """

    policy: str
    training_seed: int | None = None
    arm: str = ""
    scenario: str = "nominal"


@dataclass(frozen=True)
class Episode:
    """One row of ``episodes.csv``; None where a column does not apply.

    Attributes:
        seed: of the episode.
        policy: its name.
        training_seed: which of the policy's trainings it comes from.
        arm: the condition's name in its suite.
        task: "approach", "push" or "transport".
        scenario: what disturbed the world.
        num_boats: team size.
        success: whether the task was done in time.
        cause: of a failure; see ``causes``.
        goal_x: of the goal from where the vessel began, m.
        goal_y: the same, m.
        goal_heading: the same, rad.
        position_error: of the vessel at the end, m.
        heading_error: of the vessel at the end, signed, rad.
        min_position_error: smallest distance of the vessel to its goal, m.
        heading_error_at_min: signed, at the instant of smallest distance, rad.
        time_to_closure: until all slots were held, s.
        closure_spread: between the first and the last boat to hold its slot, s.
        time_to_goal: until the delivery, s.
        duration: of the episode, s.
        path_length_ratio: way of the vessel over the shortest path of bounded curvature.
        effort: seconds of full thrust, averaged over the motors.
        collisions: times that a boat began to touch another one or a wall.
        closure_lost: times that closure was lost.
        episode_return: sum of the team's mean reward.
        error: what was wrong with the policy where that ended the episode.
    """

    seed: int
    policy: str
    training_seed: int | None
    arm: str
    task: str
    scenario: str
    num_boats: int
    success: bool
    cause: str | None
    goal_x: float | None
    goal_y: float | None
    goal_heading: float | None
    position_error: float | None
    heading_error: float | None
    min_position_error: float | None
    heading_error_at_min: float | None
    time_to_closure: float | None
    closure_spread: float | None
    time_to_goal: float | None
    duration: float
    path_length_ratio: float | None
    effort: float
    collisions: int
    closure_lost: int
    episode_return: float
    error: str | None


COLUMNS = tuple(f.name for f in fields(Episode))
NOT_OF_APPROACH = (
    *("goal_x", "goal_y", "goal_heading", "position_error", "heading_error"),
    *("min_position_error", "heading_error_at_min", "time_to_goal", "path_length_ratio"),
)
NOT_OF_PUSH = ("time_to_closure", "closure_spread")
CAUSES = (
    *("policy error", "strayed", "no closure", "grasp not held"),
    *("never near", "heading off", "not settled"),
)
"""Why an episode failed, each excluding those before it: the policy raised or gave an action of
no use; a body left the arena; the vessel was never in closure; the slots were not held for long
enough (approach); the vessel never came within the tolerance of position; its heading was off
when it was nearest; it was there, but not at rest."""


@dataclass(frozen=True)
class Trajectory:
    """All that a learner may want of one episode of T steps.

    Attributes:
        observation: (T + 1, A, K) float32; that at the end included.
        action: (T, A, 2) float32 in [-1, 1].
        reward: (T, A).
        motion: (T + 1, B, 6) of the true state; see ``State``.
        working: (T + 1, A) whether a boat's thrusters work.
        goal: (T + 1, 3) m, m, rad.
        terminated: whether the episode ended by what happened in it, not by the clock.
    """

    observation: Observation
    action: Action
    reward: Float
    motion: Float
    working: Bool
    goal: Float
    terminated: bool


@dataclass(frozen=True)
class Track:
    """Where the hulls of one episode were.

    Attributes:
        episode: its row.
        poses: (T, B, 3) x m, y m, heading rad, row 0 of B the vessel; one every
            ``TRACK_EVERY`` control ticks, and the last.
        goal: (3,) pose, m, m, rad.
        failed_at: (A,) time at which a boat's thrusters died, s; inf never.
        trajectory: all steps, where that was asked for.
    """

    episode: Episode
    poses: Float
    goal: Float
    failed_at: Float
    trajectory: Trajectory | None = None


class PolicyError(Exception):
    """A policy raised; it is not known in which of the worlds beside each other.

    Attributes:
        seeds: of their episodes.
    """

    def __init__(self, seeds: Sequence[int]) -> None:
        super().__init__(*seeds)
        self.seeds = seeds


def run(
    make_policy: Callable[[EnvParams], Policy],
    params: EnvParams,
    seeds: Sequence[int],
    num_envs: int,
    label: Label = Label("unnamed"),
    record: bool = False,
) -> Iterator[Track]:
    """Runs one policy on the episodes of these seeds; yields them as they end.

    Args:
        make_policy: from parameters to a policy.
        params: of the environment.
        seeds: one an episode.
        num_envs: worlds side by side.
        label: what the rows say of themselves.
        record: whether tracks carry trajectories.

    Yields:
        One track an episode, in the order in which they end.
    """
    left = dict.fromkeys(seeds)

    def some(seeds: Sequence[int], worlds: int) -> Iterator[Track]:
        for track in _Worlds(make_policy, params, label, record).run(seeds, worlds):
            del left[track.episode.seed]
            yield track

    while left:
        try:
            yield from some(list(left), num_envs)
        except PolicyError as failure:
            # Alone, what a policy does in an episode does not depend on the others.
            for seed in failure.seeds:
                yield from some([seed], 1)


@dataclass
class _Log:
    """What has been kept of the running episode of one world."""

    failed_at: Float
    poses: list[Float] = field(default_factory=list)
    steps: dict[str, list[Any]] = field(default_factory=dict)

    def add(self, **values: Any) -> None:
        for name, value in values.items():
            self.steps.setdefault(name, []).append(np.copy(value))


class _Worlds:
    """Worlds side by side, and what their episodes leave."""

    def __init__(
        self,
        make_policy: Callable[[EnvParams], Policy],
        params: EnvParams,
        label: Label,
        record: bool,
    ) -> None:
        self._policy, self._params = make_policy(params), params
        self._label, self._record = label, record

    def run(self, seeds: Sequence[int], num_envs: int) -> Iterator[Track]:
        """See ``run``.

        Raises:
            PolicyError: the policy raised beside other episodes.
        """
        worlds = min(num_envs, len(seeds))
        self._simulation = simulation = Simulation(self._params, worlds, worlds_per_space=1)
        self._logs = [self._fresh_log() for _ in range(worlds)]
        queue = iter(seeds[worlds:])
        self._running = running = list[int | None](seeds[:worlds])
        observation = simulation.reset(seeds=running)
        fresh, memory = np.ones(worlds, dtype=np.bool_), None
        while any(seed is not None for seed in running):
            self._keep_state(observation)
            action, memory, errors = self._decide(observation, memory, fresh)
            step = simulation.step(action)
            self._keep_step(action, step.reward)
            observation = step.observation
            fresh = step.ending.terminated | step.ending.truncated
            fresh[list(errors)] = True
            if not fresh.any():
                continue
            self._keep_state(observation, fresh)
            summary = simulation.summary()
            for world in map(int, np.flatnonzero(fresh)):
                seed, error = running[world], errors.get(world)
                if seed is not None:
                    yield self._track(seed, world, summary, error)
                self._logs[world] = self._fresh_log()
                running[world] = next(queue, None)
            # A world with nothing left to do repeats the last seed, unheard.
            ended = np.flatnonzero(fresh)
            again = [running[w] if running[w] is not None else seeds[-1] for w in ended]
            observation[fresh] = simulation.reset(mask=fresh, seeds=again)

    def _fresh_log(self) -> _Log:
        return _Log(np.full(self._params.num_boats, np.inf))

    def _decide(
        self, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any, dict[int, str]]:
        """An action, the policy's memory, and what is wrong with it in which worlds."""
        shape = (*self._simulation.state.thrust.shape[:2], 2)
        try:
            action, memory = self._policy.act(self._simulation.sensed, observation, memory, fresh)
            action = checked_action(action, shape)
        except Exception as error:
            if len(fresh) > 1:
                seeds = [seed for seed in self._running if seed is not None]
                raise PolicyError(seeds) from error
            text = f"{type(error).__name__}: {error}"
            return np.zeros(shape, dtype=np.float32), None, {0: text}
        bad: Bool = ~np.asarray(np.isfinite(action).all(axis=(1, 2)))
        tick = self._simulation.state.tick
        errors = {w: f"action not finite at tick {tick[w]}" for w in map(int, np.flatnonzero(bad))}
        return np.where(bad[:, None, None], np.float32(0.0), action), memory, errors

    def _keep_state(self, observation: Observation, ended: Bool | None = None) -> None:
        """Keeps where worlds are: before a step those that are due, at their end others."""
        state = self._simulation.state
        due = state.tick % TRACK_EVERY == 0 if ended is None else ended
        for world in map(int, np.flatnonzero(due)):
            self._logs[world].poses.append(state.motion[world, :, :3].copy())
        for world in map(int, np.flatnonzero(~state.working.all(axis=1))):
            log, now = self._logs[world], state.tick[world] / self._params.clock.control
            since = np.where(state.working[world], np.inf, now)
            log.failed_at = np.minimum(log.failed_at, since)
        if self._record:
            for world in range(len(due)) if ended is None else map(int, np.flatnonzero(ended)):
                self._logs[world].add(
                    observation=observation[world],
                    motion=state.motion[world],
                    working=state.working[world],
                    goal=state.goal[world],
                )

    def _keep_step(self, action: Action, reward: Float) -> None:
        if self._record:
            for world, log in enumerate(self._logs):
                log.add(action=np.clip(action[world], -1.0, 1.0), reward=reward[world])

    def _track(self, seed: int, world: int, summary: dict[str, Any], error: str | None) -> Track:
        ended = {key: value[world].item() for key, value in summary.items()}
        state, log = self._simulation.state, self._logs[world]
        goal = state.goal[world].copy()
        ended["duration"] = state.tick[world].item() / self._params.clock.control
        episode = _row(seed, self._label, self._params, ended, goal, state.side[world], error)
        trajectory = None
        if self._record and not error:
            terminated = bool(self._simulation.ending.terminated[world])
            arrays = {name: np.array(values) for name, values in log.steps.items()}
            trajectory = Trajectory(**arrays, terminated=terminated)
        return Track(episode, np.array(log.poses), goal, log.failed_at, trajectory)


def checked_action(action: Any, shape: tuple[int, ...]) -> Action:
    """An action as float32 of the shape (W, A, 2).

    Raises:
        ValueError: another shape.
        TypeError: not numbers.
    """
    try:
        array = np.asarray(action, dtype=np.float32)
    except (TypeError, ValueError) as error:
        raise TypeError(f"action of type {type(action).__name__}: give numbers") from error
    if array.shape != shape:
        raise ValueError(f"action of shape {array.shape}: must be {shape}, as (worlds, boats, 2)")
    return array


def _row(
    seed: int,
    label: Label,
    params: EnvParams,
    ended: dict[str, Any],
    goal: Float,
    side: float,
    error: str | None,
) -> Episode:
    task = params.task.name
    relative = goal if side > 0 else goal * (1.0, -1.0, -1.0)
    shortest = float(dubins.length(relative, params.vessel.length / 2))
    success = ended["is_success"] and error is None
    values: dict[str, Any] = {
        **ended,
        **vars(label),
        "seed": seed,
        "task": task,
        "num_boats": params.num_boats,
        "success": success,
        "cause": None if success else _cause(ended, params, error),
        **dict(zip(("goal_x", "goal_y", "goal_heading"), goal.tolist(), strict=True)),
        "path_length_ratio": ended["path_length"] / shortest if shortest > 0 else None,
        "error": error,
    }
    inapplicable = {"approach": NOT_OF_APPROACH, "push": NOT_OF_PUSH, "transport": ()}[task]
    row: dict[str, Any] = {
        column: None if column in inapplicable or _is_nan(values[column]) else values[column]
        for column in COLUMNS
    }
    return Episode(**row)


def _cause(ended: dict[str, Any], params: EnvParams, error: str | None) -> str:
    """Which of ``CAUSES`` a failed episode had."""
    task = params.task
    if error is not None:
        return "policy error"
    if ended["strayed"]:
        return "strayed"
    if task.name != "push" and _is_nan(ended["time_to_closure"]):
        return "no closure"
    if task.name == "approach":
        return "grasp not held"
    if ended["min_position_error"] > task.position_tolerance:
        return "never near"
    if abs(ended["heading_error_at_min"]) > task.heading_tolerance:
        return "heading off"
    return "not settled"


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)
