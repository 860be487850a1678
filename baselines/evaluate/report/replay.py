"""Episodes inside a page, to be watched there: which ones, and how they are packed.

Poses are thinned, rounded and packed; ``replay.js`` unpacks what is chosen.
"""

from __future__ import annotations

import base64
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.render import colours
from asv_env.types import Float
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report.figures import Colours
from baselines.evaluate.results import Results
from baselines.evaluate.store import Series, Store
from baselines.evaluate.tables import formats
from baselines.rollout.episodes import POSE_LOG_EVERY, Episode, PoseLog

RATE = 2.5
"""Poses a second that are kept, about; those between are interpolated."""
UNITS = (1e-3, 1e-3, 1e-3)
"""In which they are kept: m, m, rad."""
PALETTE = (
    *("water_top", "water_bottom", "shadow", "deck", "keel", "edge", "white"),
    *("ink", "good", "failed", "mark", "quay"),
)
FLOOR = (["random"], ["idle"])
"""Fingerprints of policies that are expected to fail."""


@dataclass(frozen=True)
class Player:
    """One policy, or one of its trainings, as a side of the replay can show it.

    Attributes:
        policy: its name.
        number: which of its trainings.
        key: unique.
        label: for readers.
    """

    policy: str
    number: int
    key: str
    label: str


def players(results: Results) -> list[Player]:
    """All that can be shown."""
    condition = results.suite.conditions[0].name
    found = []
    for policy in results.policies:
        trainings = len(results.rows[condition, policy])
        found += [
            Player(policy, number, f"{policy}-{number}", f"{policy}, training {number}")
            if trainings > 1
            else Player(policy, number, policy, policy)
            for number in range(trainings)
        ]
    return found


def chosen(results: Results, condition: str, floor: Sequence[str], number: int) -> list[int]:
    """Seeds of the episodes to embed, in order.

    Args:
        results: of all.
        condition: its name.
        floor: policies that are expected to fail.
        number: of first episodes; as many again are added in which a policy failed.
    """
    seeds = list(results.suite.seeds)
    first = set(seeds[:number])
    judged = [policy for policy in results.policies if policy not in floor]
    success = np.concatenate([results.success(condition, p) for p in judged or results.policies])
    failed = [seed for seed, done in zip(seeds, success.T, strict=True) if not done.all()]
    later = [seed for seed in failed if seed not in first]
    return sorted({*first, *later[:number]})


def floor(policies: Mapping[str, Sequence[str]]) -> list[str]:
    """Names of the policies that are expected to fail, from all names and fingerprints."""
    return [name for name, prints in policies.items() if list(prints) in FLOOR]


def logs(
    store: Store, condition: str, some: Sequence[Player], seeds: Sequence[int]
) -> dict[str, dict[int, PoseLog]]:
    """The logs that are there, by player and seed."""
    found = {}
    for player in some:
        series = Series(condition, player.policy, player.number)
        read = {seed: store.log(series, seed) for seed in seeds}
        found[player.key] = {seed: log for seed, log in read.items() if log is not None}
    return found


def world(
    results: Results,
    some: Sequence[Player],
    floor: Sequence[str],
    colours: Colours,
    embedded: Mapping[str, Sequence[int]],
) -> dict[str, Any]:
    """What the page has to know before a condition is chosen."""
    return {
        "players": [
            {"key": one.key, "label": one.label, "colour": colours[one.policy]} for one in some
        ],
        "policies": [
            {"name": policy, "keys": [one.key for one in some if one.policy == policy]}
            for policy in results.policies
        ],
        "floor": list(floor) if len(floor) < len(results.policies) else [],
        "conditions": [
            _stage(condition, len(embedded[condition.name]))
            for condition in results.suite.conditions
        ],
        "palette": _palette(),
        "units": UNITS,
    }


