"""Vessels of any outline: what they are, how they float, collide, are grasped and are refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers import World, begin_at, bodies, open_water
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import HULLS, Simulation, make_params, polygons
from asv_env.geometry import rectangle
from asv_env.params import VesselParams
from asv_env.params.outlines import SHAPES
from asv_env.physics.basin import Basin
from asv_env.polygons import complex_corners, contains, outline, to_outline
from asv_env.sensing import observation
from asv_env.tasks import formation

approx = pytest.approx
SIDES = [1.0, -1.0]
LONG_L = [(0, 0), (0.6, 0), (0.6, 0.15), (0.15, 0.15), (0.15, 0.4), (0, 0.4)]


def placed(corners, x, y, heading):
    return complex_corners(corners) * np.exp(1j * heading) + complex(x, y)


def overlap(one, other):
    """Depth to which two polygons (n,) lie in each other: of corners and middles of edges, m."""
    depth = 0.0
    for points, polygon in ((one, other), (other, one)):
        for point in [*points, *((points + np.roll(points, 1)) / 2)]:
            if contains(polygon, point):
                depth = max(depth, abs(to_outline(outline(polygon), point)))
    return depth


# ------------------------------------------------------------------ what they are


@pytest.mark.parametrize("name", SHAPES)
def test_named_hulls_float_like_the_plank(name):
    vessel = make_params(vessel=name).vessel
    area = polygons.area(vessel.corners)
    assert vessel.mass == approx(10.0 * area)
    assert name == "barge" or area == approx(0.06)
    assert polygons.centroid(vessel.corners) == approx((0, 0), abs=1e-12)
    assert name in HULLS


def test_plank_is_the_nominal_vessel():
    assert make_params(vessel="plank") == make_params() == make_params(vessel="nominal")


def test_coefficients_of_the_rectangle_are_nearly_the_nominal_vessels():
    """The linear yaw drag has that of the ends too, and A11, 2 % of the mass, is that of strips."""
    nominal, derived = VesselParams(), VesselParams.shaped(rectangle(0.40, 0.15))
    assert derived.masses == approx(nominal.masses, rel=0.01)
    assert derived.added_mass[1] == approx(nominal.added_mass[1], rel=0.02)
    assert derived.added_inertia == approx(nominal.added_inertia, rel=0.02)
    for name, tolerance in (("surge", 0.02), ("sway", 0.02), ("yaw", 0.08)):
        assert getattr(derived, name) == approx(getattr(nominal, name), rel=tolerance), name


def test_a_disc_has_the_inertia_of_one_and_turns_without_form_drag():
    disc = VesselParams.shaped(SHAPES["disc"])
    radius = math.sqrt(0.06 / math.pi)
    assert disc.total_inertia == approx(0.6 * radius**2 / 2, rel=0.005)
    assert disc.added_inertia == approx(0.0, abs=1e-3 * disc.total_inertia)
    assert disc.yaw[1] < 1e-3 * VesselParams().yaw[1]
    assert disc.surge == approx(disc.sway, rel=1e-6)
    # Form drag of a cylinder by the squared normal velocity: 2/3 of that of its width.
    assert disc.sway[1] == approx(0.5 * 1000 * 0.9 * 0.01 * 2 * radius * 2 / 3, rel=0.01)


stars = st.lists(st.floats(0.12, 0.3), min_size=4, max_size=10).map(
    lambda radii: [
        (r * math.cos(2 * math.pi * k / len(radii)), r * math.sin(2 * math.pi * k / len(radii)))
        for k, r in enumerate(radii)
    ]
)


@settings(max_examples=25, deadline=None)
@given(corners=stars)
def test_coefficients_turn_and_mirror_with_the_outline(corners):
    hull = VesselParams.shaped(corners)
    turned = VesselParams.shaped(polygons.turned(corners))
    mirrored = VesselParams.shaped([(x, -y) for x, y in corners])
    assert (turned.surge, turned.sway) == (approx(hull.sway), approx(hull.surge))
    assert turned.added_mass == approx(hull.added_mass[::-1])
    for name in ("added_mass", "surge", "sway", "yaw", "mass", "added_inertia", "total_inertia"):
        assert getattr(mirrored, name) == approx(getattr(hull, name), rel=1e-6, abs=1e-9), name
    for name in ("yaw", "mass", "added_inertia", "total_inertia"):
        assert getattr(turned, name) == approx(getattr(hull, name), rel=1e-6, abs=1e-9), name
    positive = [*hull.masses, *hull.added_mass, *hull.surge, *hull.sway, *hull.yaw]
    assert min(positive) > 0
    assert VesselParams.shaped(hull.corners) == hull


def test_named_hulls_grow_with_the_team_and_others_do_not():
    small, large = (make_params(num_boats=team, vessel="hexagon").vessel for team in (4, 12))
    factor = large.length / small.length
    assert factor > 2
    np.testing.assert_allclose(large.corners, factor * np.array(small.corners))
    assert large.mass == approx(factor**2 * small.mass)
    own = [make_params(num_boats=team, vessel={"outline": LONG_L}).vessel for team in (4, 7)]
    assert own[0] == own[1]
    assert (own[0].length, own[0].width) == approx((0.6, 0.4))


def test_what_is_given_beside_an_outline_counts():
    vessel = make_params(vessel={"outline": "disc", "mass": 1.2, "sway": (0.5, 0.5)}).vessel
    light = make_params(vessel="disc").vessel
    assert (vessel.mass, vessel.sway, vessel.surge[1]) == (1.2, (0.5, 0.5), 2 * light.surge[1])
    assert vessel.total_inertia - vessel.added_inertia == approx(2 * light.total_inertia, rel=1e-3)
    heavy = make_params(vessel={"outline": "disc", "inertia": 0.1}).vessel
    assert heavy.inertia == 0.1


@pytest.mark.parametrize("name", ["disc", "L"])
def test_another_scale_has_similar_hulls(name):
    small, large = make_params(vessel=name), make_params(vessel=name, scale=4.0)
    assert large.vessel.mass == approx(64 * small.vessel.mass)
    again = large.rescaled(0.25).vessel
    np.testing.assert_allclose(again.corners, small.vessel.corners, rtol=1e-12, atol=1e-12)
    assert again.masses == approx(small.vessel.masses)
    given = [(4 * x, 4 * y) for x, y in small.vessel.corners]
    own = make_params(vessel={"outline": given}, scale=4.0).vessel
    assert own.masses == approx(large.vessel.masses)


def test_size_is_that_of_the_plank_of_the_same_area():
    assert make_params(vessel="disc").vessel.size == approx(0.40)
    assert make_params(vessel="disc").task == make_params().task
    assert make_params(vessel="barge").vessel.size == approx(0.48)
    assert make_params(vessel="barge").task.arena == approx(1.2 * make_params().task.arena)


# ------------------------------------------------------------------ how they are grasped


def team_round(params, side):
    """Outlines (n,) of the boats in their slots on a side."""
    slots = formation.slots(params, params.num_boats, side)
    return [placed(params.boat.corners, s.real, s.imag, -side * math.pi / 2) for s in slots]


@pytest.mark.parametrize("team", [2, 3, 4, 5, 8])
@pytest.mark.parametrize("name", ["plank", *SHAPES, LONG_L], ids=str)
def test_boats_in_their_slots_touch_the_convex_hull_and_lie_apart(name, team):
    vessel = name if isinstance(name, str) else {"outline": name}
    params = make_params(num_boats=team, vessel=vessel)
    hull = complex_corners(polygons.convex_hull(params.vessel.corners))
    for side in SIDES:
        boats = team_round(params, side)
        assert max(overlap(hull, boat) for boat in boats) < 1e-9
        at_side = boats[1:-1] if team >= 4 else boats
        for boat in at_side:
            gaps = [abs(to_outline(outline(hull), corner)) for corner in boat]
            gaps += [abs(to_outline(outline(boat), corner)) for corner in hull]
            assert min(gaps) < 1e-9
        for k in range(1, team):
            assert overlap(boats[k - 1], boats[k]) == 0.0
        along = formation.slots(params, team, side).real
        assert (np.diff(along) > params.boat.width).all()


@pytest.mark.parametrize("name", ["disc", "hexagon", "square", "barge"])
def test_slots_of_a_symmetric_hull_are_mirror_images(name):
    params = make_params(vessel=name)
    above, below = (formation.slots(params, 4, side) for side in SIDES)
    np.testing.assert_allclose(below, above.conj(), atol=1e-12)


@pytest.mark.parametrize("name", ["disc", "hexagon", "square", "barge", "L", "T", "triangle"])
def test_side_boats_of_four_stand_where_friction_holds_them(name):
    params = make_params(vessel=name)
    u, w = polygons.upper_side(params.vessel.corners)
    low, high = formation.holding_part(u, w, params.water.contact_friction)
    places = formation.slots(params, 4)[1:3].real
    inner = params.boat.bow / 2  # On a slope a boat touches with the inner corner of its bow.
    assert low - inner <= places.min() <= places.max() <= high + inner


def test_a_team_begins_to_push_on_the_side_of_its_hull():
    params = make_params("push", vessel="triangle", side="-n")
    sim = Simulation(params)
    sim.reset(seeds=[0])
    np.testing.assert_allclose(sim.state.slot[0], formation.slots(params, 4, -1.0))
    assert sim.state.closed.all()
    for _ in range(20):
        sim.step(np.full((1, 4, 2), [0.5, 0.0], dtype=np.float32))
    assert sim.state.motion[0, 0, 1] > 0.002


def test_observation_tells_the_nearest_point_of_the_hull():
    params = make_params("push", vessel="L", observation=["hull", "hull_fine"])
    sim = Simulation(params)
    sim.reset(seeds=[5])
    seen = observation.observe(observation.features(params), sim.sensed, params)[0]
    motion, hull = sim.sensed.estimate[0], outline(complex_corners(params.vessel.corners))
    for boat in range(4):
        x, y, heading = motion[1 + boat, :3] - motion[0, :3]
        vector = to_outline(hull, complex(x, y)) * np.exp(-1j * heading)
        expected = np.array([vector.real, vector.imag])
        np.testing.assert_allclose(seen[boat, :2], expected / params.vessel.size, atol=1e-6)
        np.testing.assert_allclose(seen[boat, 2:], np.clip(expected / 0.1, -1, 1), atol=1e-5)


# ------------------------------------------------------------------ how they move and collide


def test_rectangle_given_as_an_outline_moves_like_the_rectangle():
    plank = open_water(control=10)
    outline = replace(plank.vessel, outline=tuple(rectangle(0.40, 0.15)))
    shaped = replace(plank, vessel=outline)
    start = bodies((), (0.05, 0.15, -1.4), (-0.1, 0.14, -1.6))
    one, other = (World(params, start).record(5, (1.0, 0.8)) for params in (plank, shaped))
    np.testing.assert_array_equal(one, other)
    assert one[-1, 0, 1] < -0.01


@pytest.mark.parametrize("name", SHAPES)
def test_convex_pieces_make_up_the_hull(name):
    basin = Basin(make_params(vessel=name), 1, 1)
    pieces = [shape.get_vertices() for shape in basin._bodies[0][0].shapes]
    assert all(map(polygons.is_convex, pieces))
    assert sum(map(polygons.area, pieces)) == approx(
        polygons.area(make_params(vessel=name).vessel.corners)
    )
    assert (len(pieces) == 1) == (name not in "LT")


def test_all_pieces_have_the_friction_of_the_episode():
    sim = Simulation(make_params("push", vessel="T", scenario="mismatch"), 2)
    sim.reset(seeds=[1, 2])
    for bodies_of_world in sim._dynamics.basin._bodies:
        roots = {shape.friction for body in bodies_of_world for shape in body.shapes}
        assert len(roots) == 1


@settings(max_examples=8, deadline=None)
@given(corners=stars, seed=st.integers(0, 1000))
def test_no_hull_enters_another(corners, seed):
    """Boats drive against a vessel of a random outline, at random and as fast as they can."""
    params = open_water(num_boats=2, control=10, vessel={"outline": corners})
    rng, sim = np.random.default_rng(seed), Simulation(params, 2)
    angles = rng.uniform(-np.pi, np.pi, (2, 1)) + np.array([0.0, 2.5])
    starts = [
        bodies((), *((0.45 * math.cos(a), 0.45 * math.sin(a), a + math.pi) for a in world))
        for world in angles
    ]
    begin_at(sim, starts)
    for _ in range(80):
        sim.step(rng.uniform(-0.2, 1.0, (2, 2, 2)).astype(np.float32))
    assert np.isfinite(sim.state.motion).all()
    for motion in sim.state.motion:
        hulls = [params.vessel.corners] + [params.boat.corners] * 2
        shapes = [placed(hull, *row[:3]) for hull, row in zip(hulls, motion, strict=True)]
        deepest = max(overlap(shapes[i], shapes[j]) for i in range(3) for j in range(i))
        assert deepest < 2e-3


# ------------------------------------------------------------------ what is refused


def square(**changes):
    corners = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]
    for place, corner in changes.items():
        corners[int(place[1:])] = corner
    return corners


@pytest.mark.parametrize(("outline", "message"), [
    ([(0, 0), (1, 0)], "from 3 to 64 corners"),
    ([(0, 0), (1, 0), (0, math.nan)], "finite"),
    ([(0, 0), (1, 0), (0, math.inf)], "finite"),
    ([(0, 0), (1, 0), (0, 1, 2)], "from 3 to 64 corners"),
    ([(0, 0), (1, 0), "ab"], "from 3 to 64 corners"),
    (7, "from 3 to 64 corners"),
    ([(math.cos(k), math.sin(k)) for k in range(100)], r"\(100 corners\): give from 3 to 64"),
    (square(_1=[0.0, 0.0]), "leave one of them out"),
    (square(_3=[0.0, 1e-5]), "leave one of them out"),
    ([*square(), [0.0, 0.0]], "the outline closes by itself"),
    ([(0, 0), (0.5, 0.5), (0.5, 0), (0, 0.5)], "crosses or touches itself"),
    ([(0, 0), (0.25, 0), (0.5, 0)], "it is 0.5 m long and 0 m wide"),
    ([(0, 0), (0.5, 0), (0.5, 0.003), (0, 0.003)], "too thin"),
    ([(0, 0), (1e6, 0), (0, 1e6)], r"both must lie in \[0.001, 10000\] m"),
    ("dics", "Did you mean 'disc'"),
])  # fmt: skip
def test_outlines_that_are_none_are_refused(outline, message):
    with pytest.raises(ValueError, match=message):
        make_params(vessel={"outline": outline})


@pytest.mark.parametrize("option", ["length", "width"])
def test_extents_beside_an_outline_are_refused(option):
    with pytest.raises(ValueError, match=f"{option} beside an outline"):
        make_params(vessel={"outline": "disc", option: 0.3})
    with pytest.raises(ValueError, match=f"VesselParams.{option} = .*leave it out"):
        replace(VesselParams.shaped(SHAPES["disc"]), **{option: 0.5})


def test_teams_that_do_not_fit_round_a_hull_are_refused():
    with pytest.raises(ValueError, match=r"12 boats .* do not fit along .* a larger outline"):
        make_params(num_boats=12, vessel={"outline": LONG_L})
    with pytest.raises(ValueError, match=r"unknown parameter of boat 'outline'"):
        make_params(boat="disc")
