"""The published suites: frozen sets of episodes, on which results can be compared for years.

A published suite never changes: its ``digest`` is kept in the tests, and a suite that has to
change takes a new name. ``SUITES.register`` adds one of your own.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from asv_env.params import EnvParams
from asv_env.registry import Registry
from asv_env.text import shown
from baselines.evaluate.conditions import CUSTOM, Condition, Suite
from baselines.paper.paper_numbers import PAPER_GOAL
from baselines.rollout import seeds

PLANK_AREA = 0.40 * 0.15  #: area of the vessels seen from above, m^2, the same for all shapes


def _water(current: str, speed: float) -> dict[str, Any]:
    return {"water": {"current": current, "current_speed": speed}}


def _noise(factor: float) -> dict[str, Any]:
    noise = {"position": 0.01, "heading": 0.05, "speed": 0.01, "yaw_rate": 0.1}
    return {"sensors": {f"{name}_noise": factor * sd for name, sd in noise.items()}}


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
        "actuators": (
            "thrust of each motor ±15 %, lag 0.05 to 0.3 s",
            {"variation": {"thrust": 0.15, "lag": (0.05, 0.3)}},
        ),
        "hulls": ("mass ±20 %, drag ±30 % of each hull", {"variation": {"mass": 0.2, "drag": 0.3}}),
        "shelter": ("hulls that touch shelter each other, by 30 %", {"water": {"shelter": 0.3}}),
        "sensing-delay": ("measurements are 200 ms old", {"sensors": {"delay": 0.2}}),
        "actuation-delay": (
            "commands arrive after 200 ms",
            {"variation": {"actuation_delay": 0.2}},
        ),
        "dropout": ("half of the measurements are lost", {"sensors": {"dropout": 0.5}}),
        "friction-low": ("contact friction 0.1", {"water": {"contact_friction": 0.1}}),
        "friction-high": ("contact friction 0.6", {"water": {"contact_friction": 0.6}}),
    }
    harsh, failing = "scenario `harsh`: all at once, a failing boat", "one of six boats fails"
    return (
        control,
        *_against(control, disturbed),
        Condition("harsh", harsh, "control", scenario="harsh"),
        six,
        replace(six, name="failure-6", about=failing, control=six.name, scenario="failure"),
    )


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
    return (plank, *_against(plank, others))


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
)
SUITES: Registry[Suite] = Registry(
    "suite", {s.name: s for s in PUBLISHED}, lambda thing: isinstance(thing, Suite)
)  #: suites by name


def find(given: str | Suite | Condition | EnvParams | Sequence[Condition]) -> Suite:
    """Returns the suite of a name, of conditions, or of an environment's parameters.

    Raises:
        ValueError, TypeError: an unknown name, two conditions of the same name, or something else.
    """
    if isinstance(given, str | Suite):
        return SUITES.find(given)
    if isinstance(given, EnvParams):
        given = Condition(CUSTOM, environment=given)
    conditions = (given,) if isinstance(given, Condition) else tuple(given)
    if not conditions or not all(isinstance(one, Condition) for one in conditions):
        raise TypeError(f"suite={shown(given)}: give a name, a Suite, Conditions or EnvParams")
    return Suite(CUSTOM, "Conditions given from Python.", conditions, episodes=100)


def sweep(
    task: Sequence[Any] = ("transport",),
    scenario: Sequence[Any] = ("nominal",),
    num_boats: Sequence[int | None] = (None,),
    preset: str = "nominal",
    goal: tuple[float, ...] | None = None,
    seed: int = 0,
    episodes: int = 100,
    difficulty: str = "standard",
) -> Suite:
    """Returns a suite with a condition for each combination of task, scenario and team size.

    They are as in ``Condition``, seed and episodes as in ``Suite``, the difficulty as in
    ``make_params``. The goal is a pose of the
    vessel, m, m, rad; None draws one for each episode.

    Raises:
        ValueError: an unknown name, a value out of range, or one that is given twice.
    """
    for name, values in {"task": task, "scenario": scenario, "num_boats": num_boats}.items():
        if any(value in values[:k] for k, value in enumerate(values)):
            raise ValueError(f"{name}={' '.join(map(str, values))}: name each once")
    if seed < 0:
        raise ValueError(f"seed={seed}: must be at least 0")
    if seed >= seeds.TRAINING.stop:
        raise ValueError(f"seed={seed}: must lie below {seeds.TRAINING.stop}")
    options: dict[str, Any] = {} if goal is None else {"goal": goal}
    if difficulty != "standard":
        options["difficulty"] = difficulty
    conditions = []
    for one_task, one_scenario, team in product(task, scenario, num_boats):
        condition = Condition("", "", None, one_task, one_scenario, preset, team, options)
        parts = [condition.task_name] * (len(task) > 1)
        parts += [f"{condition.params.num_boats} boats"] * (len(num_boats) > 1)
        parts += [condition.scenario_name] * (len(scenario) > 1 or not parts)
        conditions.append(replace(condition, name=", ".join(parts)))
    names = [[c.task_name for c in conditions], [c.scenario_name for c in conditions]]
    about = "; ".join(", ".join(dict.fromkeys(own)) for own in names)
    return Suite(CUSTOM, about, tuple(conditions), seed, episodes)
