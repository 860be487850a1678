"""What a boat observes: a list of named features, whose size does not depend on the team's.

All features are computed from ``Sensed``. Each is divided by a fixed scale and clipped, so
that no running statistics are needed. Lengths are in vessel lengths, so that one policy serves
every size; quantities that must be met to the centimetre appear a second time, magnified.

An environment takes ``observation=[...]``: names of ``FEATURES``, or ``Feature`` objects.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from asv_env.checks import COMPLEX, REAL, FunctionError, values
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.registry import Registry
from asv_env.sensing.view import NEIGHBOURS, View, nearest_boats
from asv_env.tasks.formation import Relations
from asv_env.types import Float, Observation, Sensed

KIND = "feature"  #: word for a feature in messages
FAR = 15.0  #: largest distance in an observation, vessel lengths: more than the arena's diagonal
FAST = 4.0  #: largest speed in an observation, full speeds and full yaw rates of a boat
FINE = 0.1  #: distance at which magnified features saturate, m
FINE_ANGLE = 0.1  #: angle at which magnified features saturate, rad
FINE_SPEED = 0.04  #: speed of the vessel at which magnified features saturate, m/s
FINE_YAW_RATE = 0.15  #: yaw rate of the vessel at which magnified features saturate, rad/s
VERSION = 2  #: of what features mean; grows where a trained policy would be misled
LENGTH, SPEED, YAW_RATE = "length", "speed", "yaw_rate"
"""Scales from parameters: the vessel's length, speed and yaw rate of a full tracking action."""
SCALES = (LENGTH, SPEED, YAW_RATE)
Units = tuple[float, float, float]  #: what these scales are, m, m/s, rad/s
Scale = float | str  #: divisor of a column: a number, or one of these names
Value = Callable[[View], np.ndarray]
"""Function from a view to (W, A) or (W, 1): real for one column, complex x + iy for two; or to
(W, A, n) for n columns."""
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
            ``YAW_RATE`` for those of a full tracking action.
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
        return hash(self.name)  # Every step looks up what belongs to features.

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickles built-in features by name: most of their functions have none."""
        if any(self is one for one in DEFAULT):
            return _built_in, (self.name,)
        return super().__reduce_ex__(protocol)


def _built_in(name: str) -> Feature:
    return next(one for one in DEFAULT if one.name == name)


def scalar(name: str, scale: Scale, bound: float, value: Value) -> Feature:
    """Returns a feature of one column, ``value`` / ``scale`` clipped to +-``bound``."""
    return Feature(name, value, (scale,), (bound,), (name,))


def vector(name: str, scale: Scale, bound: float, value: Value) -> Feature:
    """Returns a feature of two columns, x and y, from a complex ``value`` x + iy."""
    return Feature(name, value, (scale,) * 2, (bound,) * 2, (f"{name}_x", f"{name}_y"))


def _vessel_velocity(v: View) -> np.ndarray:
    return v.relations.velocity[:, :1] * v.to_vessel


DEFAULT = (
    # Vectors in the boat's frame, or relative to the slot.
    vector("own_velocity", SPEED, FAST, lambda v: v.relations.velocity[:, 1:] * v.to_boat),
    vector("slot", LENGTH, FAR, lambda v: v.slot),
    vector("slot_fine", FINE, 1.0, lambda v: v.slot),
    vector("slot_alignment", 1.0, 1.0, lambda v: v.relations.alignment),
    # Vectors in the vessel's frame.
    vector("own_position", LENGTH, FAR, lambda v: v.relations.boat),
    vector("slot_position", LENGTH, FAR, lambda v: v.sensed.slot),
    vector("vessel_velocity", SPEED, FAST, _vessel_velocity),
    vector("goal", LENGTH, FAR, lambda v: v.relations.goal[:, None]),
    vector("goal_fine", FINE, 1.0, lambda v: v.relations.goal[:, None]),
    vector("goal_direction", 1.0, 1.0, lambda v: v.relations.goal_turn[:, None]),
    vector("vessel_velocity_fine", FINE_SPEED, 1.0, _vessel_velocity),
    # Scalars.
    scalar("own_yaw_rate", YAW_RATE, FAST, lambda v: v.relations.yaw_rate[:, 1:]),
    scalar("vessel_yaw_rate", YAW_RATE, FAST, lambda v: v.relations.yaw_rate[:, :1]),
    scalar("touches_vessel", 1.0, 1.0, lambda v: v.sensed.touching[..., 0]),
    scalar("touches_other", 1.0, 1.0, lambda v: v.sensed.touching[..., 1]),
    scalar("thrusters_work", 1.0, 1.0, lambda v: v.sensed.working),
    scalar("slots_occupied", 1.0, 1.0, lambda v: v.slots_occupied[:, None]),
    scalar("closure", 1.0, 1.0, lambda v: v.sensed.closed[:, None]),
    scalar("turn_to_goal_fine", FINE_ANGLE, 1.0, lambda v: -v.relations.heading_error[:, None]),
    scalar("vessel_yaw_rate_fine", FINE_YAW_RATE, 1.0, lambda v: v.relations.yaw_rate[:, :1]),
    scalar("inverse_team_size", 0.5, 2.0, lambda v: v.inverse_team[:, None]),
    scalar("inverse_vessel_length", 1.0 / NOMINAL_LENGTH, 4.0, lambda v: v.inverse_length),
    Feature(
        "neighbours",
        nearest_boats,
        (LENGTH, LENGTH, SPEED, SPEED, 1.0) * NEIGHBOURS,
        (FAR, FAR, FAST, FAST, 1.0) * NEIGHBOURS,
        tuple(
            f"neighbour_{k + 1}_{name}"
            for k in range(NEIGHBOURS)
            for name in ("x", "y", "vx", "vy", "present")
        ),
    ),
)  #: features that are observed by default
FEATURES: Registry[Feature] = Registry(
    "feature", {one.name: one for one in DEFAULT}, lambda thing: isinstance(thing, Feature)
)
"""Features by name, in the order in which they are observed by default."""


def units(params: EnvParams) -> Units:
    """Returns what ``SCALES`` are, m, m/s and rad/s."""
    return params.vessel.length, params.boat.full_speed, params.boat.full_yaw_rate


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
    features: Features, sensed: Sensed, relations: Relations, params: EnvParams
) -> Observation:
    """Returns some features (W, A, K) of what is sensed, float32, within their bounds.

    ``relations`` are those of ``sensed.estimate``.
    """
    view = View(sensed, relations, params)
    layout, factors, bound = _layout(features, *sensed.slot.shape, units(params))
    columns = np.zeros((*sensed.slot.shape, len(bound)))
    for feature, place, forms in layout:
        value = values(forms, KIND, feature.name, feature.value, view)
        if len(feature.scale) == 1:
            columns[..., place.start] = value
        elif value.dtype.kind == "c":
            columns[..., place].view(np.complex128)[..., 0] = value
        else:
            columns[..., place] = value
    columns *= factors
    # Two passes of these take less time than one of clip.
    np.maximum(columns, -bound, out=columns)
    observed = np.minimum(columns, bound, dtype=np.float32, casting="same_kind")
    if np.isnan(observed).any():
        broken = np.isnan(observed).any(axis=(0, 1)).argmax()
        raise FunctionError(f"{KIND} {column_names(features)[broken]!r} is not a number")
    return observed


@lru_cache(maxsize=128)
def _layout(
    features: Features, worlds: int, team: int, units: Units
) -> tuple[tuple[tuple[Feature, slice, Forms], ...], Float, Observation]:
    """Returns where the columns of each feature are and what its values may be, for W worlds.

    Factors on all columns (K,), for these ``units``, and their bounds (K,) follow.
    """
    ends = np.cumsum([len(one.scale) for one in features]).tolist()
    places = (slice(end - len(one.scale), end) for one, end in zip(features, ends, strict=True))
    forms = (_forms(worlds, team, len(one.scale)) for one in features)
    sizes: dict[Scale, float] = dict(zip(SCALES, units, strict=True))
    scales = [sizes.get(scale, scale) for one in features for scale in one.scale]
    factors: Float = 1.0 / np.array(scales, dtype=np.float64)
    factors.setflags(write=False)
    return tuple(zip(features, places, forms, strict=True)), factors, bounds(features)


def _forms(worlds: int, team: int, width: int) -> Forms:
    """Returns what a feature of so many columns may be; see ``Feature.value``."""
    flat, deep = ((worlds, team), (worlds, 1), (1, 1)), ((worlds, team, width), (worlds, 1, width))
    if width == 1:
        return dict.fromkeys(flat, REAL)
    return dict.fromkeys(flat if width == 2 else (), COMPLEX) | dict.fromkeys(deep, REAL)
