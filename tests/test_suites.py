"""The published suites stay what they are, and seeds stay apart."""

from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest

from asv_env import polygons
from asv_env.tasks import starts
from baselines.evaluate.conditions import Condition
from baselines.evaluate.suites import SUITES
from baselines.paper.paper_numbers import PAPER_GOAL
from baselines.rollout import seeds

FROZEN = {
    "quick-v2": "9c6da706b9dd4aad",
    "paper-v2": "4392a46664938072",
    "plane-v2": "f7daf635fc8a6026",
    "robust-v2": "1823a08fc7c50563",
    "team-v2": "5f7ee1e88cceb22c",
    "shape-v2": "7ef45797481d0e8b",
    "easy-v1": "7584c9c397ec07e5",
    "harbour-v1": "97a30ec94c06afb6",
    "sensing-v1": "391e0e0cbcdfbd75",
    "hard-v1": "14c1d77b8b77d7ee",
}
"""Digests of what was published. A suite that has to change takes a new name, with a new line."""


def initial_state(condition, seed):
    return starts.sample(condition.params, np.random.default_rng(seed))


@pytest.mark.parametrize("name", SUITES)
def test_a_published_suite_is_what_it_was(name):
    assert SUITES[name].digest() == FROZEN[name]


def test_the_digest_follows_conditions_seeds_and_task_but_not_the_number_of_episodes():
    suite = SUITES["plane-v2"]
    first, *others = suite.conditions
    slower = replace(first, options={"time_limit": 100.0})
    changed = [
        replace(suite, seed=suite.seed + 1),
        replace(suite, conditions=(slower, *others)),
        replace(suite, conditions=tuple(others)),
        suite.with_task("push"),
    ]
    assert len({one.digest() for one in (suite, *changed)}) == 5
    assert suite.first(10).digest() == suite.digest()


def test_suites_that_carry_a_comparison_hold_two_thousand_episodes():
    assert {suite.episodes for suite in SUITES.values() if suite.name != "quick-v2"} == {2000}


def test_suites_have_seeds_of_their_own_all_for_test():
    for one, other in combinations(SUITES.values(), 2):
        assert not set(one.seeds) & set(other.seeds)
    for suite in SUITES.values():
        seeds.check(suite.seeds, "test")


@pytest.mark.parametrize("name", SUITES)
def test_a_disturbed_condition_has_the_initial_states_of_its_control(name):
    suite = SUITES[name]
    conditions = {condition.name: condition for condition in suite.conditions}
    assert len(conditions) == len(suite.conditions)
    for condition in suite.conditions:
        if (
            condition.control is None
            or condition.params.vessel.length != conditions[condition.control].params.vessel.length
        ):
            continue
        for seed in suite.seeds[:3]:
            here, there = (
                initial_state(condition, seed),
                initial_state(conditions[condition.control], seed),
            )
            np.testing.assert_array_equal(here.motion, there.motion)
            np.testing.assert_array_equal(here.goal, there.goal)


def test_episodes_of_a_suite_differ():
    condition = SUITES["plane-v2"].conditions[0]
    goals = [initial_state(condition, seed).goal for seed in SUITES["plane-v2"].seeds[:50]]
    assert len({tuple(goal) for goal in goals}) == 50


def test_the_paper_suite_has_the_papers_goal_and_others_and_its_time():
    tasks = {one.name: one.params.task for one in SUITES["paper-v2"].conditions}
    goals = {name: task.goal for name, task in tasks.items()}
    assert goals == {
        **dict.fromkeys(("nominal", "noisy", "holding"), PAPER_GOAL),
        **dict.fromkeys(("plane", "plane-noisy")),
    }
    assert {tasks[name].goal_anchor for name, goal in goals.items() if goal} == {"closure"}
    assert {name for name, task in tasks.items() if task.delivery == "passing"} == {
        "nominal",
        "noisy",
    }
    assert {task.time_limit for task in tasks.values()} == {600.0}


def test_shapes_but_the_barge_have_one_area_and_mass():
    for condition in SUITES["shape-v2"].conditions:
        vessel = condition.params.vessel
        if condition.name == "barge":
            continue
        assert polygons.area(vessel.corners) == pytest.approx(0.06)
        assert vessel.mass == pytest.approx(0.6)


def test_seeds_are_for_one_purpose():
    assert [r.start for r in seeds.RANGES.values()] == [0, 10**8, 10**9]
    for one, other in pairwise(seeds.RANGES.values()):
        assert one.stop <= other.start
    assert seeds.purpose(9_999_999) == "test"
    assert seeds.purpose(10_000_000) is None
    assert seeds.purpose(10**8) == "development"
    assert seeds.purpose(10**9) == "training"


@pytest.mark.parametrize(
    ("wanted", "used"),
    [("training", range(0, 5)), ("training", range(10**9 - 1, 10**9 + 5)),
     ("development", range(10**8, 10**9 + 1)), ("test", range(9_999_999, 10**7 + 1))],
)  # fmt: skip
def test_seeds_for_something_else_are_refused(wanted, used):
    with pytest.raises(ValueError, match=f"is not for {wanted}: use seeds from"):
        seeds.check(used, wanted)
    seeds.check(range(seeds.RANGES[wanted].start, seeds.RANGES[wanted].start + 5), wanted)


@pytest.mark.parametrize("name", ["scenario", "task", "preset", "num_boats"])
def test_an_option_that_is_a_field_of_a_condition_is_refused(name):
    with pytest.raises(ValueError, match=f"give the field {name}="):
        Condition("own", options={name: "noisy"})
