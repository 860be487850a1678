"""The time that no team can beat."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from asv_env import make_params
from asv_env.tasks import starts
from baselines.evaluate import bound
from baselines.rollout.runner import run
from baselines.scripted.scripted_policy import ScriptedPolicy

PARAMS = make_params("transport")


def test_top_speeds_are_those_at_which_drag_takes_all_thrust():
    vessel, boat = PARAMS.hulls()
    alone = bound.boat_speed(PARAMS)
    assert (boat.surge[0] + boat.surge[1] * alone) * alone == pytest.approx(2 * boat.thrust)
    together = bound.vessel_speed(PARAMS)
    drag = vessel.sway[0] + vessel.sway[1] * together
    drag += 4 * (boat.surge[0] + boat.surge[1] * together)
    assert drag * together == pytest.approx(8 * boat.thrust)


@given(peak=st.floats(0.02, 0.12))
def test_a_push_with_drag_from_the_start_is_slower_by_a_little(peak):
    """Integrates a push up to a speed, and the coasting from it."""
    vessel, boat = PARAMS.hulls()
    slow = bound.slow_speed(PARAMS)

    def moves(mass, force, boats):
        linear, quadratic = np.array(vessel.sway) + boats * np.array(boat.surge)
        return lambda _, x: [x[1], (force - (linear + quadratic * x[1]) * x[1]) / mass]

    def reaches(speed):
        event = lambda _, x: x[1] - speed  # noqa: E731
        event.terminal = True
        return event

    options = {"rtol": 1e-9, "atol": 1e-12}
    pushed = moves(vessel.masses[1] + 4 * boat.masses[0], 8 * boat.thrust, 4)
    push = solve_ivp(pushed, (0, 100), [0, 0], events=reaches(peak), **options)
    free = moves(vessel.masses[1], 0.0, 0)
    coast = solve_ivp(free, (0, 100), push.y[:, -1], events=reaches(slow), **options)
    way, time = coast.y[0, -1], push.t[-1] + coast.t[-1]
    least = bound.push_time(PARAMS, np.array(way + PARAMS.task.position_tolerance))
    assert 0.6 * time < least < time


def test_nobody_is_faster():
    seeds = range(10**8, 10**8 + 4)
    for log in run(ScriptedPolicy, PARAMS, seeds, 4):
        start = starts.sample(PARAMS, np.random.default_rng(log.episode.seed))
        assert log.episode.duration > bound.least_time(PARAMS, start)
