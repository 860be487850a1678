"""When boats arrive: points that obey the laws alone, and the words of the caption."""

import numpy as np
import pytest

from baselines.paper.paper_numbers import ARRIVAL_TIME
from baselines.reproduce import fig6_arrival
from baselines.reproduce.paper_environments import simulation

PARAMS = simulation("approach")
GOAL_TIME = ARRIVAL_TIME["thrusters"]


def test_a_point_above_its_target_that_faces_it_needs_the_length_over_the_time():
    offset, heading = np.array([1.0j]), np.array([-np.pi / 2])
    (speed,) = fig6_arrival.first_speeds(offset, heading, PARAMS)
    assert speed == pytest.approx((1.0 - PARAMS.task.slot_distance) / GOAL_TIME)
    (time,) = fig6_arrival.point_arrivals(offset, heading, PARAMS)
    assert GOAL_TIME - 0.1 <= time <= GOAL_TIME + 2.0


def test_points_all_round_arrive_together_and_not_before_the_time():
    angle = np.linspace(-3.0, 3.0, 24)
    offset = np.linspace(0.5, 1.5, 24) * np.exp(1j * angle)
    times = fig6_arrival.point_arrivals(offset, angle, PARAMS)
    assert min(times) > GOAL_TIME - 0.5
    assert max(times) < 1.4 * GOAL_TIME
    assert np.ptp(times) < 0.2 * GOAL_TIME


def test_the_caption_says_the_numbers():
    study = {
        "T_goal": 30.0, "asked": [0.02, 0.05, 0.13], "cap": 0.04, "points": [34.0, 35.0, 36.0],
        "trials": 12, "capped": [70.0, 90.0], "uncapped": [],
    }  # fmt: skip
    text = fig6_arrival.in_words({}, study)
    for phrase in ("after 35.0 s", "5.0 cm/s", "13.0 cm/s", "cap of 4 cm/s", "2 of 12 trials"):
        assert phrase in text
    assert "(median 80 s)" in text
    assert "0 of 12 trials, within" in text
