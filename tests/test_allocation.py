"""How the force and the moment on the vessel are allocated to boats that can only push."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.tasks.formation import slots
from baselines.scripted import PathGains, PushGains
from baselines.scripted.push_controller import allocate

TEAMS = st.sampled_from([2, 3, 4, 5, 8, 20])


def full_drag(params):
    """Drag of the vessel at the speed of the push, N."""
    linear, quadratic = params.hulls()[0].sway
    return (linear + quadratic * PathGains().speed) * PathGains().speed


def allocated(params, ahead, moment):
    """Forces (A,) of boats in their slots, the moment that results, positions, and end boats."""
    slot, drag, gains = slots(params, params.num_boats), full_drag(params), PushGains()
    caging = np.abs(slot.real) > params.vessel.length / 2
    reserve, contact = gains.moment_reserve * drag, gains.contact_force * drag
    asked = np.array([ahead]), np.array([moment]), slot.real[None], ~caging[None]
    forces, result = allocate(*asked, reserve, contact)
    return forces[0], result[0], slot.real, caging


@given(TEAMS, st.floats(0.0, 2.0), st.floats(-3.0, 3.0))
def test_boats_can_only_push(team, ahead, moment):
    """Force in units of the drag at full speed; moment, of that at a quarter of the length."""
    params = make_params("push", team)
    force = full_drag(params)
    forces, result, u, caging = allocated(
        params, ahead * force, moment * force * params.vessel.length / 4
    )
    assert (forces[~caging] > 0).all()
    np.testing.assert_array_equal(forces[caging], 0.0)
    assert forces.sum() >= ahead * force * (1 - 1e-12)
    np.testing.assert_allclose(result, -(forces * u)[~caging].sum(), atol=1e-15)


@given(TEAMS, st.floats(0.3, 2.0), st.floats(-0.5, 0.5))
def test_a_small_wrench_is_exerted_as_wanted(team, ahead, moment):
    params = make_params("push", team)
    ahead = ahead * full_drag(params)
    _, _, u, caging = allocated(params, ahead, 0.0)
    u, pushers = u[~caging], (~caging).sum()
    moment = moment * ahead * (u**2).sum() / pushers / np.abs(u).max()
    forces, result, _, _ = allocated(params, ahead, moment)
    assert forces.sum() == pytest.approx(ahead)
    assert result == pytest.approx(moment, abs=1e-15)


@given(TEAMS, st.floats(0.0, 1.0), st.floats(1.0, 1e3))
def test_no_moment_is_too_large_to_ask(team, ahead, moment):
    """The moment saturates at the largest one that is possible."""
    params = make_params("push", team)
    ahead = ahead * full_drag(params)
    most = allocated(params, ahead, 1e6)
    forces, result, u, caging = allocated(params, ahead, moment)
    np.testing.assert_allclose(forces, most[0])
    assert 0 < result <= forces.sum() * np.abs(u[~caging]).max()
    assert forces.sum() < 3 * full_drag(params)


@given(TEAMS, st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_mirrored_wrench_is_shared_by_the_mirrored_boats(team, ahead, moment):
    params = make_params("push", team)
    force = full_drag(params)
    asked = ahead * force, moment * force * params.vessel.length / 4
    forces, result, _, _ = allocated(params, *asked)
    image, mirrored, _, _ = allocated(params, asked[0], -asked[1])
    np.testing.assert_allclose(image, forces[::-1], atol=1e-15)
    assert mirrored == pytest.approx(-result, abs=1e-15)


@given(TEAMS, st.floats(0.01, 2.0))
def test_a_vessel_that_is_too_fast_is_left_alone(team, surplus):
    params = make_params("push", team)
    forces, _, _, caging = allocated(params, -surplus * full_drag(params), 0.0)
    assert (forces[~caging] < 0).all()
