"""The conditions of the published suites; ``suites`` has the registry of all suites.

A published suite never changes: its ``digest`` is kept in the tests, and a suite that has to
change takes a new name.
"""

from dataclasses import replace
from typing import Any

from baselines.evaluate.conditions import Condition, Suite
from baselines.paper.paper_numbers import PAPER_GOAL

THRUST = 0.010  #: thrust of one motor of the nominal boat, N
IN_PUSH = "failure-in-push"
NOISE = {"position_noise": 0.01, "heading_noise": 0.05, "speed_noise": 0.01, "yaw_rate_noise": 0.1}
SHARED = {"shared": True, "range": None, "delay": 0.0, "dropout": 0.0}
ALIKE = {"thrust": 0.0, "boat_size": 0.0, "load": None}  #: what makes unlike teams alike
PLANK_AREA = 0.40 * 0.15  #: area of the vessels seen from above, m^2, the same for all shapes


def _water(current: str, speed: float) -> dict[str, Any]:
    return {"water": {"current": current, "current_speed": speed}}


def _noise(factor: float) -> dict[str, Any]:
    return {"sensors": {name: factor * sd for name, sd in NOISE.items()}}


def _shaped(aspect: float) -> dict[str, Any]:
    """Returns a plank of the nominal area and mass, whose drag follows from its length."""
    length = (PLANK_AREA * aspect) ** 0.5
    return {"vessel": {"length": length, "width": PLANK_AREA / length, "mass": 0.60}}


def _against(control: Condition, changes: dict[str, tuple[str, Any]]) -> list[Condition]:
    """Returns conditions by name, with a description and options: all else is as in the control."""
    return [
        replace(control, name=name, about=about, control=control.name, options=options)
        for name, (about, options) in changes.items()
    ]


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
        "gusts": ("gusts of 1 cm/s, which change within 20 s", {"water": {"gust_speed": 0.01}}),
        "actuators": (
            "thrust of each motor ±15 %, lag 0.05 to 0.3 s",
            {"variation": {"thrust": 0.15, "lag": (0.05, 0.3)}},
        ),
        "hulls": ("mass ±20 %, drag ±30 % of each hull", {"variation": {"mass": 0.2, "drag": 0.3}}),
        "unlike": (
            "thrust of each motor ±20 %, size of each boat ±15 %",
            {"variation": {"thrust": 0.2, "boat_size": 0.15}},
        ),
        "load": ("a vessel of one to two times the mass", {"variation": {"load": (1.0, 2.0)}}),
        **{
            f"shelter-{share:.2f}": (
                f"hulls that touch shelter each other, by {100 * share:.0f} %",
                {"water": {"shelter": share}},
            )
            for share in (0.15, 0.3)
        },
        **{
            f"sensing-delay-{ms}": (
                f"measurements are {ms} ms old",
                {"sensors": {"delay": ms / 1000}},
            )
            for ms in (100, 200, 300)
        },
        **{
            f"actuation-delay-{ms}": (
                f"commands arrive after {ms} ms",
                {"variation": {"actuation_delay": ms / 1000}},
            )
            for ms in (100, 200, 300)
        },
        "dropout": ("half of the measurements are lost", {"sensors": {"dropout": 0.5}}),
        "friction-low": ("contact friction 0.1", {"water": {"contact_friction": 0.1}}),
        "friction-high": ("contact friction 0.6", {"water": {"contact_friction": 0.6}}),
        "holding-10": ("the goal pose is held for 10 s", {"delivery_time": 10.0}),
    }
    other_gyre = {"gyre_size": 1.0, "gyre_phase": 1.0}
    unseen = {
        "gyre-other": (
            "double gyre of 1 cm/s, of smaller cells at another place",
            {"water": {"current": "double_gyre", "current_speed": 0.01, **other_gyre}},
        ),
        "friction-0.05": ("contact friction 0.05", {"water": {"contact_friction": 0.05}}),
        "friction-0.8": ("contact friction 0.8", {"water": {"contact_friction": 0.8}}),
        "thrust-weak": ("30 % less thrust", {"boat": {"thrust": 0.7 * THRUST}}),
        "thrust-strong": ("30 % more thrust", {"boat": {"thrust": 1.3 * THRUST}}),
        "heavy": ("a vessel of three times the mass", {"variation": {"load": (3.0, 3.0)}}),
    }
    harsh, failing = "scenario `harsh`: all at once, a failing boat", "one of six boats fails"
    four_failing = Condition(
        "failure-in-push", "one of four boats fails in the push", "control", scenario=IN_PUSH
    )
    return (
        control,
        *_against(control, disturbed),
        Condition("harsh", harsh, "control", scenario="harsh"),
        six,
        replace(six, name="failure-6", about=failing, control=six.name, scenario="failure"),
        *map(_unseen, (*_against(control, unseen), four_failing)),
    )


def _unseen(condition: Condition) -> Condition:
    """Returns a condition that no training may contain."""
    return replace(condition, out_of_distribution=True)


def _teams() -> tuple[Condition, ...]:
    noisy = Condition("", scenario="noisy")
    return tuple(
        replace(noisy, name=f"{n}-boats", about=f"{n} boats, scenario `noisy`", num_boats=n)
        for n in (2, 3, 4, 6, 8, 12, 20, 32)
    )


def _shapes() -> tuple[Condition, ...]:
    plank = Condition("plank", "the nominal plank, 2.67 times as long as wide", scenario="noisy")
    others = {
        f"aspect-{ratio:g}": (f"length {ratio:g} times the width, scenario `noisy`", _shaped(ratio))
        for ratio in (1.0, 1.5, 2.0, 4.0, 6.0)
    }
    others["no-fins"] = "the plank without its fins, scenario `noisy`", {"vessel": {"fins": 0.0}}
    for name in ("disc", "triangle", "hexagon", "barge", "L", "T"):
        others[name] = f"hull `{name}`, scenario `noisy`", {"vessel": name}
    return (plank, *_against(plank, others))


