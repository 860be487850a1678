"""States of rollouts, in which episodes of a training can begin."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from asv_env import geometry
from asv_env.params import EnvParams
from asv_env.simulation import Simulation
from asv_env.types import Float, InitialState
from baselines.learned import policy_file
from baselines.learned.phases import APPROACH, PUSH, PhasedPolicy
from baselines.policy import Policy
from baselines.rollout.loop import rollout

MOST_STATES = 16384
"""Number of states at which a rollout of the scripted policy ends."""
KEEP_EVERY = 10
"""Control ticks between two states that are kept."""


@dataclass(frozen=True)
class RolloutStates:
    """States of bodies and goals from rollouts of a policy."""

    motion: Float  # (n, B, 6) of all bodies; see ``State``
    goal: Float  # (n, 3) goal poses, m, m, rad

    def sample(self, start: InitialState, rng: np.random.Generator) -> InitialState:
        """Returns an initial state with bodies and goal of a random state of the rollouts."""
        chosen = rng.integers(len(self.goal))
        return replace(start, motion=self.motion[chosen].copy(), goal=self.goal[chosen].copy())


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


def where_pushes_begin(file: Path, params: EnvParams, seeds: range) -> RolloutStates:
    """Returns the states of Transport in which a policy of several phases begins to push.

    They are mirrored so that the team pushes from the +n side.

    Raises:
        ValueError, FileNotFoundError: the file is no such policy; it never begins to push.
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
    states = RolloutStates(np.concatenate(motion), np.concatenate(goal))
    if not len(states.goal):
        raise ValueError(
            f"--curriculum.rollout-policy {file}: it never brought the vessel into closure with "
            f"{params.num_boats} boats; take a policy with a better approach"
        )
    return states
