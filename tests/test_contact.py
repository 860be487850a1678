"""Contact between hulls and with walls: momentum, energy, friction, what touches."""

import numpy as np
import pytest
from helpers import (
    AHEAD,
    BOAT,
    DOWN,
    OFF,
    ROUND,
    VESSEL,
    World,
    bodies,
    dragless,
    kinetic_energy,
    masses,
    momenta,
    momentum,
    open_water,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import make_params

approx = pytest.approx


def test_boat_that_rams_the_vessel_shares_its_momentum_and_does_not_bounce():
    params = dragless()
    motion = World(params, bodies((), (0, 0.2, DOWN, 0, -0.2), (-2,))).run(3)
    boat, vessel = params.boat.masses[0], params.vessel.contact_mass
    together = -0.2 * boat / (boat + vessel)
    assert motion[VESSEL, 4] == approx(together, rel=0.01)
    assert abs(motion[BOAT, 4] - motion[VESSEL, 4]) < 0.01 * 0.2


def test_collision_gives_the_vessel_what_it_takes_from_the_boat():
    params = dragless(ROUND)
    motions = World(params, bodies((), (0.1, 0.2, DOWN + 0.3, 0, -0.2), (-2,))).record(2)
    own = momenta(params, motions)
    boat, vessel = (own[:, row] - own[0, row] for row in (BOAT, VESSEL))
    assert np.abs(vessel).max() > 1e-3
    np.testing.assert_allclose(boat, -vessel, atol=1e-12)


def test_off_centre_collision_keeps_the_angular_momentum():
    params = dragless(ROUND)
    motions = World(params, bodies((), (0.12, 0.2, DOWN, 0, -0.2), (-2,))).record(2)
    (x, y), (px, py) = (np.moveaxis(v, -1, 0) for v in (motions[..., :2], momenta(params, motions)))
    angular = (x * py - y * px + masses(params)[:, 2] * motions[..., 5]).sum(axis=-1)
    assert motions[-1, VESSEL, 5] < -0.01
    np.testing.assert_allclose(angular, angular[0], rtol=0.01)


def test_pushing_hands_on_the_impulse_of_the_motors():
    """The boats are too heavy to turn, so their thrust has one direction; the vessel turns."""
    hulls = {**ROUND, "boat": {**ROUND["boat"], "added_inertia": 1e9}}
    params = dragless(hulls)
    ahead = np.array([DOWN + 0.1, DOWN - 0.05])
    world = World(
        params, bodies((), *[(x, 0.136, h) for x, h in zip((-0.08, 0.05), ahead, strict=True)])
    )
    impulse = 0.0
    for _ in range(100):
        world.step([(1.0, 0.8), (0.7, 0.9)])
        impulse += params.clock.dt * (world.thrust.sum(axis=-1) * np.exp(1j * ahead)).sum()
    expected = impulse.real, impulse.imag
    np.testing.assert_allclose(momentum(params, world.motion), expected, atol=1e-12)
    assert world.motion[VESSEL, 4] < -0.05
    assert abs(world.motion[VESSEL, 5]) > 0.01


speeds = st.floats(-0.3, 0.3)
spins = st.floats(-2, 2)
motions = st.tuples(speeds, speeds, spins)


@settings(max_examples=40)
@given(vessel=motions, boats=st.tuples(motions, motions, motions), friction=st.floats(0, 1))
@pytest.mark.parametrize("drag", [True, False])
def test_motors_off_energy_never_grows_in_contact(drag, vessel, boats, friction):
    options = {"num_boats": 3, "water": {"contact_friction": friction}}
    params = open_water(**options) if drag else dragless(ROUND, **options)
    places = ((-0.06, 0.135, DOWN), (0.01, 0.135, DOWN), (0.08, 0.135, DOWN))
    start = bodies(
        (0, 0, 0, *vessel), *(place + boat for place, boat in zip(places, boats, strict=True))
    )
    energy = kinetic_energy(params, World(params, start).record(0.6))
    assert np.all(np.diff(energy) <= 1e-12 * energy[0])
    assert energy[-1] <= energy[0] * (1 + 1e-12)


@settings(max_examples=15)
@given(vessel=motions, boats=st.tuples(motions, motions))
def test_momentum_is_kept_without_drag_whatever_the_hulls_do_to_each_other(vessel, boats):
    params = dragless(ROUND)
    places = ((-0.05, 0.135, DOWN), (0.05, 0.135, DOWN))
    start = bodies(
        (0, 0, 0, *vessel), *(place + boat for place, boat in zip(places, boats, strict=True))
    )
    total = momentum(params, World(params, start).record(0.6))
    np.testing.assert_allclose(total, np.broadcast_to(total[0], total.shape), atol=1e-12)


HEAVY = {"mass": 1e6, "inertia": 1e6}


def sliding_friction(params, start):
    """Friction coefficient with which a boat that is pressed down slows down in sliding."""
    world = World(params, start)
    pressed = 0.0
    for _ in range(50):
        world.step([AHEAD, OFF])
        pressed += params.clock.dt * world.thrust[0].sum()
    assert world.motion[BOAT, 3] > 0.005
    return params.boat.contact_mass * (start[BOAT, 3] - world.motion[BOAT, 3]) / pressed


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_friction_between_hulls_is_what_was_asked_for(friction):
    params = dragless(
        hulls={"boat": {**ROUND["boat"], "added_inertia": 1e6}, "vessel": HEAVY},
        water={"contact_friction": friction},
    )
    start = bodies((), (-0.15, 0.135, DOWN, 0.1), (-2,))
    assert sliding_friction(params, start) == approx(friction, rel=0.01)


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_friction_against_a_wall_is_what_was_asked_for(friction):
    params = dragless(
        arena=1.5,
        goal=(1, 1, 0),
        hulls={**ROUND, "boat": {**ROUND["boat"], "added_inertia": 1e6}},
        water={"walls": 1.5, "contact_friction": friction},
    )
    start = bodies((), (-0.15, -1.44, DOWN, 0.1), (-1,))
    assert sliding_friction(params, start) == approx(friction, rel=0.01)


def test_drawn_friction_is_the_one_that_acts():
    params = dragless(variation={"friction": (0.5, 0.5)})
    assert params.water.contact_friction == 0.3
    hulls = {"boat": {**ROUND["boat"], "added_inertia": 1e6}, "vessel": HEAVY}
    params = dragless(hulls, variation={"friction": (0.5, 0.5)})
    start = bodies((), (-0.15, 0.135, DOWN, 0.1), (-2,))
    assert sliding_friction(params, start) == approx(0.5, rel=0.01)


def test_hulls_touch_where_their_outlines_meet():
    """Bow on the long side, flank on the end, stern on the long side: 1 mm off, 0.1 mm in."""
    params = open_water(num_boats=3)
    reach = np.array([0.135, 0.2325, -0.135])
    for gap, touching in ((1e-3, False), (-1e-4, True)):
        x, y, z = reach + gap * np.sign(reach)
        start = bodies((), (0, y * 0 + x, DOWN), (y, 0, DOWN), (0.05, z, DOWN))
        world = World(params, start)
        world.step()
        assert world.sim.state.touching[0, :, 0].tolist() == [touching] * 3
        assert not world.sim.state.touching[0, :, 1].any()


def test_boats_that_touch_each_other_say_so_and_not_the_vessel():
    world = World(open_water(3), bodies((), (1, 0), (1, 0.064), (-1, 0)))
    world.step()
    assert world.sim.state.touching[0].tolist() == [[False, True], [False, True], [False, False]]


@pytest.mark.parametrize("heading", [0.0, 0.7, np.pi / 4, np.pi / 2, np.pi, DOWN])
def test_walls_of_the_tank_hold_a_boat_at_full_thrust(heading):
    params = make_params("transport", 2, preset="tank", action_mode="thrusters", time_limit=1e4)
    world = World(params, bodies((), (1, 0.5, heading), (-1, -0.5, heading + 3)))
    motions = world.record(25, AHEAD)
    assert np.abs(motions[..., :2]).max() < 1.5
    assert not world.sim.ending.strayed.any()
    assert world.sim.state.touching[0, :, 1].all()


def test_walls_of_the_tank_hold_a_vessel_that_is_pushed_against_them():
    params = make_params("push", 2, preset="tank", action_mode="thrusters", goal=(1, 1, 0))
    motion = World(params, bodies((), (-0.07, 0.136, DOWN), (0.07, 0.136, DOWN))).run(30, AHEAD)
    assert motion[VESSEL, 1] == approx(-1.5 + 0.075, abs=0.002)
