"""Runs policies on seeded episodes, many side by side.

An episode follows from its seed: goal, initial state, disturbances and noise. So every policy
meets the same episodes. Every world has a Pymunk Space of its own, so that no episode depends on
which others run side by side.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.types import Float, Observation, State
from baselines.policy import MakePolicy
from baselines.rollout import episodes
from baselines.rollout.episodes import POSE_LOG_EVERY, Label, PoseLog, Trajectory
from baselines.rollout.guard import Guard, PolicyError
from baselines.rollout.loop import IDLE, Tick, rollout


def run(
    make_policy: MakePolicy,
    params: EnvParams,
    seeds: Sequence[int],
    num_envs: int,
    label: Label = Label("unnamed"),  # noqa: B008 (frozen)
    record: bool = False,
) -> Iterator[PoseLog]:
    """Yields a log of each seed's episode, run with one policy, in the order in which they end.

    A policy that cannot be made, that raises, or whose action is not finite numbers of the right
    shape, fails the episode in which it does so, and no other; see ``guard``.

    Args:
        make_policy: policy factory.
        params: parameters of the environment.
        seeds: one an episode.
        num_envs: worlds side by side.
        label: names of policy and condition, for the rows.
        record: whether logs carry trajectories.

    Raises:
        ValueError: the environment takes discrete actions, which no policy gives.
    """
    if params.action_mode == "discrete":
        raise ValueError(
            "action_mode = 'discrete': policies give tracking actions, those of discrete learners "
            "too; leave action_mode out"
        )
    left, recorder = dict.fromkeys(seeds), partial(_Recorder, params, label, record)

    def episodes_of(seeds: Sequence[int], worlds: int) -> Iterator[PoseLog]:
        simulation = Simulation(params, min(worlds, len(seeds)), num_threads=1)
        for log in _run(Guard(make_policy, params), simulation, seeds, recorder):
            del left[log.episode.seed]
            yield log

    while left:
        try:
            yield from episodes_of(list(left), num_envs)
        except PolicyError:
            # Seeds are taken in turn, so the first ones that are left were running. Alone, what a
            # policy does in an episode does not depend on the others.
            for seed in list(left)[:num_envs]:
                yield from episodes_of([seed], 1)


class _Recorder:
    """What is kept of the running episode of one world; with ``record``, its trajectory too."""

    def __init__(self, params: EnvParams, label: Label, record: bool, world: int) -> None:
        self._params, self._label, self._record, self._world = params, label, record, world
        self._poses: list[Float] = []
        self._failed_at = np.full(params.num_boats, np.inf)
        self._steps: dict[str, list[Any]] = defaultdict(list)

    def add(self, tick: Tick) -> None:
        """Keeps what a log wants of one step."""
        if tick.state.tick[self._world] % POSE_LOG_EVERY == 0:
            self._poses.append(tick.state.motion[self._world, :, :3].copy())
        if self._record:
            self._keep(tick.state, tick.observation, action=tick.action, reward=tick.step.reward)

    def note_failures(self, after: State) -> None:
        """Keeps when thrusters were first found to have failed."""
        now, failed = after.tick[self._world] / self._params.clock.control, self._failed_at
        np.minimum(failed, now, out=failed, where=~after.working[self._world])

    def log(self, tick: Tick, after: State, ended: dict[str, Any]) -> PoseLog:
        """Returns the log of the episode, whose last tick it was; see ``episodes.row``."""
        world = self._world
        self._poses.append(after.motion[world, :, :3].copy())
        goal = after.goal[world].copy()
        ended["duration"] = after.tick[world].item() / self._params.clock.control
        row = episodes.row(self._label, self._params, ended, goal, after.side[world])
        trajectory = None
        if self._record and not row.error:
            self._keep(after, tick.step.observation)
            arrays = {name: np.array(values) for name, values in self._steps.items()}
            arrays["action"] = np.clip(arrays["action"], -1.0, 1.0)
            arrays["obstacle"] = after.obstacle[world].copy()
            terminated = bool(tick.step.ending.terminated[world])
            trajectory = Trajectory(**arrays, terminated=terminated)
        hulls = after.obstacle[world].copy(), after.boat_size[world].copy()
        return PoseLog(row, np.array(self._poses), goal, self._failed_at, *hulls, trajectory)

    def _keep(self, state: State, observation: Observation, **step: Float) -> None:
        truth = {name: getattr(state, name) for name in ("motion", "working", "goal")}
        for name, values in {"observation": observation, **truth, **step}.items():
            self._steps[name].append(values[self._world].copy())


def _run(
    policy: Guard, simulation: Simulation, seeds: Sequence[int], make: partial[_Recorder]
) -> Iterator[PoseLog]:
    """Yields logs as ``run`` does; a policy that raises in several worlds ends them all."""
    recorders = [make(world) for world in range(simulation.num_worlds)]
    for tick in rollout(simulation, policy.act, seeds):
        for recorder in recorders:
            recorder.add(tick)
        for world in map(int, np.flatnonzero(~simulation.state.working.all(axis=1))):
            recorders[world].note_failures(simulation.state)
        tick.over[list(policy.errors)] = True
        if not tick.over.any():
            continue
        summary = simulation.summary()
        for world in map(int, np.flatnonzero(tick.over)):
            recorder, recorders[world] = recorders[world], make(world)
            if tick.episode[world] != IDLE:
                ended = {name: value[world].item() for name, value in summary.items()}
                ended["seed"] = seeds[tick.episode[world]]
                ended["error"] = policy.errors.get(world)
                yield recorder.log(tick, simulation.state, ended)
