"""The calibration to the paper's tank: what it varies, measures and writes."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.presets import CALIBRATED
from asv_env.tasks import starts
from baselines.paper.paper_numbers import PAPER_HEADING, PAPER_POSITION
from baselines.policy import POLICIES
from baselines.reproduce import artefact, calibrate, paper_environments
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


def test_candidates_fill_the_bounds_and_lack_each_disturbance_in_half_the_cases():
    rng = np.random.default_rng(0)
    for name, (low, high) in calibrate.BOUNDS.items():
        values = np.array([getattr(Disturbances.sample(rng), name) for _ in range(2000)])
        assert np.mean(values == 0.0) == pytest.approx(0.5, abs=0.05)
        present = values[values != 0.0]
        edge = 0.5 if name.endswith("latency") else 0.02 * (high - low)
        assert low <= present.min() <= low + edge
        assert high - edge <= present.max() <= high


def test_no_disturbance_is_the_experiment_and_all_are_parameters_of_it():
    assert make_params(preset="experiment", **Disturbances().overrides()) == make_params(
        preset="experiment"
    )
    params = make_params(preset="experiment", **Disturbances(0.5, 0.2, 0.1, 2, 3).overrides())
    assert params.sensors.position_noise == pytest.approx(0.005)
    assert (params.sensors.delay, params.variation.actuation_delay) == (0.2, 0.3)
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
    made = calibrate.variants(Disturbances(0.4, 0.2, 0.0, 1, 0))
    assert list(made)[:2] == ["undisturbed", "fitted"]
    assert made["noise 0.5 alone"] == Disturbances(noise=0.5)
    assert made["actuation latency 3 alone"] == Disturbances(actuation_latency=3)
    assert made["fitted without sensing latency"] == Disturbances(0.4, 0.2)
    assert len(made) == 2 + 3 + sum(map(len, calibrate.SWEEP.values()))


def measured(distance, heading, in_range=30):
    moments = {"distance": distance, "heading": heading}
    found = {name: {"mean": mean, "sd": sd} for name, (mean, sd) in moments.items()}
    return {"trials": 40, "in range": in_range, **found}


def test_the_notes_say_which_disturbances_yield_the_heading_error():
    """Standard errors of twelve trials are 0.52 and 0.38 cm, 0.127 and 0.094 rad."""
    rows = {
        "all": measured((4.9, 1.8), (-0.26, 0.44)),
        "turned alone": measured((2.0, 1.8), (-0.5, 0.6)),
        "too steady": measured((4.9, 1.8), (-0.26, 0.24)),
        "too straight": measured((4.9, 1.8), (0.0, 0.44)),
        "seldom": measured((4.9, 1.8), (-0.26, 0.44), in_range=19),
    }
    *_, last = calibrate.table(Disturbances(), rows)["notes"]
    assert "comes with: all; turned alone. The distance fits as well with: all." in last
    *_, none = calibrate.table(Disturbances(), {"seldom": rows["seldom"]})["notes"]
    assert "comes with: none of them." in none


def test_rounds_have_fewer_candidates_and_as_many_more_trials_on_other_seeds():
    alone = len(calibrate.alone())
    rounds = calibrate.Options(random=50 - alone, trials=10, seed=10**8).rounds
    assert [(number, len(wanted)) for number, wanted in rounds] == [(50, 10), (12, 40), (3, 160)]
    assert [wanted.start - 10**8 for _, wanted in rounds] == [0, 10, 50]


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
    calibrate.main([*arguments, "--random", "300", "--checked", "400"])
    made = json.loads((tmp_path / "calibration.json").read_text())
    assert made["fitted"]["noise"] == pytest.approx(0.8, abs=0.1)
    assert made["fitted"]["mismatch"] == pytest.approx(0.4, abs=0.15)
    assert made["calibrated"] == Disturbances(**made["fitted"]).overrides()
    assert set(made["fitted"]) == set(asdict(Disturbances()))
    assert "tank experiment (paper)" in page.read_text()
    assert (tmp_path / "calibration.md").read_text().strip() in page.read_text()


PUBLISHED = Path(__file__).parents[1] / "docs" / "reproduction"


def test_the_preset_is_the_published_fit():
    result = json.loads((PUBLISHED / "calibration.json").read_text())
    found = Disturbances(**result["fitted"])
    assert result["calibrated"] == found.overrides() == CALIBRATED
    assert make_params(preset="tank-calibrated") == make_params(
        preset="experiment", **found.overrides()
    )
    assert make_params(preset="tank-calibrated") != make_params(preset="experiment")


def test_the_published_table_follows_from_the_published_moments():
    result = json.loads((PUBLISHED / "calibration.json").read_text())
    product = calibrate.table(Disturbances(**result["fitted"]), result["measured"])
    assert product == {name: result[name] for name in product}
    assert (PUBLISHED / "calibration.md").read_text() == artefact.markdown(product)
    assert list(result["measured"]) == list(calibrate.variants(Disturbances(**result["fitted"])))


def test_trials_in_the_calibrated_tank_come_to_closure():
    params = make_params(preset="tank-calibrated")
    rows = paper_environments.episodes(POLICIES["paper"], params, range(10**8, 10**8 + 4), "tank")
    closed = [row for row in rows if row["time_to_closure"] is not None]
    assert len(closed) >= 3
    assert all(row["min_position_error"] < 1.0 for row in closed)
