"""Causes of failure of the built-in tasks; each excludes those before it in a task's list."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from asv_env.params import EnvParams
from asv_env.tasks.task import Failure

Summary = Mapping[str, Any]


def _strayed(summary: Summary, params: EnvParams) -> bool:
    return bool(summary["strayed"])


def _no_closure(summary: Summary, params: EnvParams) -> bool:
    return math.isnan(summary["time_to_closure"])


def _never_near(summary: Summary, params: EnvParams) -> bool:
    return bool(summary["min_position_error"] > params.task.position_tolerance)


def _heading_off(summary: Summary, params: EnvParams) -> bool:
    return bool(abs(summary["heading_error_at_min"]) > params.task.heading_tolerance)


def _otherwise(summary: Summary, params: EnvParams) -> bool:
    return True


STRAYED = Failure("strayed", _strayed)
"""A body left the arena."""
NO_CLOSURE = Failure("no closure", _no_closure)
"""The vessel was never in closure."""
GRASP_NOT_HELD = Failure("grasp not held", _otherwise)
"""The slots were not occupied for long enough."""
NEVER_NEAR = Failure("never near", _never_near)
"""The vessel never came within the tolerance of position."""
HEADING_OFF = Failure("heading off", _heading_off)
"""The vessel's heading was off when it was nearest."""
NOT_SETTLED = Failure("not settled", _otherwise)
"""The vessel was at the goal, but too fast."""
OF_DELIVERY = (NEVER_NEAR, HEADING_OFF, NOT_SETTLED)
"""Causes for which a vessel in closure is not delivered."""
