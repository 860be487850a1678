"""The comparison from Python: ``baselines.evaluate.compare``."""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest

from asv_env import make_params
from asv_env.tasks import PUSH, Term
from baselines.evaluate import compare
from baselines.evaluate.api import InputError
from baselines.evaluate.conditions import Condition
from baselines.evaluate.suites import SUITES
from baselines.policy import POLICIES, Idle

SHORT = Condition("short", task="push", options={"time_limit": 1.0})
QUIET = {"workers": 0, "progress": False}
pytestmark = pytest.mark.usefixtures("no_report")


class Full(Idle):
    """Everything ahead."""

    def __init__(self, params, speed=1.0):
        self._speed = speed

    def act(self, sensed, observation, memory, fresh):
        action, memory = super().act(sensed, observation, memory, fresh)
        return action + np.array([self._speed, 0.0], dtype=np.float32), memory


def turning(now):
    return -abs(now.relations.yaw_rate[:, 0])


STEADY = replace(PUSH, name="steady", reward=(Term("turning", turning),), time_limit=1.0)


def test_a_class_meets_a_registered_policy(tmp_path):
    found = compare({"mine": Full, "idle": "idle"}, SHORT, episodes=2, **QUIET)
    table, episodes = found.table(), found.episodes
    assert table.index.tolist() == [("short", "mine"), ("short", "idle")]
    assert table["episodes"].tolist() == [2, 2]
    assert table.loc[("short", "mine"), "success_low"] == 0.0
    assert table.loc[("short", "mine"), "effort"] == pytest.approx(0.9, abs=0.1)
    assert episodes["policy"].tolist() == ["mine", "mine", "idle", "idle"]
    assert episodes["time_to_goal"].isna().all()
    assert episodes["success"].dtype == bool
    assert found.summary["conditions"]["short"]["comparisons"]["idle"]["success"]["value"] == 0.0
    assert "mine" in str(found)
    assert "<table" in found._repr_html_()


def test_a_suite_by_its_name_with_another_task():
    found = compare({"mine": Full}, "quick-v2", 1, task=STEADY, **QUIET)
    suite = SUITES["quick-v2"]
    assert found.episodes["condition"].tolist() == [one.name for one in suite.conditions]
    assert set(found.episodes["task"]) == {"steady"}
    assert set(found.episodes["seed"]) == {suite.seed}


def test_parameters_and_several_conditions_are_suites_of_ones_own():
    params = make_params("push", 3, scenario="noisy", time_limit=0.5)
    assert compare({"idle": "idle"}, params, 1, **QUIET).episodes["num_boats"].tolist() == [3]
    murky = Condition("murky", "", "short", "push", {"sensors": {"position_noise": 0.03}})
    found = compare({"idle": "idle"}, [SHORT, replace(murky, options=SHORT.options)], 1, **QUIET)
    assert found.episodes["scenario"].tolist() == ["nominal", "custom"]
    assert found.summary["conditions"]["murky"]["against_control"]["idle"]["with"] == "short"


def test_trainings_of_one_policy():
    found = compare({"mine": [partial(Full, speed=s) for s in (0.5, 1.0)]}, SHORT, 2, **QUIET)
    assert found.table()["trainings"].tolist() == [2]
    assert found.episodes["training_seed"].tolist() == [0, 0, 1, 1]


def test_a_folder_is_continued_and_keeps_policies_apart(tmp_path, monkeypatch):
    first = compare({"mine": Full}, SHORT, 2, tmp_path, **QUIET)
    more = compare({"mine": Full, "idle": "idle"}, SHORT, 3, tmp_path, **QUIET)
    pd.testing.assert_frame_equal(first.episodes, more.episodes.head(2))
    monkeypatch.setattr("baselines.rollout.runner.run", lambda *arguments: pytest.fail("run again"))
    again = compare({"mine": Full, "idle": "idle"}, SHORT, 3, tmp_path, **QUIET)
    pd.testing.assert_frame_equal(again.episodes, more.episodes)
    with pytest.raises(InputError, match="another policy mine"):
        compare({"mine": partial(Full, speed=0.5)}, SHORT, 3, tmp_path, **QUIET)


def test_another_definition_of_a_task_is_noticed(tmp_path):
    own = replace(SHORT, task=STEADY, options={})
    compare({"idle": "idle"}, own, 1, tmp_path, **QUIET)
    other = replace(STEADY, reward=(Term("other", lambda now: -turning(now)),))
    with pytest.raises(InputError, match="another definition of the task"):
        compare({"idle": "idle"}, replace(own, task=other), 1, tmp_path, **QUIET)


def test_a_registered_policy_of_ones_own(monkeypatch):
    monkeypatch.setattr(POLICIES, "_entries", dict(POLICIES._entries))
    POLICIES.register("full", Full)
    found = compare({"mine": "full"}, SHORT, 1, **QUIET)
    assert found.request.fingerprints["mine"] != ["full"]


def test_charts_are_drawn():
    found = compare({"mine": Full, "idle": "idle"}, SHORT, 2, **QUIET)
    for chart in ("overview", "profile", "errors"):
        assert found.plot(chart).axes
    with pytest.raises(ValueError, match="Did you mean 'profile'"):
        found.plot("profil")
    with pytest.raises(ValueError, match="unknown condition 'long'"):
        found.plot("profile", "long")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"policies": {}}, "give at least one"),
        ({"policies": Full}, "by name"),
        ({"policies": {"mine": 3}}, "not a policy"),
        ({"policies": {"a/b": Full}}, "cannot be a name"),
        ({"policies": {"mine": ["idle", "random"]}}, "need a name each"),
        ({"policies": {"mine": "scriptd"}}, "Did you mean 'scripted'"),
        ({"policies": {"mine": lambda params: None}}, "no method act"),
        ({"suite": "plane-v9"}, "Did you mean 'plane-v2'"),
        ({"suite": "plane-v2", "episodes": 2001}, "episodes=2001: plane-v2 has 2000"),
        ({"suite": []}, "give a name, a Suite"),
        ({"suite": [SHORT, SHORT]}, "a name of its own"),
        ({"task": "transprt"}, "Did you mean 'transport'"),
        ({"suite": make_params(), "task": "push"}, "has its own task"),
        ({"episodes": 0}, "episodes=0"),
        ({"workers": -1}, "workers=-1"),
        ({"num_envs": 1.5}, "num_envs=1.5"),
        ({"record": True}, "need a folder"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        compare(**{"policies": {"mine": Full}, "suite": SHORT, **QUIET, **arguments})
