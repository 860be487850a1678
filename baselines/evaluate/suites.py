"""The published suites: frozen sets of episodes, on which results can be compared for years.

What a published name means is never changed; its ``digest`` is kept in the tests, and a changed
suite takes a new name.
"""

from __future__ import annotations

from typing import Any

from baselines.evaluate.conditions import Condition, Suite
from baselines.paper.experiment import PAPER_GOAL

PLANK_AREA = 0.40 * 0.15
"""Of the vessel seen from above, m^2; the same for all shapes, and so is its mass."""


def _water(current: str, speed: float) -> dict[str, Any]:
    return {"water": {"current": current, "current_speed": speed}}


def _noise(factor: float) -> dict[str, Any]:
    noise = {"position": 0.01, "heading": 0.05, "speed": 0.01, "yaw_rate": 0.1}
    return {"sensors": {f"{name}_noise": factor * sd for name, sd in noise.items()}}


def _shaped(aspect: float) -> dict[str, Any]:
    """A plank of the nominal area and mass; its drag follows its length."""
    length = (PLANK_AREA * aspect) ** 0.5
    return {"vessel": {"length": length, "width": PLANK_AREA / length, "mass": 0.60}}


def _robust() -> tuple[Condition, ...]:
    control = Condition("control", "four boats, still water, exact measurement")
    six = Condition("control-6", "the same with six boats", num_boats=6)
    disturbed = {
        "noise-half": ("half the noise of `noisy`", _noise(0.5)),
        "noise": ("the noise of `noisy`", _noise(1.0)),
        "noise-double": ("twice that noise", _noise(2.0)),
        "current-1": ("uniform current of 1 cm/s", _water("uniform", 0.01)),
        "current-2": ("uniform current of 2 cm/s", _water("uniform", 0.02)),
        "gyre-1": ("double gyre, 1 cm/s at its fastest", _water("double_gyre", 0.01)),
        "gyre-2": ("double gyre, 2 cm/s at its fastest", _water("double_gyre", 0.02)),
        "actuators": (
            "thrust of each motor ±15 %, lag 0.05 to 0.3 s",
            {"variation": {"thrust": 0.15, "lag": (0.05, 0.3)}},
        ),
        "hulls": (
            "mass ±20 %, drag ±30 % of each hull",
            {"variation": {"mass": 0.2, "drag": 0.3}},
        ),
        "friction-low": ("contact friction 0.1", {"water": {"contact_friction": 0.1}}),
        "friction-high": ("contact friction 0.6", {"water": {"contact_friction": 0.6}}),
    }
    conditions = [
        Condition(name, about, control.name, options=options)
        for name, (about, options) in disturbed.items()
    ]
    return (
        control,
        *conditions,
        Condition(
            "harsh", "scenario `harsh`: all at once, a failing boat", "control", scenario="harsh"
        ),
        six,
        Condition("failure-6", "one of six boats fails", six.name, scenario="failure", num_boats=6),
    )


def _teams() -> tuple[Condition, ...]:
    return tuple(
        Condition(
            f"{team}-boats", f"{team} boats, scenario `noisy`", scenario="noisy", num_boats=team
        )
        for team in (2, 3, 4, 6, 8, 12, 20, 32)
    )


def _shapes() -> tuple[Condition, ...]:
    aspects = [
        Condition(
            f"aspect-{aspect:g}",
            f"length {aspect:g} times the width, scenario `noisy`",
            "plank",
            scenario="noisy",
            options=_shaped(aspect),
        )
        for aspect in (1.0, 1.5, 2.0, 4.0, 6.0)
    ]
    return (
        Condition("plank", "the nominal plank, 2.67 times as long as wide", scenario="noisy"),
        *aspects,
        Condition(
            "no-fins",
            "the plank without its fins, scenario `noisy`",
            "plank",
            scenario="noisy",
            options={"vessel": {"fins": 0.0}},
        ),
    )


_PLANE = (
    Condition("nominal", "goals over the whole plane"),
    Condition("noisy", "the same, measured with noise", "nominal", scenario="noisy"),
)
_PAPER = (
    Condition("nominal", "the paper's goal, from the pose at closure", preset="experiment"),
    Condition(
        "noisy", "the same, measured with noise", "nominal", scenario="noisy", preset="experiment"
    ),
)
SUITES = {
    suite.name: suite
    for suite in (
        Suite(
            "quick-v1",
            "Two minutes on a laptop: the paper's goal and goals over the plane.",
            (
                Condition("paper-goal", "one goal for all", options={"goal": PAPER_GOAL}),
                Condition("plane", "goals over the whole plane"),
                Condition("noisy", "the same, measured with noise", "plane", scenario="noisy"),
            ),
            seed=1_000_000,
            episodes=60,
        ),
        Suite("paper-v1", "The paper's experiment: one goal pose, four boats.", _PAPER, 2_000_000),
        Suite("plane-v1", "Goals anywhere around the vessel, any heading.", _PLANE, 3_000_000),
        Suite(
            "robust-v1", "Disturbances one by one, each beside its control.", _robust(), 4_000_000
        ),
        Suite(
            "team-v1", "Teams of 2 to 32 boats; the vessel grows with them.", _teams(), 5_000_000
        ),
        Suite("shape-v1", "Vessels of other shapes, and one without fins.", _shapes(), 6_000_000),
    )
}
"""The published suites by name."""
