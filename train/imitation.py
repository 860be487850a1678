"""Imitation of the scripted policy, as a warm start: DAgger (Ross, Gordon and Bagnell, 2011).

In the first round the scripted policy acts; later on the learner does more and more of it, and the
scripted policy says what it would have done where the learner has come to. The learner's memory
is no longer than an observation, that of the scripted policy is: it learns what can be told from
what is seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn
from tqdm import tqdm

from asv_env.sensing import observation
from asv_env.simulation import Simulation
from asv_env.types import Action, Bool, Observation, Sensed
from baselines.policy import Policy
from baselines.rollout import trajectories
from baselines.rollout.loop import rollout
from baselines.scripted.scripted_policy import ScriptedPolicy
from train.config import Config
from train.curriculum import Starts, training_params

TEACHES = 0.6
"""Share of the worlds in which the teacher acts, from round to round."""
TURNS = 5.0
"""Time after which it is drawn anew who acts, s."""
BATCH = 4096
LEARNING_RATE = 1e-3
LAST_RATE = 3e-4
"""Learning rate of the last quarter of the rounds."""
TOLERANCE = 0.2
"""Error of an action from which on the loss grows linearly."""
Pairs = tuple[Observation, Action]


def imitate(actor: nn.Module, config: Config, bar: tqdm) -> float:
    """Trains an actor on what the scripted policy does; advances ``bar`` by one a round.

    Args:
        actor: from observations (n, K) to actions (n, 2).
        config: of the run.
        bar: of the rounds.

    Returns:
        Loss of the last round.
    """
    optimizer = torch.optim.Adam(actor.parameters(), LEARNING_RATE)
    shuffle = torch.Generator().manual_seed(config.seed)
    pairs = list(recorded(config))
    loss = float("nan")
    for number in range(config.imitation_rounds):
        pairs += watched(actor, config, number)
        seen, done = (torch.from_numpy(np.concatenate(some)) for some in zip(*pairs, strict=True))
        late = number >= 0.75 * config.imitation_rounds
        optimizer.param_groups[0]["lr"] = LAST_RATE if late else LEARNING_RATE
        loss = fit(actor, optimizer, seen, done, config.imitation_steps, shuffle)
        bar.set_postfix_str(f"loss {loss:.4f} of {len(seen):,} decisions", refresh=False)
        bar.update()
    return loss


def fit(
    actor: nn.Module,
    optimizer: torch.optim.Optimizer,
    seen: Tensor,
    done: Tensor,
    steps: int,
    shuffle: torch.Generator,
) -> float:
    """Gradient descent on pairs of observation (n, K) and action (n, 2); the mean loss."""
    total = 0.0
    for _ in range(steps):
        some = torch.randint(len(seen), (BATCH,), generator=shuffle)
        loss = nn.functional.smooth_l1_loss(actor(seen[some]), done[some], beta=TOLERANCE)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        total += loss.item()
    return total / steps


def watched(actor: nn.Module, config: Config, number: int) -> list[Pairs]:
    """What is seen in a round, and what the teacher would do there; of every group of worlds."""
    first = config.first_seed + number * config.imitation_worlds
    pairs = []
    for group, worlds in config.shared_out(config.imitation_worlds).items():
        seeds = range(first, first + max(1, worlds))
        pairs.append(_watched(actor, config, group, seeds, number))
        first = seeds.stop
    return pairs


def _watched(
    actor: nn.Module, config: Config, group: tuple[int, str], seeds: range, number: int
) -> Pairs:
    params = training_params(config, *group)
    simulation = Simulation(params, len(seeds), initial_states=Starts(config))
    mixture = Mixture(ScriptedPolicy(params), actor, config.decision_rate, seeds.start, number)
    ticks = round(config.imitation_time * config.decision_rate)
    pairs = [
        (tick.observation.reshape(-1, tick.observation.shape[-1]), tick.memory.label.reshape(-1, 2))
        for tick in rollout(simulation, mixture.act, seeds, ticks)
    ]
    return tuple(np.concatenate(some) for some in zip(*pairs, strict=True))  # type: ignore[return-value]


class Labelled(NamedTuple):
    """What ``Mixture`` remembers: the expert's memory, and its action (W, A, 2)."""

    expert: Any
    label: Action


class Mixture:
    """The expert acts in some worlds, the learner in the others; a ``Policy``.

    Args:
        expert: policy that is imitated.
        actor: learner, from observations (..., K) to actions (..., 2).
        rate: decisions a second.
        seed: of the choice of worlds.
        number: of the round; the expert acts in a share of ``TEACHES`` to this power.
    """

    def __init__(self, expert: Policy, actor: nn.Module, rate: int, seed: int, number: int) -> None:
        self._expert, self._actor, self._share = expert, actor, TEACHES**number
        self._rng = np.random.default_rng(seed)
        self._tick, self._period = 0, round(TURNS * rate)

    def act(
        self, sensed: Sensed, observation: Observation, memory: Labelled | None, fresh: Bool
    ) -> tuple[Action, Labelled]:
        """See ``Policy.act``."""
        before = None if memory is None else memory.expert
        label, after = self._expert.act(sensed, observation, before, fresh)
        if self._tick % self._period == 0:
            self._expert_acts = self._rng.random((len(fresh), 1, 1)) < self._share
        self._tick += 1
        with torch.no_grad():
            learned = self._actor(torch.from_numpy(observation)).numpy()
        return np.where(self._expert_acts, label, learned), Labelled(after, label)


def recorded(config: Config) -> Iterator[Pairs]:
    """Pairs of the recorded episodes that are to be imitated."""
    for file in _files(config):
        trajectory, _ = trajectories.load(file)
        seen, done = trajectory.observation[:-1], trajectory.action
        yield seen.reshape(-1, seen.shape[-1]), done.reshape(-1, 2)


def check_recorded(config: Config) -> None:
    """Refuses recorded episodes that must not be, or cannot be, learned from.

    Raises:
        FileNotFoundError: there are none in the folder.
        ValueError: an episode that is not for training, of another task, kind of action or
            version of the observation, or a file that is none.
    """
    files = _files(config)
    if config.demonstrations is not None and not files:
        raise FileNotFoundError(
            f"{config.demonstrations} holds no recorded episodes: make some with "
            "python -m baselines.evaluate --record"
        )
    for file in files:
        _check(file, trajectories.about(file), config)


def _files(config: Config) -> list[Path]:
    return trajectories.files(config.demonstrations) if config.demonstrations else []


def _check(file: Path, about: dict[str, Any], config: Config) -> None:
    episode = about["episode"]
    if about["purpose"] != "training":
        raise ValueError(
            f"{file}: seed {episode['seed']} is for {about['purpose'] or 'nothing'}, not for "
            "training: record episodes with --seed 1000000000 and up"
        )
    told = (episode["task"], about["action_mode"], about["observation_version"])
    wanted = (config.task, "tracking", observation.VERSION)
    names = ("task", "action mode", "observation version")
    for name, one, other in zip(names, told, wanted, strict=True):
        if one != other:
            raise ValueError(f"{file}: its {name} is {one!r}, that of the training {other!r}")
