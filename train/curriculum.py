"""Easier episodes, which grow into those of the task as a training progresses.

Goals are nearer, boats begin close to the hull, episodes begin in states of a rollout. Goals lie
ahead of the team and are hardly turned, noise and variation are small: these grow with the progress
of the curriculum, from 0 to 1.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.polygons import complex_corners, gap_to, outline
from asv_env.simulation import Simulation
from asv_env.types import Float, InitialState
from baselines.distributed import distributed
from baselines.policy import Policy
from baselines.rollout.loop import rollout
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.config import Config

MARGIN = 0.9  #: width of the strip around the hull where boats begin close to it, vessel lengths
TRIES = 200  #: random places that are tried for each boat there
ROLLOUTS = 384  #: episodes of rollouts from which states are taken, over all groups of worlds
LEAST_ROLLOUTS = 24  #: least number of these episodes in a group
MOST_STATES = 16384  #: number of states at which a rollout of the scripted policy ends
KEEP_EVERY = 10  #: control ticks between two states that are kept


@dataclass(frozen=True)
class RolloutStates:
    """States of bodies and goals from rollouts of a policy."""

    motion: Float  #: (n, B, 6) of all bodies; see ``State``
    goal: Float  #: (n, 3) goal poses, m, m, rad

    def sample(self, start: InitialState, rng: np.random.Generator) -> InitialState:
        """Returns an initial state with bodies and goal of a random state of the rollouts."""
        chosen = rng.integers(len(self.goal))
        return replace(start, motion=self.motion[chosen].copy(), goal=self.goal[chosen].copy())


def training_params(config: Config, team: int, scenario: str) -> EnvParams:
    """Returns the parameters of a group of worlds, which advance by one decision at a time."""
    options: dict[str, Any] = {"clock": {"control": config.worlds.decision_rate}}
    if config.worlds.time_limit is not None:
        length = config.params(team, scenario).vessel.size
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


def adapter_options(
    config: Config, group: tuple[int, str], states: RolloutStates | None, progress: float
) -> dict[str, Any]:
    """Returns what an adapter needs to make worlds of a group; see ``CurriculumStates``."""
    params = scaled_noise(training_params(config, *group), progress)
    options = {name: getattr(params, name) for name in ("clock", "sensors", "variation")}
    options |= {"task_params": params.task, "observation": params.observation}
    options |= {"task": config.task, "num_boats": group[0], "scenario": group[1]}
    return options | {"initial_states": CurriculumStates(config, states, progress)}


@dataclass(frozen=True, eq=False)
class CurriculumStates:
    """The distribution of initial states of a training, for ``Simulation``'s ``initial_states``."""

    config: Config  #: of the run
    states: RolloutStates | None = None  #: of rollouts, in which episodes begin, if any shall
    progress: float = 1.0  #: of the curriculum, which scales the bearing and the turn of goals

    def __call__(
        self, params: EnvParams, rng: np.random.Generator, goal: Float | None = None
    ) -> InitialState:
        """Returns a random initial state; see ``Task.initial_states``."""
        start = params.definition.initial_states(params, rng, goal)
        if goal is not None:
            return start
        options = self.config.curriculum
        near_goal, near_hull, from_rollout = rng.random(3)
        if self.states is not None and from_rollout < options.rollout_starts:
            return self.states.sample(start, rng)
        _turn_goal_ahead(start, self.progress)
        if near_goal < options.near_goals:
            start.goal *= rng.random()
        if near_hull < options.near_starts:
            _place_near_hull(start.motion, params, rng)
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
    hull = outline(complex_corners(vessel.corners))
    left, right, bottom, top = vessel.extents
    margin = MARGIN * vessel.size
    diagonal = np.hypot(boat.length, boat.width)
    clear, apart = diagonal / 2, 1.05 * diagonal
    placed: list[Float] = []
    for _ in range(TRIES * params.num_boats):
        if len(placed) == params.num_boats:
            break
        point = rng.uniform((left - margin, bottom - margin), (right + margin, top + margin))
        if gap_to(hull, complex(*point)) > clear and all(
            np.hypot(*(point - boat)) > apart for boat in placed
        ):
            placed.append(point)
    else:
        return
    motion[1:, :2] = placed
    motion[1:, 2] = rng.uniform(-np.pi, np.pi, params.num_boats)


def rollout_states(config: Config, team: int, scenario: str) -> RolloutStates | None:
    """Returns the states of rollouts in which episodes of a group begin; None if none shall."""
    if not config.curriculum.rollout_starts:
        return None
    groups = config.worlds.groups(config.worlds.num_envs)
    number = max(LEAST_ROLLOUTS, ROLLOUTS // len(groups))
    seeds = range(config.first_seed, config.first_seed + number)
    params = config.params(team, scenario)
    simulation = Simulation(params, number, initial_states=CurriculumStates(config))
    return along_episodes(distributed(ScriptedPolicy(params), params), simulation, seeds)


def along_episodes(policy: Policy, simulation: Simulation, seeds: range) -> RolloutStates:
    """Returns states at regular intervals along episodes of a policy."""
    motion, goal = [], []
    ticks = rollout(simulation, policy.act, seeds, simulation.params.time_limit_ticks)
    for number, tick in enumerate(ticks):
        if number % KEEP_EVERY == 0:
            motion.append(tick.state.motion.copy())
            goal.append(tick.state.goal.copy())
        if len(motion) * len(seeds) >= MOST_STATES:
            break
    return RolloutStates(np.concatenate(motion), np.concatenate(goal))
