"""The one loop of all rollouts: observe, act, step, reset."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np

from asv_env.numerics import numerics
from asv_env.simulation import Simulation
from asv_env.types import Action, Bool, Int, Observation, Sensed, State, TimeStep

Act = Callable[[Sensed, Observation, Any, Bool], tuple[Action, Any]]
"""How a policy decides; see ``Policy.act``."""
IDLE = -1  #: number of the episode of a world for which no seed is left


@dataclass(frozen=True)
class Tick:
    """One control step of all worlds: what was, what was decided, and what came of it."""

    state: State  #: the truth before the step
    observation: Observation  #: (W, A, K) before the step
    action: Action  #: (W, A, 2) that was decided
    memory: Any  #: what the policy remembers of it
    step: TimeStep  #: what the step returned
    episode: Int  #: (W,) number of the seed whose episode a world runs; ``IDLE`` where none is left
    over: Bool  #: (W,) worlds that begin another episode next; set it to end further episodes


def rollout(
    simulation: Simulation, act: Act, seeds: Sequence[int], ticks: int | None = None
) -> Iterator[Tick]:
    """Runs a policy in all worlds of a simulation, whose state is that after the yielded step.

    What the policy is given are copies. It may write to them: neither the worlds nor what is
    recorded depend on it.

    Args:
        simulation: with at most as many worlds as there are seeds.
        act: decides for all worlds.
        seeds: of the episodes, which worlds take in turn. Without ``ticks``, the rollout ends
            when these are over; a world for which none is left repeats the last one, ``IDLE``.
        ticks: number of steps. With it, a world for which no seed is left begins an episode with
            its own Generator.

    Yields:
        One tick after another, before worlds that are over are reset.
    """
    worlds = simulation.num_worlds
    queue, last = enumerate(seeds[worlds:], worlds), None if ticks else seeds[-1]
    episode = np.arange(worlds)
    with numerics():
        observation = simulation.reset(seeds=seeds[:worlds])
    memory, over = None, np.ones(worlds, dtype=np.bool_)
    for _ in count() if ticks is None else range(ticks):
        state = simulation.state
        with numerics():
            given = simulation.sensed, np.copy(observation), memory, np.copy(over)
            action, memory = act(*given)
        with numerics():  # the policy may have changed it
            step = simulation.step(action)
        over = step.ending.terminated | step.ending.truncated
        yield Tick(state, observation, action, memory, step, episode.copy(), over)
        observation = step.observation
        if over.any():
            following = [next(queue, (IDLE, last)) for _ in range(over.sum())]
            episode[over] = [number for number, _ in following]
            if ticks is None and (episode == IDLE).all():
                return
            observation = observation.copy()
            with numerics():
                observation[over] = simulation.reset(over, [seed for _, seed in following])