def _easy() -> tuple[Condition, ...]:
    easy: dict[str, Any] = {"difficulty": "easy"}
    push = Condition("push", "a short push straight ahead", task="push", options=easy)
    noise = "the same, measured with noise"
    return (
        push,
        replace(push, name="push-noisy", about=noise, control=push.name, scenario="noisy"),
        Condition("approach", "boats begin near the vessel", task="approach", options=easy),
        Condition("transport", "approach and push", options=easy),
    )


def _harbours() -> tuple[Condition, ...]:
    abouts = {
        "pillars": "round pillars on the way to the goal",
        "channel": "two banks, between which the vessel goes to its goal",
        "dock": "a goal between two piers",
    }
    exact = [Condition(name, about, options={"obstacles": name}) for name, about in abouts.items()]
    noise = "the same, measured with noise"
    noisy = [
        replace(one, name=f"{one.name}-noisy", about=noise, control=one.name, scenario="noisy")
        for one in exact
    ]
    return tuple(condition for pair in zip(exact, noisy, strict=True) for condition in pair)


def _sensing() -> tuple[Condition, ...]:
    shared = Condition("shared", "one noisy measurement for all boats", scenario="noisy")

    def own(**sensors: Any) -> dict[str, Any]:
        return {"sensors": {**NOISE, "shared": False, **sensors}}

    changes = {
        "own": ("every boat measures for itself, with as much noise", own()),
        **{
            f"range-{reach:g}": (f"own sensing up to {reach:g} m", own(range=reach))
            for reach in (1.5, 1.0, 0.6)
        },
        **{
            f"delay-{ms}": (f"own sensing, {ms} ms old", own(delay=ms / 1000))
            for ms in (100, 200, 300)
        },
        **{
            f"dropout-{100 * lost:.0f}": (
                f"own sensing, {100 * lost:.0f} % of it lost",
                own(dropout=lost),
            )
            for lost in (0.25, 0.5)
        },
        "all": (
            "own sensing up to 1 m, 200 ms old, 10 % of it lost",
            own(range=1.0, delay=0.2, dropout=0.1),
        ),
    }
    return (shared, *_against(shared, changes))


def _hard() -> tuple[Condition, ...]:
    options: dict[str, Any] = {"difficulty": "hard"}
    hard = Condition("hard", "difficulty `hard`: all at once", options=options)
    without: dict[str, tuple[str, dict[str, Any]]] = {
        "open-water": ("hard, without the dock", {"obstacles": "none"}),
        "shared-sensing": ("hard, with one measurement for all", {"sensors": SHARED}),
        "steady-water": ("hard, without gusts", {"water": {"gust_speed": 0.0}}),
        "alike": ("hard, with boats alike and a known load", {"variation": ALIKE}),
    }
    changes = {name: (about, {**options, **more}) for name, (about, more) in without.items()}
    return (hard, *_against(hard, changes))


_PLANE = (
    Condition("nominal", "goals over the whole plane"),
    Condition("noisy", "the same, measured with noise", "nominal", scenario="noisy"),
)


def _papers() -> tuple[Condition, ...]:
    """Returns the paper's tasks, with the time that its approach of 80 s and detours take."""
    options: dict[str, Any] = {"time_limit": 600.0}
    about = "the paper's goal, from the pose at closure, delivered by passing"
    goal = Condition("nominal", about, preset="experiment", options=options)
    holding: dict[str, Any] = {**options, "delivery": "holding"}
    plane = Condition("plane", "goals over the whole plane", options=options)
    noise = "the same, measured with noise"
    return (
        goal,
        replace(goal, name="noisy", about=noise, control=goal.name, scenario="noisy"),
        replace(goal, name="holding", about="delivered by holding", options=holding),
        plane,
        replace(plane, name="plane-noisy", about=noise, control=plane.name, scenario="noisy"),
    )


PUBLISHED = (
    Suite(
        "quick-v2",
        "Two minutes on a laptop: the paper's goal and goals over the plane.",
        (
            Condition("paper-goal", "one goal for all", options={"goal": PAPER_GOAL}),
            Condition("plane", "goals over the whole plane"),
            Condition("noisy", "the same, measured with noise", "plane", scenario="noisy"),
        ),
        seed=1_000_000,
        episodes=60,
    ),
    Suite(
        "paper-v2",
        "The paper's experiment with its goal and with others, and 600 s for each.",
        _papers(),
        2_000_000,
    ),
    Suite("plane-v2", "Goals anywhere around the vessel, any heading.", _PLANE, 3_000_000),
    Suite(
        "robust-v2",
        "Disturbances one by one, each compared with its control.",
        _robust(),
        4_000_000,
    ),
    Suite("team-v2", "Teams of 2 to 32 boats; the vessel grows with them.", _teams(), 5_000_000),
    Suite("shape-v2", "Vessels of other shapes, and one without fins.", _shapes(), 6_000_000),
    Suite("easy-v1", "Short ways, for a first success.", _easy(), 7_000_000),
    Suite("harbour-v1", "Goals among obstacles.", _harbours(), 7_500_000),
    Suite(
        "sensing-v1",
        "Boats that see for themselves: how far, how late, how often.",
        _sensing(),
        8_000_000,
    ),
    Suite(
        "hard-v1",
        "A dock, own sensing, gusts, unlike boats and an unknown load at once.",
        _hard(),
        8_500_000,
    ),
)
