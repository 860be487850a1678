"""Easier episodes, which grow into those of the task as a training progresses.

Goals are nearer, boats begin close to the hull or in their slots, episodes begin in states of a
rollout. Goals lie ahead of the team and are hardly turned, noise and variation are small: these
grow with the progress of the curriculum, from 0 to 1.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.presets import make_params
from asv_env.simulation import Simulation
from asv_env.tasks import starts
from asv_env.types import Float, InitialState
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.config import Config
from train.rollout_states import RolloutStates, along_episodes, where_pushes_begin

MIRROR = np.array([1.0, -1.0, -1.0])
"""Factors that mirror a pose about the x axis, along which the vessel lies at the origin."""
MARGIN = 0.9
"""Width of the margin around the hull in which boats begin close to it, vessel lengths."""
TRIES = 200
"""Random places that are tried for each boat there."""
ROLLOUTS = 384
"""Episodes of rollouts from which states are taken, distributed over the groups of worlds."""
LEAST_ROLLOUTS = 24
"""Least number of these episodes in a group."""


def training_params(config: Config, team: int, scenario: str) -> EnvParams:
    """Returns the parameters of a group of worlds, which advance by one decision at a time."""
    options: dict[str, Any] = {"clock": {"control": config.worlds.decision_rate}}
    if config.worlds.time_limit is not None:
        length = config.params(team, scenario).vessel.length
        options["time_limit"] = config.worlds.time_limit * length / NOMINAL_LENGTH
    return config.params(team, scenario, **options)


def scaled_noise(params: EnvParams, scale: float) -> EnvParams:
    """Returns parameters with sensor noise and variation multiplied by ``scale``."""

    def scaled(section: Any, names: str) -> Any:
        changes = {name: scale * getattr(section, name) for name in names.split()}
        return replace(section, **changes)

    noise = "position_noise heading_noise speed_noise yaw_rate_noise"
    sensors = scaled(params.sensors, noise)
    return replace(params, sensors=sensors, variation=scaled(params.variation, "thrust drag mass"))


def rollout_states(config: Config, team: int, scenario: str) -> RolloutStates | None:
    """Returns the states of rollouts in which episodes of a group begin; None if none shall."""
    if not config.curriculum.rollout_starts:
        return None
    groups = config.worlds.groups(config.worlds.num_envs)
    number = max(LEAST_ROLLOUTS, ROLLOUTS // len(groups))
    seeds = range(config.first_seed, config.first_seed + number)
    if config.curriculum.rollout_policy is not None:
        params = make_params("transport", team, scenario)
        return where_pushes_begin(config.curriculum.rollout_policy, params, seeds)
    params = config.params(team, scenario)
    simulation = Simulation(params, number, initial_states=CurriculumStates(config))
    return along_episodes(ScriptedPolicy(params), simulation, seeds)


class CurriculumStates:
    """The distribution of initial states of a training, for ``Simulation``'s ``initial_states``.

    Args:
        config: of the run.
        states: of a rollout, where ``config.curriculum.rollout_starts`` is above 0.
        progress: of the curriculum, which scales the bearing and the turn of goals.
    """

    def __init__(
        self, config: Config, states: RolloutStates | None = None, progress: float = 1.0
    ) -> None:
        self._options, self._mirror = config.curriculum, config.worlds.mirror
        self._states, self._progress = states, progress

    def __call__(
        self, params: EnvParams, rng: np.random.Generator, goal: Float | None = None
    ) -> InitialState:
        """Returns a random initial state; see ``Task.initial_states``."""
        start = params.definition.initial_states(params, rng, goal)
        if goal is not None:
            return start
        options = self._options
        near_goal, near_hull, in_slots, from_rollout = rng.random(4)
        if self._states is not None and from_rollout < options.rollout_starts:
            return self._states.sample(start, rng)
        if self._mirror and start.goal[1] > 0:
            start.goal *= MIRROR
            start.motion[:, :3] *= MIRROR
        _turn_goal_ahead(start, self._progress)
        if near_goal < options.near_goals:
            start.goal *= rng.random()
        if near_hull < options.near_starts:
            _place_near_hull(start.motion, params, rng)
        if in_slots < options.slot_starts:
            starts.put_into_slots(start.motion, params, rng.choice([1.0, -1.0]))
        return start


def _turn_goal_ahead(start: InitialState, progress: float) -> None:
    """Scales bearing and heading of a goal, in place; the bearing is from where the team pushes."""
    ahead = 1j * start.side
    goal = complex(*start.goal[:2]) * ahead
    goal = abs(goal) * np.exp(1j * progress * np.angle(goal)) / ahead
    start.goal[:] = goal.real, goal.imag, progress * start.goal[2]


def _place_near_hull(motion: Float, params: EnvParams, rng: np.random.Generator) -> None:
    """Places the boats (1 + A, 6) at random close to the hull of a vessel at the origin, in place.

    Where it is too crowded for the team, the boats stay where they are.
    """
    vessel, boat = params.vessel, params.boat
    half = np.array([vessel.length, vessel.width]) / 2
    diagonal = np.hypot(boat.length, boat.width)
    clear, apart = diagonal / 2, 1.05 * diagonal
    placed: list[Float] = []
    for _ in range(TRIES * params.num_boats):
        if len(placed) == params.num_boats:
            break
        point = rng.uniform(-half - MARGIN * vessel.length, half + MARGIN * vessel.length)
        gap = np.hypot(*np.maximum(np.abs(point) - half, 0.0))
        if gap > clear and all(np.hypot(*(point - boat)) > apart for boat in placed):
            placed.append(point)
    else:
        return
    motion[1:, :2] = placed
    motion[1:, 2] = rng.uniform(-np.pi, np.pi, params.num_boats)
