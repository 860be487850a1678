"""What the replay of a page can show, and the data of the episodes that the page embeds.

Each policy, or training of one, is a player; what it did in an episode is a take: its outcome, and
its poses as text.
"""

import base64
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from asv_env.capsules import POLYGON
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import grouping
from asv_env.polygons import roomiest
from asv_env.render import colours as scene
from asv_env.types import Float
from baselines.evaluate.conditions import Condition
from baselines.evaluate.report import palette
from baselines.evaluate.results import Results
from baselines.evaluate.store import RunKey, Store
from baselines.evaluate.tables import formats
from baselines.rollout.episodes import POSE_LOG_EVERY, Episode, PoseLog

RATE = 2.5  #: approximate number of poses a second that are kept; those between are interpolated
UNITS = (1e-3, 1e-3, 1e-3)  #: resolution of the poses: m, m, rad
TRIVIAL = (["random"], ["idle"])  #: fingerprints of policies that are expected to fail
SHADES = (
    *("water_top", "water_bottom", "shadow", "deck", "keel", "edge", "white"),
    *("ink", "good", "failed", "mark", "quay", "stone", "stone_edge"),
)
"""Names of the scene's colours that the page uses."""


@dataclass(frozen=True)
class Player:
    """A policy, or its training of a number, under a unique key and a label for readers."""

    policy: str
    number: int
    key: str
    label: str


@dataclass(frozen=True)
class Cast:
    """All players, in order, and the policies that are expected to fail; none where all are."""

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
        for number in range(trainings):
            names = (f"{policy}-{number}", f"{policy}, training {number}")
            players.append(Player(policy, number, *(names if trainings > 1 else (policy, policy))))
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
    """Returns the data of the page that do not depend on the condition that is chosen.

    ``embedded`` holds the seeds of the embedded episodes by condition.
    """
    shades: dict[str, Any] = {name: _css(getattr(scene, name.upper())) for name in SHADES}
    colours = palette.by_policy(results.policies)
    return {
        "players": [{**vars(each), "colour": colours[each.policy]} for each in cast.players],
        "policies": results.policies,
        "trivial": cast.trivial,
        "conditions": [_stage(each, len(embedded[each.name])) for each in results.suite.conditions],
        "palette": {**shades, "team": [_css(colour) for colour in scene.TEAM]},
        "units": UNITS,
    }


def _stage(condition: Condition, embedded: int) -> dict[str, Any]:
    """Returns what all episodes of a condition have in common."""
    params = condition.params
    return {
        "name": condition.name,
        "about": condition.about.replace("`", ""),
        "grasped": params.definition.starts_grasped,
        "boats": params.num_boats,
        "vessel": params.vessel.corners,
        "middle": roomiest(params.vessel.corners),
        "boat": params.boat.corners,
        "bow": 1.3 * params.boat.bow,
        "walls": params.water.walls,
        "anchored": params.task.goal_anchor == "closure",
        "step": interval(params),
        "embedded": embedded,
    }


def _css(colour: scene.Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def episodes(
    condition: Condition, cast: Cast, found: Mapping[str, dict[int, PoseLog]], seeds: Sequence[int]
) -> dict[str, Any]:
    """Returns the data of the embedded episodes of a condition, whose logs are ``found``.

    They are ``seeds``; ``failed``, of each whether a policy failed that is not trivial; ``takes``,
    by player's key one for each seed (None where there is no log).
    """
    takes = {
        key: [take(condition.params, of[seed]) if seed in of else None for seed in seeds]
        for key, of in found.items()
    }
    judged = [found[player.key] for player in cast.players if player.policy not in cast.trivial]
    failed = [any(seed in of and not of[seed].episode.success for of in judged) for seed in seeds]
    return {"seeds": list(seeds), "failed": failed, "takes": takes}


def take(params: EnvParams, log: PoseLog) -> dict[str, Any]:
    """Returns the data of one episode of one policy."""
    row, poses = log.episode, thinned(params, log.poses)
    has_goal = params.definition.has_goal
    return {
        "success": row.success,
        "verdict": verdict(row, has_goal),
        "outcome": outcome(row, has_goal),
        "end": row.duration,
        "closure": row.time_to_closure,
        "goal": [round(x, 4) for x in log.goal.tolist()] if has_goal else None,
        "failures": [time if math.isfinite(time) else None for time in log.failed_at.tolist()],
        "sizes": [round(size, 4) for size in log.boat_size.tolist()],
        "obstacles": obstacles(params, log.obstacle),
        "frames": len(poses),
        "poses": pack(poses),
    }


def obstacles(params: EnvParams, rows: Float) -> list[list[list[float]]]:
    """Returns what is drawn of obstacles (M, 5), all but the walls.

    A polygon is the list of its corners (x, y), any other a list of one row.
    """
    groups, walls = grouping(params)
    found = [rows[a:b] for a, b in pairwise(groups[: len(groups) - walls].tolist())]
    shown = [each[:, :2] if len(each) >= POLYGON else each for each in found]
    return [np.round(each, 4).tolist() for each in shown]


def thinned(params: EnvParams, poses: Float) -> Float:
    """Returns every so many poses (T, B, 3) of a log, and the last one, of the episode's end."""
    return np.concatenate([poses[:-1][:: _stride(params)], poses[-1:]])


def interval(params: EnvParams) -> float:
    """Returns the time between two poses that are kept, s."""
    return _stride(params) * POSE_LOG_EVERY / params.clock.control


def _stride(params: EnvParams) -> int:
    return max(1, round(params.clock.control / POSE_LOG_EVERY / RATE))


def pack(poses: Float) -> str:
    """Returns poses (T, B, 3) as text.

    They are whole multiples of ``UNITS``, body by body and axis by axis. Hulls move steadily, so
    second differences in time are small; signs are folded in (0, -1, 1, -2 ... become 0, 1, 2,
    3 ...). All low bytes come first, then all high ones, compressed, in base 64.
    """
    steady = np.concatenate([poses[..., :2], np.unwrap(poses[..., 2:], axis=0)], axis=-1)
    whole = np.moveaxis(np.round(steady / UNITS).astype(np.int64), 0, -1)
    second = np.diff(np.diff(whole, prepend=0), prepend=0)
    unsigned = ((second << 1) ^ (second >> 63)).astype("<u2")
    planes = unsigned.reshape(-1, 1).view(np.uint8).T
    return base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode()


def verdict(row: Episode, has_goal: bool) -> str:
    """Returns how an episode ended, in a few words."""
    if row.success:
        return "delivered" if has_goal else "slots occupied"
    return f"failed: {row.cause}"


def outcome(row: Episode, has_goal: bool) -> str:
    """Returns how an episode ended, with its time and errors."""
    if row.error is not None:
        return f"policy error: {row.error}"
    text, nearest = verdict(row, has_goal), row.min_position_error
    if row.success:
        text += f" after {formats.quantity(row.duration, 's')} s"
        if row.position_error is not None:
            near = formats.quantity(row.position_error, "cm", 100)
            text += f", {near} cm and {formats.quantity(row.heading_error, 'rad')} rad off"
    elif nearest is not None:
        text += f"; at its nearest {formats.quantity(nearest, 'cm', 100)} cm away"
    return text
