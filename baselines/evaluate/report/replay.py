"""Episodes inside a page, to be watched there: which ones, and their data for ``replay.js``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.render import colours as scene
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import packing, palette
from baselines.evaluate.results import Results
from baselines.evaluate.store import RunKey, Store
from baselines.rollout.episodes import PoseLog

SHADES = (
    *("water_top", "water_bottom", "shadow", "deck", "keel", "edge", "white"),
    *("ink", "good", "failed", "mark", "quay"),
)
"""Names of the scene's colours that the page uses."""
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


def cast(results: Results, fingerprints: Mapping[str, Sequence[str]]) -> Cast:
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


def world(results: Results, cast: Cast, embedded: Mapping[str, Sequence[int]]) -> dict[str, Any]:
    """Returns the data that do not depend on the condition that is chosen.

    Args:
        results: all rows.
        cast: all that can be shown.
        embedded: seeds of the embedded episodes, by condition.
    """
    shades: dict[str, Any] = {name: _css(getattr(scene, name.upper())) for name in SHADES}
    colours = palette.by_policy(results.policies)
    return {
        "players": [
            {"key": player.key, "label": player.label, "colour": colours[player.policy]}
            for player in cast.players
        ],
        "policies": [
            {"name": policy, "keys": [player.key for player in cast.of(policy)]}
            for policy in results.policies
        ],
        "trivial": cast.trivial,
        "conditions": [
            _stage(condition, len(embedded[condition.name]))
            for condition in results.suite.conditions
        ],
        "palette": {**shades, "team": [_css(colour) for colour in scene.TEAM]},
        "units": packing.UNITS,
    }


def _stage(condition: Condition, embedded: int) -> dict[str, Any]:
    """Returns what all episodes of a condition have in common."""
    params = condition.params
    return {
        "name": condition.name,
        "about": condition.about.replace("`", ""),
        "grasped": params.definition.starts_grasped,
        "boats": params.num_boats,
        "vessel": params.vessel.outline,
        "boat": params.boat.outline,
        "bow": 1.3 * params.boat.bow,
        "walls": params.water.walls,
        "anchored": params.task.goal_anchor == "closure",
        "step": packing.interval(params),
        "embedded": embedded,
    }


def _css(colour: scene.Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def episodes(
    condition: Condition,
    cast: Cast,
    found: Mapping[str, Mapping[int, PoseLog]],
    seeds: Sequence[int],
) -> dict[str, Any]:
    """Returns the data of the embedded episodes of a condition.

    Args:
        condition: whose episodes they are.
        cast: all that can be shown.
        found: pose logs by player's key and seed.
        seeds: of the episodes.

    Returns:
        ``seeds``; ``failed``, of each whether a policy failed that is not trivial; ``takes``, by
        player's key one for each seed (None where there is no log).
    """
    takes = {
        key: [
            packing.take(condition.params, logs[seed]) if seed in logs else None for seed in seeds
        ]
        for key, logs in found.items()
    }
    judged = [found[player.key] for player in cast.players if player.policy not in cast.trivial]
    failed = [
        any(seed in logs and not logs[seed].episode.success for logs in judged) for seed in seeds
    ]
    return {"seeds": list(seeds), "failed": failed, "takes": takes}
