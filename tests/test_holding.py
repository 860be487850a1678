"""How boats hold a vessel in moving water, and when they had better go round."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.tasks.formation import relate
from baselines.scripted import PathGains, PushGains
from baselines.scripted.holding import Holding

TIDE = 0.01  #: speed of the water, m/s


def holding(params):
    return Holding(params, PushGains(), PathGains().still_water)


def at_its_goal(params):
    """Relations of a grasped vessel that lies at its goal, heading along +x."""
    simulation = Simulation(params)
    simulation.reset(seeds=[0])
    state = simulation.state
    return relate(state.motion, state.motion[:, 0, :3], state.slot, state.side)


@pytest.fixture(scope="module")
def params():
    return make_params("push", 4, goal=(0.0, 0.0, 0.0), delivery="holding")


def test_it_takes_a_boat_at_either_end_to_brake(params):
    end = np.array([[-1.0, 0.0, 0.0, 1.0]] * 3)
    working = np.ones((3, 4), dtype=bool)
    working[1, 0] = working[2, 1] = False
    brakes = holding(params).brake(working, end)
    assert brakes[0] > 0
    assert brakes[1] == 0
    assert brakes[2] == brakes[0]


@given(st.floats(-np.pi, np.pi), st.floats(0.0, 0.01))
def test_a_vessel_is_lost_from_one_side_at_most(params, direction, brake):
    relations, drift = at_its_goal(params), TIDE * np.exp(1j * np.array([direction]))
    here, there = holding(params).loses(relations, drift, np.array([brake]))
    assert not (here & there)[0]
    turned, back = holding(params).loses(relations, -drift, np.array([brake]))
    assert (here, there) == (back, turned)


def test_water_from_behind_the_boats_carries_the_vessel_off(params):
    """The team pushes it towards -y; water that meets it presses it on the boats."""
    relations, none = at_its_goal(params), np.zeros(1)
    for y, lost in ((-TIDE, True), (TIDE, False), (-0.1 * PathGains().still_water, False)):
        here, _ = holding(params).loses(relations, np.array([1j * y]), none)
        assert here[0] == lost
    passing = make_params("push", 4, goal=(0.0, 0.0, 0.0), delivery="passing")
    assert not holding(passing).loses(relations, np.array([-1j * TIDE]), none)[0][0]
