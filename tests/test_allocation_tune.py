"""The command that tunes the policy ``allocation``, and the gains that it writes."""

import json
from collections import namedtuple
from dataclasses import fields

import numpy as np
import pytest

from asv_env import make_params
from baselines.allocation import allocation_gains, tune
from baselines.allocation.allocation_gains import FOUND, AllocationGains, ManoeuvreGains

FEW = ["--generations", "1", "--population", "3", "--elite", "2", "--episodes", "1"]
FEW += ["--checked", "2"]
Run = namedtuple("Run", "success")
KINDS = {"team": AllocationGains, "pair": ManoeuvreGains}


def test_gains_that_are_searched_are_those_of_the_committed_result():
    written = json.loads(allocation_gains.FILE.read_text(encoding="utf-8"))
    for part, kind in KINDS.items():
        own = {field.name: field.default for field in fields(kind)}
        assert written["gains"][part].items() <= own.items()
        one = written["parts"][part]
        if one["taken"]:
            assert one["found"] == written["gains"][part]
        assert one["taken"] == (one["gain"] > tune.SIGNIFICANT * one["standard error"])


def test_a_candidate_s_gains_are_used():
    values = {part: {name: 1.25 * gain for name, gain in FOUND[part].items()} for part in FOUND}
    policy = tune.policy(make_params("push", 2), values)
    assert values["team"].items() <= vars(policy._gains).items()
    assert values["pair"].items() <= vars(policy._pair_gains).items()


def test_the_search_resumes_and_takes_only_values_that_are_better(tmp_path, monkeypatch):
    make, result = tune.make_params, tmp_path / "tuned.json"
    monkeypatch.setattr(tune, "WORLDS", {"team": ((4, "noisy"),), "pair": ((2, "noisy"),)})
    monkeypatch.setattr(tune, "make_params", lambda *a: make(*a, time_limit=2.0))
    arguments = [*FEW, "--out", str(tmp_path), "--result", str(result)]
    tune.main(arguments)
    first = json.loads(result.read_text())
    assert first["gains"] == FOUND  # In two seconds nothing is delivered.
    assert all(first["parts"][part]["found"] != FOUND[part] for part in FOUND)
    kept = (tmp_path / tune.LOG).read_text()
    assert len(kept.splitlines()) == 2 * 3
    compared = {"gain": 0.1, "standard error": 0.1}
    monkeypatch.setattr(tune, "compared", lambda *a: compared)
    monkeypatch.setattr(tune, "episodes", lambda *a: pytest.fail("a score was computed again"))
    tune.main(arguments)
    assert (tmp_path / tune.LOG).read_text() == kept
    assert json.loads(result.read_text())["gains"] == FOUND
    compared["gain"] = 0.3
    monkeypatch.setattr(tune, "scored", lambda *a: 0.0)
    tune.main(arguments)
    better = json.loads(result.read_text())
    assert all(
        better["gains"][part] == better["parts"][part]["found"] != FOUND[part] for part in FOUND
    )


def test_two_sets_of_gains_are_compared_episode_by_episode(monkeypatch):
    rows = {"old": [0.2, 0.4, 0.6], "new": [0.2, 0.5, 0.8]}
    monkeypatch.setattr(tune, "WORLDS", {"team": ((4, "noisy"),)})
    runs = {name: [Run(each) for each in scores] for name, scores in rows.items()}
    monkeypatch.setattr(tune, "episodes", lambda values, *_: runs[values])
    monkeypatch.setattr(tune, "scores", lambda run, _: np.array([row.success for row in run]))
    found = tune.compared("old", "new", "team", range(3))
    assert found["gain"] == pytest.approx(0.1)
    assert found["standard error"] == pytest.approx(0.1 / np.sqrt(3))
    assert found["score"] == pytest.approx({"before": 0.4, "after": 0.5})


def test_seeds_of_the_search_are_development_seeds():
    with pytest.raises(SystemExit):
        tune.main(["--seed", "0"])
