"""What a boat observes: a list of named features, whose size does not depend on the team's.

All features are computed from ``Sensed``. Each is divided by a fixed scale and clipped, so
that no running statistics are needed. Lengths are in vessel lengths, so that one policy serves
every size; quantities that must be met to the centimetre appear a second time, magnified.

An environment takes ``observation=[...]``: names of ``FEATURES``, or ``Feature`` objects.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from asv_env.checks import COMPLEX, REAL, FunctionError, values
from asv_env.compiled import Bound
from asv_env.memo import by_identity
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.registry import Registry
from asv_env.sensing import feature_table
from asv_env.sensing.feature_table import (
    FIRST_NEIGHBOUR,
    FIRST_OBSTACLE,
    FIRST_OF_VESSEL,
    NEIGHBOURS,
    Columns,
    book,
    fill,
    known,
)
from asv_env.sensing.nearest_obstacles import OBSTACLES
from asv_env.sensing.view import View
from asv_env.threads import spread
from asv_env.types import Float, Int, Observation, Sensed, given, rows

KIND = "feature"  #: word for a feature in messages
FAR = 15.0  #: largest distance in an observation, vessel lengths: more than the arena's diagonal
FAST = 4.0  #: largest speed in an observation, full speeds and full yaw rates of a boat
FINE_ANGLE = 0.1  #: angle at which magnified features saturate, rad
VERSION = 2  #: of what features mean; grows where a trained policy would be misled
LENGTH, SPEED, YAW_RATE = "length", "speed", "yaw_rate"
"""Scales from parameters: the vessel's length, speed and yaw rate of a full tracking action."""
FINE, FINE_SPEED, FINE_YAW_RATE = "fine", "fine_speed", "fine_yaw_rate"
"""Scales of magnified features: where they saturate."""
PER_LENGTH = "per_length"  #: scale of an inverse length
OF_THE_WORLD = {FINE: (0.1, 1.0), FINE_SPEED: (0.04, 0.5), FINE_YAW_RATE: (0.15, -0.5),
                PER_LENGTH: (1.0 / NOMINAL_LENGTH, -1.0)}  # fmt: skip
"""Scales of a nominal world, m, m/s, rad/s and 1/m, and their powers of ``EnvParams.scale``."""
SCALES = (LENGTH, SPEED, YAW_RATE, *OF_THE_WORLD)
Units = tuple[float, ...]  #: what these scales are
Scale = float | str  #: divisor of a column: a number, or one of these names
Value = Callable[[View], np.ndarray]
"""Function from a view to (W, A) or (W, 1): real for one column, complex x + iy for two; or to
(W, A, n) for n columns."""
NAMES_OF_NEIGHBOURS = feature_table.NAMES[FIRST_NEIGHBOUR:FIRST_OBSTACLE]
NAMES_OF_OBSTACLES = feature_table.NAMES[FIRST_OBSTACLE:FIRST_OF_VESSEL]
NAMES_OF_VESSEL_OBSTACLES = feature_table.NAMES[FIRST_OF_VESSEL:]
Features = tuple["Feature", ...]
Forms = dict[tuple[int, ...], str]  #: shapes that values may have, with the kinds of their numbers


