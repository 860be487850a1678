"""Every parameter of the environment: frozen dataclasses in SI units, validated when made."""

from asv_env.checks import TINY
from asv_env.params.discrete_actions import DISCRETE_ACTIONS
from asv_env.params.env_params import ACTION_MODES, SMALLEST_CAGE, EnvParams, pitches
from asv_env.params.hull_params import (
    NOMINAL_LENGTH,
    THRUST_LAWS,
    BoatParams,
    HullParams,
    VesselParams,
)
from asv_env.params.obstacle_params import Circle, Polygon, Segment
from asv_env.params.surroundings import ClockParams, SensorParams, VariationParams, WaterParams
from asv_env.params.task_params import GOAL_ANCHORS, SIDES, RewardParams, TaskParams

__all__ = [
    "ACTION_MODES", "DISCRETE_ACTIONS", "GOAL_ANCHORS", "NOMINAL_LENGTH", "SIDES", "SMALLEST_CAGE",
    "THRUST_LAWS", "TINY",
    "BoatParams", "Circle", "ClockParams", "EnvParams", "HullParams", "Polygon", "RewardParams",
    "Segment", "SensorParams", "TaskParams", "VariationParams", "VesselParams",
    "WaterParams", "pitches",
]  # fmt: skip
