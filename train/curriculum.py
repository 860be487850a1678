"""What is learned first: easier episodes, which become the task's own as the training goes on.

Goals are nearer, boats begin beside the hull, episodes begin midway in one of the scripted policy;
goals lie ahead and are hardly turned, noise and variation are small.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from asv_env import geometry
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.presets import make_params
from asv_env.simulation import Simulation
from asv_env.tasks import starts
from asv_env.types import Float, InitialState
from baselines.learned import policy_file
from baselines.learned.phases import APPROACH, PUSH, PhasedPolicy
from baselines.rollout.loop import rollout
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.config import Config

MIRROR = np.array([1.0, -1.0, -1.0])
"""Poses in the mirror of the x axis: the vessel begins at the origin along it."""
BESIDE = 0.9
"""Width of the margin round the hull in which boats begin beside it, lengths of the vessel."""
TRIES = 200
"""Places that are tried for each boat there."""
LARGEST_STARTS = 16384
"""Number of midway states that are kept."""
KEEP_EVERY = 10
"""Control ticks between two states that are kept."""


def training_params(config: Config, team: int, scenario: str) -> EnvParams:
    """Parameters of the worlds of a group, which advance by one decision at a time."""
    limits: dict[str, Any] = {}
    if config.time_limit is not None:
        length = make_params(config.task, team, scenario).vessel.length
        limits["time_limit"] = config.time_limit * length / NOMINAL_LENGTH
    clock = {"control": config.decision_rate}
    return make_params(config.task, team, scenario, clock=clock, **limits)


def grown(params: EnvParams, share: float) -> EnvParams:
    """Parameters with noise and variation at a share of their size."""
    sensors, variation = params.sensors, params.variation
    noise = {
        name: share * getattr(sensors, name)
        for name in ("position_noise", "heading_noise", "speed_noise", "yaw_rate_noise")
    }
    spread = {name: share * getattr(variation, name) for name in ("thrust", "drag", "mass")}
    return replace(
        params, sensors=replace(sensors, **noise), variation=replace(variation, **spread)
    )


@dataclass(frozen=True)
class Midway:
    """States along episodes of a policy.

    Attributes:
        motion: (n, B, 6) of all bodies; see ``State``.
        goal: (n, 3) m, m, rad.
    """

    motion: Float
    goal: Float

    @classmethod
    def watched(cls, config: Config, params: EnvParams, seeds: range) -> Midway:
        """Runs the scripted policy on the episodes of these seeds, as they begin in a training."""
        simulation = Simulation(params, len(seeds), initial_states=Starts(config))
        act = ScriptedPolicy(params).act
        motion, goal = [], []
        for number, tick in enumerate(rollout(simulation, act, seeds, params.time_limit_ticks)):
            if number % KEEP_EVERY == 0:
                motion.append(tick.state.motion.copy())
                goal.append(tick.state.goal.copy())
            if len(motion) * len(seeds) >= LARGEST_STARTS:
                break
        return cls(np.concatenate(motion), np.concatenate(goal))

    @classmethod
    def handed_over(cls, file: Path, params: EnvParams, seeds: range) -> Midway:
        """Runs a policy of several networks; the states in which one of them begins to push.

        They are told as if the team pushed from the +n side.

        Args:
            file: of the policy.
            params: of Transport.
            seeds: of the episodes.

        Raises:
            ValueError, FileNotFoundError: as ``policy_file.read``; it never begins to push.
        """
        simulation = Simulation(params, len(seeds))
        policy = PhasedPolicy(policy_file.read(file)[0], params)
        before = np.full(len(seeds), APPROACH)
        motion, goal = [], []
        for tick in rollout(simulation, policy.act, seeds, params.time_limit_ticks):
            begins = (tick.memory.state == PUSH) & (before == APPROACH)
            before, side = tick.memory.state, tick.memory.push_side.side[begins]
            motion.append(geometry.mirrored(tick.state.motion[begins], side))
            goal.append(geometry.mirrored(tick.state.goal[begins], side))
        states = cls(np.concatenate(motion), np.concatenate(goal))
        if not len(states.goal):
            raise ValueError(
                f"--hand-over {file}: it never brought the vessel into closure with "
                f"{params.num_boats} boats; hand over from a better approach"
            )
        return states


class Starts:
    """How episodes of a training begin; what ``Simulation`` calls ``initial_states``.

    Args:
        config: of the run.
        midway: where ``config.midway_starts`` is above 0.
        share: of half a turn by which goals may lie off the way ahead, and be turned.
    """

    def __init__(self, config: Config, midway: Midway | None = None, share: float = 1.0) -> None:
        self._config, self._midway = config, midway
        self._share = share

    def __call__(
        self, params: EnvParams, rng: np.random.Generator, goal: Float | None = None
    ) -> InitialState:
        """See ``starts.sample``."""
        start = starts.sample(params, rng, goal)
        if goal is not None:
            return start
        config = self._config
        nearer, beside, slots, midway = rng.random(4)
        if self._midway is not None and midway < config.midway_starts:
            chosen = rng.integers(len(self._midway.goal))
            return replace(
                start,
                motion=self._midway.motion[chosen].copy(),
                goal=self._midway.goal[chosen].copy(),
            )
        if config.mirror and start.goal[1] > 0:
            start.goal *= MIRROR
            start.motion[:, :3] *= MIRROR
        _narrow(start, self._share)
        if nearer < config.near_goals:
            start.goal *= rng.random()
        if beside < config.near_starts:
            _put_beside(start.motion, params, rng)
        if slots < config.slot_starts:
            starts.put_into_slots(start.motion, params, rng.choice([1.0, -1.0]))
        return start


def _narrow(start: InitialState, share: float) -> None:
    """Turns a goal towards where the team pushes, and to the heading of the vessel, in place."""
    ahead = 1j * start.side
    goal = complex(*start.goal[:2]) * ahead
    goal = abs(goal) * np.exp(1j * share * np.angle(goal)) / ahead
    start.goal[:] = goal.real, goal.imag, share * start.goal[2]


def _put_beside(motion: Float, params: EnvParams, rng: np.random.Generator) -> None:
    """Places the boats (B, 6) of a vessel at the origin at random beside its hull, in place."""
    vessel, boat = params.vessel, params.boat
    half = np.array([vessel.length, vessel.width]) / 2
    clear, apart = np.hypot(boat.length, boat.width) / 2, 1.05 * np.hypot(boat.length, boat.width)
    placed: list[Float] = []
    for _ in range(TRIES * params.num_boats):
        if len(placed) == params.num_boats:
            break
        point = rng.uniform(-half - BESIDE * vessel.length, half + BESIDE * vessel.length)
        gap = np.hypot(*np.maximum(np.abs(point) - half, 0.0))
        if gap > clear and all(np.hypot(*(point - other)) > apart for other in placed):
            placed.append(point)
    else:
        return  # too crowded; they begin where they are
    motion[1:, :2] = placed
    motion[1:, 2] = rng.uniform(-np.pi, np.pi, params.num_boats)
