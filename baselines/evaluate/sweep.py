"""A suite of one's own: several tasks, scenarios and team sizes, crossed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

from baselines.evaluate.conditions import CUSTOM, Condition, Suite
from baselines.rollout import seeds


def sweep(
    task: Sequence[Any] = ("transport",),
    scenario: Sequence[Any] = ("nominal",),
    num_boats: Sequence[int | None] = (None,),
    preset: str = "nominal",
    goal: tuple[float, ...] | None = None,
    seed: int = 0,
    episodes: int = 100,
) -> Suite:
    """Returns a suite with a condition for each combination of task, scenario and team size.

    Args:
        task: tasks, as in ``Condition``.
        scenario: scenarios, as in ``Condition``.
        num_boats: team sizes; None is the preset's.
        preset: as in ``make_params``.
        goal: pose of the vessel at the goal, m, m, rad; None draws one for each episode.
        seed: seed of the first episode.
        episodes: number of episodes of each condition.

    Raises:
        ValueError: an unknown name, a value out of range, or one that is given twice.
    """
    for name, values in {"task": task, "scenario": scenario, "num_boats": num_boats}.items():
        if any(value in values[:k] for k, value in enumerate(values)):
            raise ValueError(f"{name}={' '.join(map(str, values))}: name each once")
    if seed < 0:
        raise ValueError(f"seed={seed}: must be at least 0")
    if seed + episodes >= seeds.TRAINING.stop:
        raise ValueError(f"seed={seed}: must lie below {seeds.TRAINING.stop}")
    options: dict[str, Any] = {} if goal is None else {"goal": goal}
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
