"""Runs policies on seeded episodes, many side by side.

An episode is its seed: goals, starts, disturbances and noise follow from it, so that every
policy meets the same ones. Every world computes alone at the origin of a Space of its own, so
that nothing depends on which other episodes run beside it.

A policy that raises, or whose action is of no use, fails the episode in which it does so, and
no other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.types import Action, Bool, Float, Observation
from baselines.policy import Policy
from baselines.rollout import episodes
from baselines.rollout.episodes import POSE_LOG_EVERY, Label, PoseLog, Trajectory

UNNAMED = Label("unnamed")


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
    label: Label = UNNAMED,
    record: bool = False,
) -> Iterator[PoseLog]:
    """Runs one policy on the episodes of these seeds; yields them as they end.

    Args:
        make_policy: from parameters to a policy.
        params: of the environment.
        seeds: one an episode.
        num_envs: worlds side by side.
        label: what the rows say of themselves.
        record: whether logs carry trajectories.

    Yields:
        One log an episode, in the order in which they end.
    """
    left = dict.fromkeys(seeds)

    def some(seeds: Sequence[int], worlds: int) -> Iterator[PoseLog]:
        for log in _Worlds(make_policy, params, label, record).run(seeds, worlds):
            del left[log.episode.seed]
            yield log

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

    def run(self, seeds: Sequence[int], num_envs: int) -> Iterator[PoseLog]:
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
            self._keep_before(observation)
            action, memory, errors = self._decide(observation, memory, fresh)
            step = simulation.step(action)
            self._keep_step(action, step.reward)
            observation = step.observation
            fresh = step.ending.terminated | step.ending.truncated
            fresh[list(errors)] = True
            if not fresh.any():
                continue
            summary = simulation.summary()
            for world in map(int, np.flatnonzero(fresh)):
                self._keep_end(observation, world)
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
            text = " ".join(f"{type(error).__name__}: {error}".split())  # one line of a table
            return np.zeros(shape, dtype=np.float32), None, {0: text}
        bad: Bool = ~np.asarray(np.isfinite(action).all(axis=(1, 2)))
        tick = self._simulation.state.tick
        errors = {w: f"action not finite at tick {tick[w]}" for w in map(int, np.flatnonzero(bad))}
        return np.where(bad[:, None, None], np.float32(0.0), action), memory, errors

    def _keep_before(self, observation: Observation) -> None:
        """Keeps where all worlds are before a step."""
        tick = self._simulation.state.tick
        for world, log in enumerate(self._logs):
            if tick[world] % POSE_LOG_EVERY == 0:
                self._keep_poses(world)
            if self._record:
                self._keep_state(log, observation, world)

    def _keep_end(self, observation: Observation, world: int) -> None:
        """Keeps where a world is when its episode is over."""
        self._keep_poses(world)
        if self._record:
            self._keep_state(self._logs[world], observation, world)

    def _keep_poses(self, world: int) -> None:
        state, log = self._simulation.state, self._logs[world]
        log.poses.append(state.motion[world, :, :3].copy())

    def _keep_state(self, log: _Log, observation: Observation, world: int) -> None:
        state = self._simulation.state
        log.add(
            observation=observation[world],
            motion=state.motion[world],
            working=state.working[world],
            goal=state.goal[world],
        )

    def _keep_step(self, action: Action, reward: Float) -> None:
        """Keeps what a step did: when thrusters died and, of a trajectory, all of it."""
        state = self._simulation.state
        for world in map(int, np.flatnonzero(~state.working.all(axis=1))):
            now = state.tick[world] / self._params.clock.control
            since = np.where(state.working[world], np.inf, now)
            self._logs[world].failed_at = np.minimum(self._logs[world].failed_at, since)
        if self._record:
            for world, log in enumerate(self._logs):
                log.add(action=np.clip(action[world], -1.0, 1.0), reward=reward[world])

    def _track(self, seed: int, world: int, summary: dict[str, Any], error: str | None) -> PoseLog:
        ended = {key: value[world].item() for key, value in summary.items()}
        state, log = self._simulation.state, self._logs[world]
        goal = state.goal[world].copy()
        ended["duration"] = state.tick[world].item() / self._params.clock.control
        episode = episodes.row(
            seed, self._label, self._params, ended, goal, state.side[world], error
        )
        trajectory = None
        if self._record and not error:
            terminated = bool(self._simulation.ending.terminated[world])
            arrays = {name: np.array(values) for name, values in log.steps.items()}
            trajectory = Trajectory(**arrays, terminated=terminated)
        return PoseLog(episode, np.array(log.poses), goal, log.failed_at, trajectory)


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
