"""Suites by name, and suites made of a name, of conditions, of parameters or of a sweep.

``SUITES.register`` adds one of your own.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from asv_env.params import EnvParams
from asv_env.registry import Registry
from asv_env.text import shown
from baselines.evaluate.conditions import CUSTOM, Condition, Suite
from baselines.evaluate.published_suites import PUBLISHED
from baselines.rollout import seeds

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
