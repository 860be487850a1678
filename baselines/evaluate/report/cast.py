"""What the replay of a page can show: players, and the seeds of the embedded episodes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from baselines.evaluate.results import Results
from baselines.evaluate.store import RunKey, Store
from baselines.rollout.episodes import PoseLog

TRIVIAL = (["random"], ["idle"])
"""Fingerprints of policies that are expected to fail."""


@dataclass(frozen=True)
class Player:
    """One policy, or one of its trainings, as the replay can show it.

    Attributes:
        policy: its name.
        number: index of the training.
        key: unique.
        label: its name for readers.
    """

    policy: str
    number: int
    key: str
    label: str


@dataclass(frozen=True)
class Cast:
    """All that the replay can show.

    Attributes:
        players: every training of every policy, in order.
        trivial: policies that are expected to fail; empty where all are.
    """

    players: Sequence[Player]
    trivial: Sequence[str]

    def of(self, policy: str) -> list[Player]:
        """Returns the trainings of a policy."""
        return [player for player in self.players if player.policy == policy]


def find(results: Results, fingerprints: Mapping[str, Sequence[str]]) -> Cast:
    """Returns what the replay can show, given the fingerprints of every policy."""
    condition = results.suite.conditions[0].name
    players = []
    for policy in results.policies:
        trainings = len(results.rows[condition, policy])
        players += [
            Player(policy, number, f"{policy}-{number}", f"{policy}, training {number}")
            if trainings > 1
            else Player(policy, number, policy, policy)
            for number in range(trainings)
        ]
    trivial = [name for name, prints in fingerprints.items() if list(prints) in TRIVIAL]
    return Cast(players, trivial if len(trivial) < len(results.policies) else [])


def chosen(results: Results, condition: str, cast: Cast, number: int) -> list[int]:
    """Returns the seeds of the episodes to embed, in order.

    They are the first ``number`` episodes of the condition, and as many later ones in which a
    policy failed that is not trivial.
    """
    seeds = list(results.suite.seeds)
    judged = [policy for policy in results.policies if policy not in cast.trivial]
    success = np.concatenate([results.success(condition, policy) for policy in judged])
    failed = [seed for seed, done in zip(seeds, success.T, strict=True) if not done.all()]
    first = set(seeds[:number])
    return sorted({*first, *[seed for seed in failed if seed not in first][:number]})


def logs(
    store: Store, condition: str, cast: Cast, seeds: Sequence[int]
) -> dict[str, dict[int, PoseLog]]:
    """Returns the stored pose logs of a condition, by player's key and seed."""
    found = {}
    for player in cast.players:
        key = RunKey(condition, player.policy, player.number)
        read = {seed: store.log(key, seed) for seed in seeds}
        found[player.key] = {seed: log for seed, log in read.items() if log is not None}
    return found
