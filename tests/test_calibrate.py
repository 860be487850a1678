"""The calibration to the paper's tank: what it varies, measures and writes."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.tasks import starts
from baselines.paper.paper_numbers import PAPER_HEADING, PAPER_POSITION
from baselines.reproduce import calibrate
from baselines.reproduce.calibrate import Disturbances


def test_a_bias_makes_right_motors_stronger_and_left_ones_weaker():
    params = make_params(variation={"thrust_bias": 0.2})
    gain = starts.sample(params, np.random.default_rng(0)).thrust_gain
    np.testing.assert_allclose(gain, [[0.8, 1.2]] * 4)
    varied = make_params(variation={"thrust_bias": -0.5, "thrust": 0.1})
    gains = [starts.sample(varied, np.random.default_rng(s)).thrust_gain for s in range(200)]
    left, right = np.concatenate(gains).T
    assert 1.35 <= left.min() < left.max() <= 1.65
    assert 0.45 <= right.min() < right.max() <= 0.55
    assert varied.variation.largest_thrust == pytest.approx(1.65)


def test_boats_with_a_bias_turn_to_the_left():
    turned = []
    for bias in (-0.2, 0.0, 0.2):
        params = make_params(action_mode="thrusters", variation={"thrust_bias": bias})
        simulation = Simulation(params)
        simulation.reset(seeds=[0])
        before = simulation.state.motion[0, 1:, 2].copy()
        for _ in range(5):
            simulation.step(np.full((1, 4, 2), 0.5))
        after = simulation.state.motion[0, 1:, 2]
        turned.append(np.angle(np.exp(1j * (after - before))))
    right, straight, left = turned
    assert (right < -0.01).all()
    np.testing.assert_allclose(straight, 0.0, atol=1e-9)
    assert (left > 0.01).all()


@pytest.mark.parametrize("bias", [-1.0, 1.0, np.nan])
def test_a_bias_that_stops_motors_is_refused(bias):
    with pytest.raises(ValueError, match="thrust_bias"):
        make_params(variation={"thrust_bias": bias})


def test_disturbances_stay_within_their_bounds():
    found = Disturbances.of_vector(np.array([-0.2, 1.4, -0.9, -3.2, 99.0]))
    assert found == Disturbances(0.0, 0.9, -0.5, 0, calibrate.MOST_TICKS)
    assert Disturbances.of_vector(np.array([0.123, 0.2, 0.046, 1.6, 0.4])) == Disturbances(
        0.12, 0.2, 0.05, 2, 0
    )


def test_no_disturbance_is_the_experiment_and_all_are_parameters_of_it():
    assert make_params(preset="experiment", **Disturbances().overrides()) == make_params(
        preset="experiment"
    )
    params = make_params(preset="experiment", **Disturbances(0.5, 0.2, 0.1, 2, 3).overrides())
    assert params.sensors.position_noise == pytest.approx(0.005)
    assert (params.sensors.latency, params.variation.actuation_latency) == (2, 3)
    assert (params.variation.thrust, params.variation.thrust_bias) == (0.2, 0.1)


def row(distance, heading, closure=80.0):
    return {
        "min_position_error": distance,
        "heading_error_at_min": heading,
        "time_to_closure": closure,
    }


def test_trials_that_never_came_in_range_do_not_count():
    rows = [row(0.02, 0.1), row(0.04, -0.3), row(0.5, 3.0), row(0.01, 0.0, None)]
    found = calibrate.moments(rows)
    assert (found["trials"], found["in range"]) == (4, 2)
    assert found["distance"]["mean"] == pytest.approx(3.0)
    assert found["heading"]["mean"] == pytest.approx(-0.1)
    assert calibrate.misfit(found) < calibrate.UNFIT
    assert calibrate.misfit(calibrate.moments(rows + rows[2:])) == calibrate.UNFIT


def test_the_misfit_of_samples_of_the_truth_is_its_number_of_moments():
    """Four squared deviations of unit variance each; those of normal samples of twelve."""
    rng = np.random.default_rng(4)
    misfits = []
    for _ in range(2000):
        distance = rng.normal(*PAPER_POSITION, 12)
        heading = rng.normal(*PAPER_HEADING, 12)
        found = {"trials": 12, "in range": 12}
        for name, values in (("distance", distance), ("heading", heading)):
            found[name] = {"mean": values.mean(), "sd": values.std(ddof=1)}
        misfits.append(calibrate.misfit(found))
    assert np.mean(misfits) == pytest.approx(4.0, abs=0.3)


def test_each_disturbance_is_tried_alone_and_left_out():
    made = calibrate.variants(Disturbances(0.5, 0.2, 0.0, 1, 0))
    assert list(made)[:2] == ["undisturbed", "fitted"]
    assert made["noise alone"] == Disturbances(noise=0.5)
    assert made["without sensing latency"] == Disturbances(0.5, 0.2)
    assert len(made) == 2 + 2 * 3


def test_the_command_finds_what_the_trials_have(tmp_path, monkeypatch):
    """Trials whose errors grow with the noise and the mismatch: both are found again."""

    def made_up(one, wanted, what):
        rng = np.random.default_rng(wanted[0])
        distance, heading = rng.standard_normal((2, len(wanted)))
        distance = PAPER_POSITION[0] * one.noise / 0.8 + PAPER_POSITION[1] * distance
        heading = PAPER_HEADING[0] * one.mismatch / 0.4 + PAPER_HEADING[1] * heading
        return [row(abs(d) / 100, h) for d, h in zip(distance, heading, strict=True)]

    monkeypatch.setattr(calibrate, "trials", made_up)
    page = tmp_path / "page.md"
    start, end = calibrate.paper_page.borders(calibrate.NAME)
    page.write_text(f"{start}\n{end}\n")
    arguments = ["--out", str(tmp_path), "--page", str(page), "--trials", "400"]
    calibrate.main([*arguments, "--generations", "8", "--population", "30", "--elite", "8"])
    made = json.loads((tmp_path / "calibration.json").read_text())
    assert made["fitted"]["noise"] == pytest.approx(0.8, abs=0.1)
    assert made["fitted"]["mismatch"] == pytest.approx(0.4, abs=0.15)
    assert made["calibrated"] == Disturbances(**made["fitted"]).overrides()
    assert set(made["fitted"]) == set(asdict(Disturbances()))
    assert "tank experiment (paper)" in page.read_text()
    assert (tmp_path / "calibration.md").read_text().strip() in page.read_text()
