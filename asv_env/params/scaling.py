"""Froude's law: worlds of another size in which the same happens, more slowly or faster.

With lengths k times as long in the same water and gravity, times and speeds are sqrt(k) times as
large, masses and forces k^3. Reynolds' number does not stay the same, so drag coefficients are
taken as equal; see ``docs/physics.md``.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar

from asv_env.checks import Number
from asv_env.params.hull_params import BoatParams, HullParams, VesselParams
from asv_env.params.obstacle_params import Circle, Polygon, Segment
from asv_env.params.surroundings import ClockParams, SensorParams, VariationParams, WaterParams
from asv_env.params.task_params import RewardParams, TaskParams

Section = TypeVar("Section")
Exponents = Mapping[str, float | tuple[float, ...]]

SCALE = Number(0.1, 100.0)  #: what a scale may be
HULL: Exponents = {
    "length": 1, "width": 1, "mass": 3, "added_mass": 3, "inertia": 5, "added_inertia": 5,
    "surge": (2.5, 2), "sway": (2.5, 2), "yaw": (4.5, 5),
}  # fmt: skip
EXPONENTS: dict[type, Exponents] = {
    HullParams: HULL,
    BoatParams: {
        **HULL, "bow": 1, "thrust": 3, "lever_arm": 1, "lag": 0.5, "full_speed": 0.5,
        "full_yaw_rate": -0.5, "response": 0.5, "acceleration": (0, -1),
    },
    VesselParams: {**HULL, "fins": 2, "outline": 1},
    WaterParams: {
        "linear_speed": 0.5, "linear_yaw_rate": -0.5, "current_speed": 0.5, "gyre_size": 1,
        "gust_speed": 0.5, "gust_time": 0.5, "walls": 1,
    },
    SensorParams: {
        "range": 1, "delay": 0.5, "position_noise": 1, "speed_noise": 0.5, "yaw_rate_noise": -0.5,
        "yaw_acceleration": -1, "vessel_yaw_acceleration": -1,
    },
    VariationParams: {"lag": 0.5, "actuation_delay": 0.5, "failure_time": 0.5},
    TaskParams: {
        "goal": (1, 1, 0), "goal_distance": 1, "start_distance": 1, "arena": 1,
        "position_tolerance": 1, "slot_distance": 1, "end_gap": 1, "time_limit": 0.5,
        "delivery_time": 0.5, "hold_time": 0.5, "speed_tolerance": 0.5, "passing_speed": 0.5,
        "nearing_tolerance": 0.5, "slot_speed": 0.5, "yaw_rate_tolerance": -0.5,
        "passing_yaw_rate": -0.5,
    },
    RewardParams: {"time": -0.5, "effort": -0.5, "collision": -0.5},
    Circle: {"centre": 1, "radius": 1},
    Segment: {"start": 1, "end": 1, "radius": 1},
    Polygon: {"corners": 1},
}  # fmt: skip
"""Powers of the scale by which numbers of parameters grow; those that are left out stay."""
MOTION = (1.0, 1.0, 0.0, 0.5, 0.5, -0.5)
"""Those of a motion: x, y, heading, vx, vy, yaw rate."""


def scaled(section: Section, factor: float) -> Section:
    """Returns a section of parameters of a world ``factor`` times as long.

    Rates of clocks are rounded to whole numbers, and remain multiples of each other.
    """
    if factor == 1.0:
        return section
    if isinstance(section, ClockParams):
        return _clock(section, factor)  # type: ignore[return-value]
    table = EXPONENTS[type(section)]
    changes = {name: _times(getattr(section, name), table[name], factor) for name in table}
    return replace(section, **changes)  # type: ignore[type-var]


def scaled_shapes(obstacles: Any, factor: float) -> Any:
    """Returns the obstacles of a world so many times as long; layouts fit worlds of any size."""
    if not isinstance(obstacles, tuple):
        return obstacles
    return tuple(scaled(shape, factor) for shape in obstacles)


def overrides(layer: Mapping[str, Any], kinds: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """Returns sections, or mappings of their fields, as they are in a world so many times as long.

    Args:
        layer: by the names of sections.
        kinds: class of each section.
        factor: how many times as long.
    """
    if factor == 1.0:
        return dict(layer)
    result: dict[str, Any] = {}
    for name, section in layer.items():
        kind = kinds[name]
        if not isinstance(section, Mapping):
            result[name] = scaled(section, factor)
        elif kind is ClockParams:
            result[name] = {f: _rate(rate, factor) for f, rate in section.items()}
        else:
            table = EXPONENTS[kind]
            result[name] = {
                field: _times(value, table.get(field, 0), factor)
                for field, value in section.items()
            }
    return result


def _times(value: Any, exponent: float | tuple[float, ...], factor: float) -> Any:
    """Returns a number, or tuple of numbers, times a power, or powers, of the factor.

    Names stay, and so does None.
    """
    if value is None or exponent == 0 or isinstance(value, str):
        return value
    if isinstance(value, tuple | list):
        powers = exponent if isinstance(exponent, tuple) else (exponent,) * len(value)
        return tuple(_times(v, p, factor) for v, p in zip(value, powers, strict=True))
    return value * factor**exponent  # type: ignore[operator]


def _rate(rate: int, factor: float) -> int:
    return max(1, round(rate / math.sqrt(factor)))


def _clock(clock: ClockParams, factor: float) -> ClockParams:
    control = _rate(clock.control, factor)
    sensing = control * (clock.sensing // clock.control)
    return ClockParams(sensing * (clock.physics // clock.sensing), sensing, control)
