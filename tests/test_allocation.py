"""How the force and the moment on the vessel are allocated to boats that can only push."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.tasks.formation import slots
from baselines.scripted import PathGains, PushGains
from baselines.scripted.allocation import allocate

TEAMS = st.sampled_from([2, 3, 4, 5, 8, 20])


def full_drag(params):
    """Drag of the vessel at the speed of the push, N."""
    linear, quadratic = params.hulls()[0].sway
    return (linear + quadratic * PathGains().speed) * PathGains().speed


def shared(params, ahead, moment):
    """Forces (A,) of boats in their slots, the moment that results, positions, and end boats."""
    slot, drag, gains = slots(params, params.num_boats), full_drag(params), PushGains()
    caging = np.abs(slot.real) > params.vessel.length / 2
    reserve, contact = gains.moment_reserve * drag, gains.contact_force * drag
    asked = np.array([ahead]), np.array([moment]), slot.real[None], ~caging[None]
    each, comes = allocate(*asked, reserve, contact)
    return each[0], comes[0], slot.real, caging


@given(TEAMS, st.floats(0.0, 2.0), st.floats(-3.0, 3.0))
def test_boats_can_only_push(team, ahead, moment):
    """Force in units of the drag at full speed; moment, of that at a quarter of the length."""
    params = make_params("push", team)
    force = full_drag(params)
    each, comes, u, caging = shared(
        params, ahead * force, moment * force * params.vessel.length / 4
    )
    assert (each[~caging] > 0).all()
    np.testing.assert_array_equal(each[caging], 0.0)
    assert each.sum() >= ahead * force * (1 - 1e-12)
    np.testing.assert_allclose(comes, -(each * u)[~caging].sum(), atol=1e-15)


@given(TEAMS, st.floats(0.3, 2.0), st.floats(-0.5, 0.5))
def test_a_small_wrench_comes_about_as_it_is_asked(team, ahead, moment):
    params = make_params("push", team)
    ahead = ahead * full_drag(params)
    _, _, u, caging = shared(params, ahead, 0.0)
    u, pushers = u[~caging], (~caging).sum()
    moment = moment * ahead * (u**2).sum() / pushers / np.abs(u).max()
    each, comes, _, _ = shared(params, ahead, moment)
    assert each.sum() == pytest.approx(ahead)
    assert comes == pytest.approx(moment, abs=1e-15)


@given(TEAMS, st.floats(0.0, 1.0), st.floats(1.0, 1e3))
def test_no_moment_is_too_large_to_ask(team, ahead, moment):
    """What comes of it is the most there is, the same for all that is too much."""
    params = make_params("push", team)
    ahead = ahead * full_drag(params)
    most = shared(params, ahead, 1e6)
    each, comes, u, caging = shared(params, ahead, moment)
    np.testing.assert_allclose(each, most[0])
    assert 0 < comes <= each.sum() * np.abs(u[~caging]).max()
    assert each.sum() < 3 * full_drag(params)


@given(TEAMS, st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_mirrored_wrench_is_shared_by_the_mirrored_boats(team, ahead, moment):
    params = make_params("push", team)
    force = full_drag(params)
    asked = ahead * force, moment * force * params.vessel.length / 4
    each, comes, _, _ = shared(params, *asked)
    image, mirrored, _, _ = shared(params, asked[0], -asked[1])
    np.testing.assert_allclose(image, each[::-1], atol=1e-15)
    assert mirrored == pytest.approx(-comes, abs=1e-15)


@given(TEAMS, st.floats(0.01, 2.0))
def test_a_vessel_that_is_too_fast_is_left_alone(team, surplus):
    params = make_params("push", team)
    each, _, _, caging = shared(params, -surplus * full_drag(params), 0.0)
    assert (each[~caging] < 0).all()
