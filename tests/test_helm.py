"""Steering through an autopilot: turns that end in time, set-points that are reached in a tick."""

import numpy as np
import pytest
from helpers import begin_at, bodies
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from baselines.scripted.helm import Helm

PARAMS = make_params("push", 2, goal=(1.0, 1.0, 0.0))
HELM = Helm(PARAMS)
ALONE = (2.0, 2.0), (-2.0, -2.0)


@given(st.floats(-np.pi, np.pi), st.floats(0.0, 1.0))
def test_larger_angles_ask_for_faster_turns_the_same_both_ways(angle, factor):
    rate = HELM.turn(np.array([angle, factor * angle, -angle]))
    assert abs(rate[1]) <= abs(rate[0]) + 1e-12
    assert rate[2] == -rate[0]


def test_the_law_of_turns_has_no_jump():
    angles = np.linspace(-np.pi, np.pi, 20_001)
    rate = HELM.turn(angles)
    assert np.abs(np.diff(rate)).max() < 5 * np.diff(angles)[0]


def turned(start, seconds=12.0):
    """Headings (T,) of a boat alone that is to point to 0."""
    simulation = Simulation(PARAMS)
    begin_at(simulation, [bodies((), (*ALONE[0], start), ALONE[1])])
    reference, found = np.zeros((1, 2, 2)), []
    for _ in range(round(10 * seconds)):
        heading = simulation.state.motion[0, 1, 2]
        wanted = np.zeros((1, 2, 2))
        wanted[0, 0, 1] = HELM.turn(np.array([-heading]))[0]
        action, reference = HELM.set_points(wanted, reference)
        simulation.step(action)
        found.append(heading)
    return np.array(found)


@pytest.mark.parametrize("start", [0.1, 0.5, 1.5, 3.0])
def test_a_boat_turns_to_its_heading_and_hardly_beyond(start):
    headings = turned(start)
    assert np.abs(headings[-20:]).max() < 0.01
    assert headings.min() > -0.05


@settings(max_examples=10)
@given(
    st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.7, 0.7)), min_size=1, max_size=8),
)
def test_references_are_those_of_the_autopilots(path):
    simulation = Simulation(PARAMS)
    begin_at(simulation, [bodies((), *ALONE)])
    reference = np.zeros((1, 2, 2))
    for speed, yaw_rate in path:
        wanted = np.broadcast_to([speed, yaw_rate], (1, 2, 2))
        action, reference = HELM.set_points(wanted, reference)
        simulation.step(action)
        own = simulation._dynamics.plant.reference
        np.testing.assert_allclose(reference, own, atol=1e-6)


def test_wanted_motions_within_reach_are_reached_in_a_tick():
    action, reference = HELM.set_points(np.array([0.01, 0.05]), np.zeros(2))
    np.testing.assert_allclose(reference, [0.01, 0.05], rtol=1e-9)
    assert (np.abs(action) < 1).all()
    _, late = HELM.set_points(np.array([0.2, 0.7]), np.zeros(2))
    assert late == pytest.approx(np.array(PARAMS.boat.acceleration) / 10)
