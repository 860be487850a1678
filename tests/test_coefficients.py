"""The derivation of the hydrodynamic coefficients, and the defaults that follow from it."""

import math
from pathlib import Path

import pytest
from scipy.integrate import quad

from asv_env.params import BoatParams, VesselParams, strips
from asv_env.params.hull_params import FIN_ADDED_MASS
from asv_env.params.literature import CRAFT
from baselines.evaluate.publish import marks

FOLDER = Path(__file__).parents[1] / "benchmarks"
approx = pytest.approx


@pytest.fixture
def coefficients(monkeypatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    import coefficients

    return coefficients


@pytest.mark.parametrize("beam", [0.02, 0.04, 0.3])
def test_elliptic_sections_have_the_added_mass_of_their_draft(coefficients, beam):
    mass = coefficients.lewis_sway(beam, draft=0.02, fullness=math.pi / 4)
    assert mass == approx(500 * math.pi * 0.02**2)


@pytest.mark.parametrize("corner", [0.45, 0.6, 0.8, 1.2])
def test_table_of_rectangles_agrees_with_their_conformal_map(coefficients, corner):
    """Map z' = sqrt(1 - 2 cos(2 p) / s^2 + 1 / s^4) of the circle's outside, corners at +-p."""

    def half_side(*ends):
        return quad(lambda t: math.sqrt(2 * abs(math.cos(2 * t) - math.cos(2 * corner))), *ends)[0]

    height, length = half_side(0, corner), half_side(corner, math.pi / 2)
    mass = 2 * math.pi * (1 - math.cos(2 * corner)) - 4 * height * length
    ratio = mass / (math.pi * height**2)
    table = coefficients.interpolated(strips.RECTANGLE, height / length)
    assert 0.1 < height / length < 10
    assert table == approx(ratio, rel=0.01)


@pytest.mark.parametrize(
    ("ratio", "surge", "sway", "yaw"), [(2.0, 0.209, 0.702, 0.240), (3.99, 0.082, 0.860, 0.608)]
)
def test_spheroids_have_lambs_factors(coefficients, ratio, surge, sway, yaw):
    """Lamb, Hydrodynamics, article 115: table of prolate spheroids."""
    turning = yaw * (1 + ratio**-2)  # of strips, whose inertia has no breadth
    assert coefficients.end_factors(ratio, 1.0, 0.5) == approx((surge, sway, turning), abs=3e-3)


def test_boat_floats_and_reaches_its_top_speed(coefficients):
    linear, quadratic = coefficients.defaults(coefficients.boat(BoatParams()))["surge"]
    speed = coefficients.TOP_SPEED
    assert (linear + quadratic * speed) * speed == approx(2 * BoatParams().thrust, rel=0.01)


def test_vessel_coasts_as_far_as_the_papers(coefficients):
    derived = coefficients.defaults(coefficients.vessel(VesselParams()))
    linear, quadratic = derived["sway"]
    mass = VesselParams().mass + derived["added_mass"][1]
    assert mass / quadratic * math.log1p(0.04 * quadratic / linear) == approx(0.20, rel=0.005)


def test_yaw_time_of_the_boat_lies_among_those_of_published_craft(coefficients):
    boat, derived = BoatParams(), coefficients.defaults(coefficients.boat(BoatParams()))
    time = (boat.inertia + derived["added_inertia"]) / derived["yaw"][0]
    times = coefficients.yaw_times(boat.length).values()
    assert min(times) * 0.99 < time < max(times) * 1.01


def test_linear_drag_is_a_few_times_laminar_friction(coefficients):
    """Both hulls alike: what a film on the water, edges and pods add to a smooth plate."""
    boat, vessel = coefficients.boat(BoatParams()), coefficients.vessel(VesselParams())
    hull, plank = coefficients.friction(0.12, 0.1, 0.0125), coefficients.friction(0.15, 0.04, 0.06)
    assert 2 < boat.surge[0] / hull < 6
    assert 2 < vessel.sway[0] / plank < 6


def test_fins_have_the_drag_and_the_added_mass_of_their_plates(coefficients):
    fins, mass = VesselParams().fins, coefficients.fin_mass(VesselParams().width, draft=0.01)
    assert coefficients.fin_drag(VesselParams().width) == approx(fins)
    assert mass / fins == approx(FIN_ADDED_MASS * VesselParams().width, rel=0.01)


def test_fins_resist_yaw_as_their_strips_do(coefficients):
    bare, whole = VesselParams(), VesselParams().with_fins()
    width = bare.width
    drag, mass = bare.fins / width, whole.added_mass[0] - bare.added_mass[0]
    moment = quad(lambda y: drag * abs(y) ** 3, -width / 2, width / 2)[0]
    inertia = quad(lambda y: mass / width * y**2, -width / 2, width / 2)[0]
    assert whole.yaw[1] - bare.yaw[1] == approx(moment)
    assert whole.added_inertia - bare.added_inertia == approx(inertia)
    assert whole.surge[1] - bare.surge[1] == approx(bare.fins)


@pytest.mark.parametrize("kind", ["boat", "vessel"])
def test_defaults_are_what_is_derived(coefficients, kind):
    hull = {"boat": BoatParams, "vessel": VesselParams}[kind]()
    derived = coefficients.defaults(getattr(coefficients, kind)(hull))
    assert {name: getattr(hull, name) for name in derived} == derived


def test_motors_and_full_yaw_rate_are_what_is_derived(coefficients):
    boat = BoatParams()
    assert coefficients.rounded(coefficients.LEVER_ARM * boat.width) == boat.lever_arm
    assert coefficients.rounded(coefficients.turning_on_the_spot(boat), 1) == boat.full_yaw_rate


def test_yaw_damping_is_near_that_of_strips_and_lift_at_full_speed(coefficients):
    boat = BoatParams()
    assert coefficients.yaw_of_strips(boat, boat.full_speed) == approx(boat.yaw[0], rel=0.2)


def test_stretched_vessel_is_nearly_what_is_derived_at_its_length(coefficients):
    """Ends matter less to a longer hull, most of all to its added inertia, 1/6 of the whole."""
    long = VesselParams().stretched(0.8)
    for name, value in vars(coefficients.vessel(long)).items():
        tolerance = 0.3 if name == "added_inertia" else 0.1
        assert getattr(long, name) == approx(value, rel=tolerance), name
    assert long.added_inertia < long.total_inertia / 6


def test_cybership_has_the_lift_of_its_hull_at_half_of_a_full_action(coefficients):
    boat = CRAFT["cybership2"].boat
    lift = coefficients.lift(draft=0.11, speed=boat.full_speed / 2)
    assert boat.sway[0] == approx(0.88965 + lift, rel=0.01)


def test_page_shows_what_is_derived(coefficients):
    page = (FOLDER.parent / "docs/physics.md").read_text()
    marked = marks.replaced(page, coefficients.START, coefficients.END, coefficients.table())
    assert page == marked, "run python benchmarks/coefficients.py --page docs/physics.md"
