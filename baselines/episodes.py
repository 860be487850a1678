"""Runs policies on seeded episodes; one row an episode.

An episode is its seed: goals, starts, disturbances and noise follow from it, so that every
policy meets the same ones. Every world computes alone at the origin of a Space of its own, so
that a row does not depend on which other episodes ran beside it.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.types import Float
from baselines import dubins
from baselines.policy import Policy

TRACK_EVERY = 2
"""Control ticks between two poses of a recorded track."""


@dataclass(frozen=True)
class Episode:
    """One row of ``episodes.csv``; None where a column does not apply.

    Attributes:
        seed: of the episode.
        policy: its name.
        task: "approach", "push" or "transport".
        scenario: what disturbed the world.
        num_boats: team size.
        success: whether the task was done in time.
        position_error: of the vessel at the end, m.
        heading_error: of the vessel at the end, signed, rad.
        min_position_error: smallest distance of the vessel to its goal, m.
        heading_error_at_min: signed, at the instant of smallest distance, rad.
        time_to_closure: until all slots were held, s.
        closure_spread: between the first and the last boat to hold its slot, s.
        time_to_goal: until the delivery, s.
        path_length_ratio: way of the vessel over the shortest path of bounded curvature.
        effort: seconds of full thrust, averaged over the motors.
        collisions: times that a boat began to touch another one or a wall.
        closure_lost: times that closure was lost.
        episode_return: sum of the team's mean reward.
    """

    seed: int
    policy: str
    task: str
    scenario: str
    num_boats: int
    success: bool
    position_error: float | None
    heading_error: float | None
    min_position_error: float | None
    heading_error_at_min: float | None
    time_to_closure: float | None
    closure_spread: float | None
    time_to_goal: float | None
    path_length_ratio: float | None
    effort: float
    collisions: int
    closure_lost: int
    episode_return: float


COLUMNS = tuple(f.name for f in fields(Episode))
NOT_OF_APPROACH = (
    *("position_error", "heading_error", "min_position_error", "heading_error_at_min"),
    *("time_to_goal", "path_length_ratio"),
)
NOT_OF_PUSH = ("time_to_closure", "closure_spread")


@dataclass(frozen=True)
class Track:
    """Where the hulls of one episode were.

    Attributes:
        episode: its row.
        poses: (T, B, 3) x m, y m, heading rad, row 0 of B the vessel.
        goal: (3,) pose, m, m, rad.
    """

    episode: Episode
    poses: Float
    goal: Float


def run(
    make_policy: Callable[[EnvParams], Policy],
    name: str,
    scenario: str,
    params: EnvParams,
    seeds: Sequence[int],
    num_envs: int,
) -> Iterator[Track]:
    """Runs one policy on the episodes of these seeds; yields them as they end.

    Args:
        make_policy: from parameters to a policy.
        name: of the policy, for the rows.
        scenario: its name, for the rows.
        params: of the environment.
        seeds: one an episode.
        num_envs: worlds side by side.

    Yields:
        One track an episode, in the order in which they end.
    """
    worlds = min(num_envs, len(seeds))
    simulation = Simulation(params, worlds, worlds_per_space=1)
    policy = make_policy(params)
    queue = iter(seeds[worlds:])
    running: list[int | None] = list(seeds[:worlds])
    observation = simulation.reset(seeds=running)
    poses: list[list[Float]] = [[] for _ in range(worlds)]
    fresh, memory = np.ones(worlds, dtype=np.bool_), None
    while any(seed is not None for seed in running):
        _record(simulation, poses)
        action, memory = policy.act(simulation.sensed, observation, memory, fresh)
        step = simulation.step(action)
        observation = step.observation
        fresh = step.ending.terminated | step.ending.truncated
        if not fresh.any():
            continue
        summary = simulation.summary()
        for world in np.flatnonzero(fresh):
            seed = running[world]
            if seed is not None:
                ended = {key: value[world].item() for key, value in summary.items()}
                goal = simulation.state.goal[world].copy()
                side = float(simulation.state.side[world])
                episode = _row(seed, name, scenario, params, ended, goal, side)
                track = [*poses[world], simulation.state.motion[world, :, :3].copy()]
                yield Track(episode, np.array(track), goal)
            poses[world] = []
            running[world] = next(queue, None)
        # A world with nothing left to do repeats the last seed, unheard.
        again = [running[w] if running[w] is not None else seeds[-1] for w in np.flatnonzero(fresh)]
        observation[fresh] = simulation.reset(mask=fresh, seeds=again)


def _record(simulation: Simulation, poses: list[list[Float]]) -> None:
    state = simulation.state
    for world in np.flatnonzero(state.tick % TRACK_EVERY == 0):
        poses[world].append(state.motion[world, :, :3].copy())


def _row(
    seed: int,
    name: str,
    scenario: str,
    params: EnvParams,
    ended: dict[str, Any],
    goal: Float,
    side: float,
) -> Episode:
    task = params.task.name
    relative = goal if side > 0 else goal * (1.0, -1.0, -1.0)
    shortest = float(dubins.length(relative, params.vessel.length / 2))
    values: dict[str, Any] = {
        **ended,
        "seed": seed,
        "policy": name,
        "task": task,
        "scenario": scenario,
        "num_boats": params.num_boats,
        "success": ended["is_success"],
        "path_length_ratio": ended["path_length"] / shortest if shortest > 0 else None,
    }
    inapplicable = {"approach": NOT_OF_APPROACH, "push": NOT_OF_PUSH, "transport": ()}[task]
    row: dict[str, Any] = {
        column: None if column in inapplicable or _is_nan(values[column]) else values[column]
        for column in COLUMNS
    }
    return Episode(**row)


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and math.isnan(value)


def write_csv(path: Path, episodes: Sequence[Episode]) -> None:
    """Writes episodes to a CSV file, empty where a column does not apply."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(asdict(episode) for episode in episodes)
