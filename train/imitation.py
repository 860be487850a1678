"""Imitation of the scripted policy, as a warm start: DAgger (Ross, Gordon and Bagnell, 2011).

In the first round the expert, the scripted policy, acts. In later rounds the learner acts more and
more often, and is trained on what the expert would have done in the states that it reaches. The
expert remembers more than an observation holds; the learner learns what follows from observations.
Recorded episodes can be imitated too.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from tqdm import tqdm

from asv_env.simulation import Simulation
from asv_env.types import Action, Observation, Sensed
from baselines.distributed import distributed
from baselines.rollout import trajectories
from baselines.rollout.loop import rollout
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.config import Config
from train.curriculum import CurriculumStates, training_params

EXPERT_FRACTION = 0.6  #: fraction of the worlds in which the expert acts, to the power of the round
TURN = 5.0  #: time between two random choices of these worlds, s
BATCH = 4096  #: decisions of a gradient step
LEARNING_RATE = 1e-3  #: learning rate of the first three quarters of the rounds
LAST_RATE = 3e-4  #: learning rate of the last quarter of the rounds
TOLERANCE = 0.2  #: error of an action beyond which the loss grows linearly
Pairs = tuple[Observation, Action]  #: observations (n, K) and the actions (n, 2) taken on them


def imitate(actor: nn.Module, config: Config) -> None:
    """Trains an actor, from observations (n, K) to actions (n, 2), to act as the scripted policy.

    Without rounds it stays as it is.
    """
    options = config.imitation
    if not options.rounds:
        return
    optimizer = torch.optim.Adam(actor.parameters(), LEARNING_RATE)
    shuffle = torch.Generator().manual_seed(config.seed)
    pairs = list(demonstrations(options.demonstrations)) if options.demonstrations else []
    with tqdm(total=options.rounds, unit=" round", desc="imitation", file=sys.stderr) as bar:
        for number in range(options.rounds):
            pairs += _dagger_rollouts(actor, config, number)
            seen, wanted = map(torch.from_numpy, map(np.concatenate, zip(*pairs, strict=True)))
            late = number >= 0.75 * options.rounds
            optimizer.param_groups[0]["lr"] = LAST_RATE if late else LEARNING_RATE
            loss = fit(actor, optimizer, seen, wanted, options.steps, shuffle)
            bar.set_postfix_str(f"loss {loss:.4f} of {len(seen):,} decisions", refresh=False)
            bar.update()


def fit(
    actor: nn.Module,
    optimizer: torch.optim.Optimizer,
    seen: Tensor,
    wanted: Tensor,
    steps: int,
    shuffle: torch.Generator,
) -> float:
    """Trains on observations (n, K) and actions (n, 2); returns the mean loss."""
    total = 0.0
    for _ in range(steps):
        batch = torch.randint(len(seen), (BATCH,), generator=shuffle)
        loss = nn.functional.smooth_l1_loss(actor(seen[batch]), wanted[batch], beta=TOLERANCE)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        total += loss.item()
    return total / steps


def _dagger_rollouts(actor: nn.Module, config: Config, number: int) -> Iterator[Pairs]:
    """Yields the observations of round ``number`` and the expert's actions, by group of worlds."""
    first = config.first_seed + number * config.imitation.worlds
    for group, worlds in config.worlds.groups(config.imitation.worlds).items():
        seeds = range(first, first + max(1, worlds))
        yield _dagger_rollout(actor, config, group, seeds, number)
        first = seeds.stop


def _dagger_rollout(
    actor: nn.Module, config: Config, group: tuple[int, str], seeds: range, number: int
) -> Pairs:
    """Returns observations of a group of worlds, in which expert and learner act, and labels."""
    params, rate = training_params(config, *group), config.worlds.decision_rate
    simulation = Simulation(params, len(seeds), initial_states=CurriculumStates(config))
    expert, rng = distributed(ScriptedPolicy(params), params), np.random.default_rng(seeds.start)
    expert_acts = np.ones((len(seeds), 1, 1), dtype=np.bool_)
    seen: list[Observation] = []
    wanted: list[Action] = []

    def act(sensed: Sensed, observation: Observation, *rest: Any) -> tuple[Action, Any]:
        action, memory = expert.act(sensed, observation, *rest)
        if len(wanted) % round(TURN * rate) == 0:
            expert_acts[...] = rng.random(expert_acts.shape) < EXPERT_FRACTION**number
        seen.append(observation.reshape(-1, observation.shape[-1]))
        wanted.append(action.reshape(-1, 2))
        with torch.no_grad():
            learned = actor(torch.from_numpy(observation)).numpy()
        return np.where(expert_acts, action, learned), memory

    for _ in rollout(simulation, act, seeds, round(config.imitation.time * rate)):
        pass
    return np.concatenate(seen), np.concatenate(wanted)


def demonstrations(folder: Path) -> Iterator[Pairs]:
    """Yields observations and actions of each recorded episode in a folder."""
    for file in trajectories.files(folder):
        trajectory, _ = trajectories.load(file)
        seen, actions = trajectory.observation[:-1], trajectory.action
        yield seen.reshape(-1, seen.shape[-1]), actions.reshape(-1, 2)
