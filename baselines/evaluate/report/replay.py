"""The data of a page's replay, for its scripts."""

from collections.abc import Mapping, Sequence
from typing import Any

from asv_env.render import colours as scene
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import packing, palette
from baselines.evaluate.report.cast import Cast
from baselines.evaluate.results import Results
from baselines.rollout.episodes import PoseLog

SHADES = (
    *("water_top", "water_bottom", "shadow", "deck", "keel", "edge", "white"),
    *("ink", "good", "failed", "mark", "quay"),
)
"""Names of the scene's colours that the page uses."""


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