def _stage(condition: Condition, embedded: int) -> dict[str, Any]:
    """What does not change between the episodes of a condition."""
    params = condition.params
    return {
        "name": condition.name,
        "about": condition.about.replace("`", ""),
        "task": condition.task,
        "boats": params.num_boats,
        "vessel": params.vessel.outline,
        "boat": params.boat.outline,
        "bow": 1.3 * params.boat.bow,
        "walls": params.water.walls,
        "anchored": params.task.goal_anchor == "closure",
        "step": _stride(params) * POSE_LOG_EVERY / params.clock.control,
        "embedded": embedded,
    }


def _palette() -> dict[str, Any]:
    """The colours of the pictures of the world, as those of a page."""
    palette: dict[str, Any] = {name: _css(getattr(colours, name.upper())) for name in PALETTE}
    return {**palette, "team": [_css(colour) for colour in colours.TEAM]}


def _css(colour: colours.Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def episodes(
    condition: Condition,
    found: Mapping[str, Mapping[int, PoseLog]],
    seeds: Sequence[int],
    judged: Sequence[str],
) -> dict[str, Any]:
    """The episodes of one condition.

    Args:
        condition: whose.
        found: logs by player and seed.
        seeds: of the episodes.
        judged: players whose failures are worth a look.

    Returns:
        ``seeds``; ``failed``, of each whether one of those judged failed; ``takes``, by player
        one for each seed (None where there is none).
    """
    takes = {
        key: [_take(condition.params, some[seed]) if seed in some else None for seed in seeds]
        for key, some in found.items()
    }
    failed = [
        any(seed in found[key] and not found[key][seed].episode.success for key in judged)
        for seed in seeds
    ]
    return {"seeds": list(seeds), "failed": failed, "takes": takes}


def _take(params: EnvParams, log: PoseLog) -> dict[str, Any]:
    """One episode of one policy."""
    row, packed = log.episode, thinned(params, log.poses)
    goal = None if params.task.name == "approach" else [round(x, 4) for x in log.goal.tolist()]
    return {
        "success": row.success,
        "verdict": verdict(row),
        "outcome": outcome(row),
        "end": row.duration,
        "closure": row.time_to_closure,
        "goal": goal,
        "failures": [time if math.isfinite(time) else None for time in log.failed_at.tolist()],
        "frames": len(packed),
        "poses": pack(packed),
    }


def thinned(params: EnvParams, poses: Float) -> Float:
    """Every so many poses (T, B, 3) of a log, and the last, which is that of the end."""
    return np.concatenate([poses[:-1][:: _stride(params)], poses[-1:]])


def _stride(params: EnvParams) -> int:
    return max(1, round(params.clock.control / POSE_LOG_EVERY / RATE))


def pack(poses: Float) -> str:
    """Poses (T, B, 3) as text.

    Differences of differences in ``UNITS``, in time and body by body, for hulls move steadily;
    without signs (0, -1, 1, -2 ... become 0, 1, 2, 3 ...); all low bytes, then all high ones;
    compressed.
    """
    steady = np.concatenate([poses[..., :2], np.unwrap(poses[..., 2:], axis=0)], axis=-1)
    whole = np.moveaxis(np.round(steady / UNITS).astype(np.int64), 0, -1)
    bends = np.diff(np.diff(whole, prepend=0), prepend=0)
    unsigned = ((bends << 1) ^ (bends >> 63)).astype("<u2")
    planes = unsigned.reshape(-1, 1).view(np.uint8).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode()


def verdict(row: Episode) -> str:
    """How an episode ended, in a word or two."""
    if row.success:
        return "slots held" if row.task == "approach" else "delivered"
    return f"failed: {row.cause}"


def outcome(row: Episode) -> str:
    """How an episode ended, for readers."""
    if row.error is not None:
        return f"policy error: {row.error}"
    text = verdict(row)
    if row.success:
        text += f" after {formats.quantity(row.duration, 's')} s"
        return text if row.task == "approach" else f"{text}, {_off(row)}"
    if row.min_position_error is not None:
        text += f"; at its nearest {formats.quantity(row.min_position_error, 'cm', 100)} cm away"
    return text


def _off(row: Episode) -> str:
    near = formats.quantity(row.position_error, "cm", 100)
    return f"{near} cm and {formats.quantity(row.heading_error, 'rad')} rad off"
