"""The tuned paper's controller, and the command that tunes it."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.types import copied
from baselines.paper import tune, tuned
from baselines.paper.arc_following import two_arcs
from baselines.paper.paper_numbers import GAINS, PaperGains
from baselines.paper.paper_policy import PaperPolicy, longest_path
from baselines.policy import POLICIES
from baselines.rollout import runner

FEW = ["--generations", "1", "--population", "3", "--elite", "2", "--episodes", "2"]


def test_the_first_turn_is_that_of_the_shortest_legal_path_of_every_goal():
    params = make_params("push")
    goals = [(0.5, -0.9, 0.4), (-0.7, 0.5, 2.0), (0.2, -0.6, 0.0), (1.0, 0.1, -1.5)]
    gains = tuned.tuned_gains()
    assert gains.alpha1 is None
    simulation = Simulation(params, len(goals))
    simulation.reset(seeds=range(len(goals)))
    sensed = copied(simulation.sensed)
    sensed.goal[:] = goals
    policy = POLICIES["paper-tuned"](params)
    _, memory = policy.act(sensed, np.empty(0), None, np.ones(len(goals), dtype=bool))
    half_length = params.vessel.length / 2
    longest = longest_path(params, gains, params.task.time_limit)
    path = two_arcs(np.array(goals), half_length, longest, gains)
    np.testing.assert_allclose(memory.length, path.length, atol=1e-6)
    assert np.abs(memory.rho).min() >= half_length * (1 - 1e-6)
    assert path.total_length.max() <= longest


@pytest.mark.parametrize("delivery", ["holding", "passing"])
@pytest.mark.parametrize("policy", ["paper", "paper-tuned"])
def test_both_policies_run_by_either_criterion(policy, delivery):
    params = make_params("push", time_limit=3.0, delivery=delivery)
    (log,) = runner.run(POLICIES[policy], params, [0], 1)
    assert log.episode.error is None


def test_the_search_writes_gains_and_resumes(tmp_path, monkeypatch):
    monkeypatch.setattr(tune, "TIME_LIMIT", 2.0)
    result = tmp_path / "tuned.json"
    arguments = [*FEW, "--checked", "1", "--out", str(tmp_path), "--result", str(result)]
    shorter = {"time_limit": 2.0}
    make = tune.make_params
    monkeypatch.setattr(tune, "make_params", lambda *a, **k: make(*a, **{**shorter, **k}))
    tune.main(arguments)
    first = json.loads(result.read_text())
    gains = PaperGains(**first["gains"])
    searched = {name for stage in tune.STAGES for name in stage.names}
    fixed = {name for name in asdict(gains) if name not in searched}
    assert fixed == {"alpha1"}
    assert gains != replace(tune.START)
    again = tmp_path / "again.json"
    other = ["--only", "approach", "--start", str(result), "--seed", "200000000"]
    tune.main([*FEW, *other, "--checked", "1", "--out", str(tmp_path), "--result", str(again)])
    second = json.loads(again.read_text())
    assert second["gains"]["push_speed"] == first["gains"]["push_speed"]
    assert second["gains"]["max_speed"] != first["gains"]["max_speed"]
    assert [search["only"] for search in second["searches"]] == [["push", "approach"], ["approach"]]
    kept = (tmp_path / tune.LOG).read_text()
    monkeypatch.setattr(tune.runner, "run", lambda *a: pytest.fail("a score was computed again"))
    monkeypatch.setattr(tune, "check", lambda *a: {})
    tune.main(arguments)
    assert (tmp_path / tune.LOG).read_text() == kept
    assert json.loads(result.read_text())["gains"] == first["gains"]


def test_integral_action_makes_up_for_the_drag_of_the_vessel():
    """Proportionally controlled boats push it more slowly than they are asked to."""
    params = make_params("push", goal=(0.0, -2.0, 0.0), time_limit=60.0)
    speeds = {}
    for integral in (0.0, 0.3):
        gains = PaperGains(alpha1=None, push_speed=0.04, speed_integral=integral)
        simulation = Simulation(params)
        observation = simulation.reset(seeds=[0])
        policy, memory = PaperPolicy(params, gains), None
        for tick in range(300):
            fresh = np.array([tick == 0])
            action, memory = policy.act(simulation.sensed, observation, memory, fresh)
            observation = simulation.step(action).observation
        speeds[integral] = -simulation.state.motion[0, 0, 4]
    assert speeds[0.0] < 0.036
    assert speeds[0.3] == pytest.approx(0.04, abs=0.001)


def test_seeds_that_are_not_for_development_are_refused(tmp_path):
    with pytest.raises(SystemExit, match="not for development"):
        tune.main(["--seed", "0", "--out", str(tmp_path), "--result", str(tmp_path / "t.json")])


def test_scores_against_a_case_worked_by_hand():
    params = make_params("push", time_limit=100.0)
    rows = [log.episode for log in runner.run(POLICIES["idle"], replace_time(params), [0, 1], 2)]
    near = replace(rows[0], success=True, duration=25.0)
    near = replace(near, min_position_error=0.05, heading_error_at_min=0.0)
    far = replace(rows[1], success=False, min_position_error=0.05, heading_error_at_min=-0.1)
    closeness = (1 / 2 + 1 / 3) / 2
    assert tune.push_score([near, far], params) == pytest.approx(0.5 + tune.CLOSENESS * closeness)
    assert tune.approach_score([near, far], params) == pytest.approx(0.75 / 2)


def replace_time(params):
    """The same parameters with a time limit of a moment."""
    return replace(params, task=replace(params.task, time_limit=0.2))


def test_the_paper_as_printed_stays():
    assert (GAINS.alpha1, GAINS.stop_distance, GAINS.switch_distance) == (1.0, 0.2, 0.0)