@dataclass(frozen=True)
class Feature:
    """A feature of an observation, with one or several columns; see ``scalar`` and ``vector``.

    Attributes:
        name: name of the feature.
        value: function from a ``sensing.view.View`` to the feature in SI units, real (W, A) or
            (W, 1) for one column, complex x + iy for two, (W, A, n) for n columns.
        scale: divisor of each column; ``LENGTH`` stands for the vessel's length, ``SPEED`` and
            ``YAW_RATE`` for those of a full tracking action; see ``SCALES`` for the others.
        bound: magnitude to which each column is clipped after scaling.
        columns: names of the columns; by default the name of the feature, with numbers for
            several.
    """

    name: str
    value: Value
    scale: tuple[Scale, ...]
    bound: tuple[float, ...]
    columns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("scale", "bound", "columns"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        width = len(self.scale)
        numbers = [*self.bound, *(one for one in self.scale if one not in SCALES)]
        usable = all(np.isfinite(number) and number for number in numbers)
        if not width or len(self.bound) != width or not usable:
            raise ValueError(
                f"feature {self.name!r}: scale = {self.scale!r} and bound = {self.bound!r}: give "
                "one of each for every column, finite and not zero"
            )
        if not self.columns and width > 1:
            columns = tuple(f"{self.name}_{k + 1}" for k in range(width))
            object.__setattr__(self, "columns", columns)
        if len(self.columns or (self.name,)) != width:
            raise ValueError(f"feature {self.name!r}: give a name for each of {width} columns")

    def __hash__(self) -> int:
        return hash(self.name)


def scalar(name: str, scale: Scale, bound: float, value: Value) -> Feature:
    """Returns a feature of one column, ``value`` / ``scale`` clipped to +-``bound``."""
    return Feature(name, value, (scale,), (bound,), (name,))


def vector(name: str, scale: Scale, bound: float, value: Value) -> Feature:
    """Returns a feature of two columns, x and y, from a complex ``value`` x + iy."""
    return Feature(name, value, (scale,) * 2, (bound,) * 2, (f"{name}_x", f"{name}_y"))


def _column(name: str) -> Columns:
    return Columns((name,))


def _vector(name: str) -> Columns:
    return Columns((f"{name}_x", f"{name}_y"))


def _nearest(name: str, columns: tuple[str, ...]) -> Feature:
    """Returns a feature of the nearest obstacles."""
    scale, bound = (LENGTH, LENGTH, 1.0) * OBSTACLES, (FAR, FAR, 1.0) * OBSTACLES
    return Feature(name, Columns(columns), scale, bound, columns)


DEFAULT = (
    # Vectors in the boat's frame, or relative to the slot.
    vector("own_velocity", SPEED, FAST, _vector("own_velocity")),
    vector("slot", LENGTH, FAR, _vector("slot")),
    vector("slot_fine", FINE, 1.0, _vector("slot")),
    vector("slot_alignment", 1.0, 1.0, _vector("slot_alignment")),
    # Vectors in the vessel's frame.
    vector("own_position", LENGTH, FAR, _vector("own_position")),
    vector("slot_position", LENGTH, FAR, _vector("slot_position")),
    vector("vessel_velocity", SPEED, FAST, _vector("vessel_velocity")),
    vector("goal", LENGTH, FAR, _vector("goal")),
    vector("goal_fine", FINE, 1.0, _vector("goal")),
    vector("goal_direction", 1.0, 1.0, _vector("goal_direction")),
    vector("vessel_velocity_fine", FINE_SPEED, 1.0, _vector("vessel_velocity")),
    # Scalars.
    scalar("own_yaw_rate", YAW_RATE, FAST, _column("own_yaw_rate")),
    scalar("vessel_yaw_rate", YAW_RATE, FAST, _column("vessel_yaw_rate")),
    scalar("touches_vessel", 1.0, 1.0, _column("touches_vessel")),
    scalar("touches_other", 1.0, 1.0, _column("touches_other")),
    scalar("thrusters_work", 1.0, 1.0, _column("thrusters_work")),
    scalar("slots_occupied", 1.0, 1.0, _column("slots_occupied")),
    scalar("closure", 1.0, 1.0, _column("closure")),
    scalar("turn_to_goal_fine", FINE_ANGLE, 1.0, _column("turn_to_goal")),
    scalar("vessel_yaw_rate_fine", FINE_YAW_RATE, 1.0, _column("vessel_yaw_rate")),
    scalar("inverse_team_size", 0.5, 2.0, _column("inverse_team_size")),
    scalar("inverse_vessel_length", PER_LENGTH, 4.0, _column("inverse_vessel_length")),
    scalar("vessel_seen", 1.0, 1.0, _column("vessel_seen")),
    # The vector to the nearest point of the vessel's outline, in the boat's frame.
    vector("hull", LENGTH, FAR, _vector("hull")),
    vector("hull_fine", FINE, 1.0, _vector("hull")),
    Feature(
        "neighbours",
        Columns(NAMES_OF_NEIGHBOURS),
        (LENGTH, LENGTH, SPEED, SPEED, 1.0) * NEIGHBOURS,
        (FAR, FAR, FAST, FAST, 1.0) * NEIGHBOURS,
        NAMES_OF_NEIGHBOURS,
    ),
    _nearest("obstacles", NAMES_OF_OBSTACLES),
    _nearest("vessel_obstacles", NAMES_OF_VESSEL_OBSTACLES),
)  #: features that are observed by default
FEATURES: Registry[Feature] = Registry(
    "feature", {one.name: one for one in DEFAULT}, lambda thing: isinstance(thing, Feature)
)
"""Features by name, in the order in which they are observed by default."""


def units(params: EnvParams) -> Units:
    """Returns what ``SCALES`` are, in SI units."""
    boat, k = params.boat, params.scale
    others = (size * k**power for size, power in OF_THE_WORLD.values())
    return params.vessel.size, boat.full_speed, boat.full_yaw_rate, *others


def features(params: EnvParams) -> Features:
    """Returns the features that the boats of an environment observe."""
    return chosen(params.observation)


@lru_cache(maxsize=32)
def chosen(names: tuple[str | Feature, ...] | None) -> Features:
    """Returns features from names or features, in their order; with None all built-in ones.

    Raises:
        ValueError: an unknown name, a column twice, or none at all.
    """
    if names is None:
        return DEFAULT
    found = tuple(FEATURES.find(one, "observation") for one in names)
    columns = column_names(found)
    if not columns or len(set(columns)) < len(columns):
        raise ValueError(f"observation = {list(names)}: name one feature at least, each once")
    return found


def column_names(features: Features) -> tuple[str, ...]:
    """Returns the names (K,) of the columns of features."""
    return tuple(name for one in features for name in one.columns or (one.name,))


@lru_cache(maxsize=32)
def bounds(features: Features) -> Observation:
    """Returns the largest magnitudes (K,) of the columns of features, float32, read-only."""
    bound = np.array([bound for one in features for bound in one.bound], dtype=np.float32)
    bound.setflags(write=False)
    return bound


NAMES = column_names(DEFAULT)  #: (K,) names of the columns of the default observation
BOUND = bounds(DEFAULT)  #: (K,) largest magnitudes of the columns of the default observation


def observe(
    features: Features,
    sensed: Sensed,
    params: EnvParams,
    num_threads: int = 1,
    worlds: Int | None = None,
    own: bool = False,
) -> Observation:
    """Returns some features (n, A, K) of what is sensed, float32, within their bounds.

    Args:
        features: the features.
        sensed: what the boats know.
        params: parameters of the environment.
        num_threads: number of threads over which the worlds are spread.
        worlds: (n,) numbers of the worlds; None takes all.
        own: whether each boat has a row of its own in ``sensed``, row w A + a, and observes that.
    """
    layout, (views, team) = _layout(features, params), sensed.slot.shape
    count = views // team if own else views
    chosen = given(np.arange(count) if worlds is None else worlds, np.int64)
    observed = np.empty((len(chosen), team, layout.width), dtype=np.float32)
    seen = known(sensed, params)

    def run(first: int, last: int, thread: int) -> None:
        fill(first, last, chosen, seen, own, layout.book, observed)

    spread(run, len(chosen), num_threads)
    if layout.others:
        if worlds is not None:
            views_of = (worlds[:, None] * team + np.arange(team)).ravel() if own else worlds
            sensed = rows(sensed, views_of)
        _observe_others(layout, sensed, params, own, observed)
        if np.isnan(observed).any():
            broken = np.isnan(observed).any(axis=(0, 1)).argmax()
            raise FunctionError(f"{KIND} {column_names(features)[broken]!r} is not a number")
    return observed


def own_rows(values: np.ndarray) -> np.ndarray:
    """Returns each boat's own part (W, A, ...) of what every boat finds for all (W A, A, ...)."""
    team, views = values.shape[1], np.arange(len(values))
    own = values[views, views % team]
    return own.reshape(-1, team, *values.shape[2:])


class _Layout(NamedTuple):
    """Where the columns of features are in an observation."""

    width: int  #: number of columns
    book: Bound  #: of the built-in ones, for ``fill``; the others' columns are zero in it
    #: the others, with the place, the factors and the bounds of their columns
    others: tuple[tuple[Feature, slice, Float, Observation], ...]


@by_identity
def _layout(features: Features, params: EnvParams) -> _Layout:
    """Returns the layout of features."""
    sizes: dict[Scale, float] = dict(zip(SCALES, units(params), strict=True))
    scales = [sizes.get(scale, scale) for one in features for scale in one.scale]
    factor: Float = 1.0 / np.array(scales, dtype=np.float64)
    bound = bounds(features)
    source, used = np.zeros(len(factor), np.uint64), np.zeros(len(factor))
    others, end = [], 0
    for one in features:
        width = len(one.scale)
        place, end = slice(end, end + width), end + width
        if isinstance(one.value, Columns) and len(one.value.names) == width:
            source[place], used[place] = one.value.places, 1.0
        else:
            others.append((one, place, factor[place], bound[place]))
    return _Layout(end, book(params, source, used * factor, bound), tuple(others))


def _observe_others(
    layout: _Layout, sensed: Sensed, params: EnvParams, own: bool, observed: Observation
) -> None:
    """Writes the features (n, A, K) that functions of users compute.

    Where each boat has a row of its own in ``sensed``, they are computed for all boats by each.
    """
    view, (worlds, team) = View(sensed, params), sensed.slot.shape
    for feature, place, factor, bound in layout.others:
        forms = _forms(worlds, team, len(factor))
        value = values(forms, KIND, feature.name, feature.value, view)
        if value.dtype.kind == "c":
            value = np.stack([value.real, value.imag], axis=-1)
        elif value.ndim == 2:
            value = value[..., None]
        found = np.clip(value * factor, -bound, bound)
        if own:
            found = own_rows(np.broadcast_to(found, (worlds, team, len(factor))))
        observed[..., place] = found


def _forms(worlds: int, team: int, width: int) -> Forms:
    """Returns what a feature of so many columns may be; see ``Feature.value``."""
    flat, deep = ((worlds, team), (worlds, 1), (1, 1)), ((worlds, team, width), (worlds, 1, width))
    if width == 1:
        return dict.fromkeys(flat, REAL)
    return dict.fromkeys(flat if width == 2 else (), COMPLEX) | dict.fromkeys(deep, REAL)
