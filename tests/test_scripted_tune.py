"""The command that tunes the scripted policy, and the gains that it writes."""

import json
from dataclasses import asdict, fields, replace

import pytest

from asv_env import make_params
from baselines.scripted import gains, tune
from baselines.scripted.gains import GraspGains, PathGains, PushGains, Tolerances

KINDS = GraspGains, PushGains, PathGains, Tolerances
FEW = ["--generations", "1", "--population", "3", "--elite", "2", "--episodes", "1"]
FEW += ["--checked", "1", "--workers", "1"]


def test_every_gain_that_was_searched_is_one_and_is_used():
    known = {f.name: f.default for kind in KINDS for f in fields(kind)}
    assert gains.FOUND.items() <= known.items()
    searched = {f.name for kinds in tune.STAGES.values() for kind in kinds for f in fields(kind)}
    assert gains.FOUND.keys() <= searched


def test_a_candidate_s_gains_are_used():
    params = make_params("push")
    values = {name: 1.25 * value for name, value in gains.FOUND.items()}
    found = {}
    for kind in KINDS:
        found.update(asdict(tune.changed(kind(), values)))
    assert values.items() <= found.items()
    policy = tune.policy(params, values)
    assert policy._push._gains == tune.changed(PushGains(), values)
    assert policy._grasp._gains == tune.changed(GraspGains(), values)


def test_faster_and_more_exact_successes_score_more():
    params = make_params("push")
    (row,) = tune.episodes(gains.FOUND, "push", "nominal", range(10**8, 10**8 + 1))
    assert row.success
    best = tune.score([row], params)
    assert best > 1
    assert tune.score([replace(row, duration=row.duration + 10)], params) < best
    assert tune.score([replace(row, position_error=0.05)], params) < best
    assert tune.score([replace(row, success=False)], params) == 0
    assert tune.score([row, replace(row, success=False)], params) == pytest.approx(best / 2)


class Here:
    """Runs jobs in this process."""

    def __init__(self, *_):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    map = staticmethod(map)


def test_the_search_writes_gains_and_resumes(tmp_path, monkeypatch):
    make = tune.make_params
    monkeypatch.setattr(tune, "ProcessPoolExecutor", Here)
    monkeypatch.setattr(tune, "SCENARIOS", {"noisy": 4})
    monkeypatch.setattr(tune, "make_params", lambda *a, **k: make(*a, **{"time_limit": 2.0, **k}))
    result = tmp_path / "tuned.json"
    arguments = [*FEW, "--out", str(tmp_path), "--result", str(result)]
    tune.main(arguments)
    first = json.loads(result.read_text())
    assert first["gains"].keys() == gains.FOUND.keys()
    assert first["gains"] != gains.FOUND
    assert first["delivered"].keys() == {"before", "after"}
    kept = (tmp_path / tune.LOG).read_text()
    assert len(kept.splitlines()) == 2 * 3
    monkeypatch.setattr(tune, "check", lambda *a: {})
    monkeypatch.setattr(tune, "episodes", lambda *a: pytest.fail("a score was computed again"))
    tune.main(arguments)
    assert (tmp_path / tune.LOG).read_text() == kept
    assert json.loads(result.read_text())["gains"] == first["gains"]


def test_seeds_of_the_search_are_development_seeds():
    with pytest.raises(SystemExit):
        tune.main(["--seed", "0"])
