"""The vessel's paths to its goal and their timetable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from asv_env import make_params
from asv_env.geometry import direction, wrap
from baselines.paper import dubins
from baselines.scripted import PathGains, ScriptedPolicy
from baselines.scripted.planner import SEGMENTS, PathPlanner

coordinates = st.floats(-3.0, 3.0)
angles = st.floats(-np.pi, np.pi)
gains = st.builds(
    PathGains,
    widest_radius=st.floats(1.0, 5.0),
    tightest_radius=st.floats(0.3, 1.0),
    radius_cost=st.floats(0.0, 2.0),
    final_straight=st.floats(0.0, 1.5),
    straight_cost=st.floats(0.0, 2.0),
    speed=st.floats(0.03, 0.15),
    braking=st.floats(0.1, 1.0),
    goal_speed=st.floats(0.002, 0.01),
)
VESSELS = {
    "nominal": make_params().hulls()[0],
    "long": make_params(num_boats=12).hulls()[0],
    "linear": make_params(preset="paper_simulation").hulls()[0],
}
vessels = st.sampled_from(list(VESSELS.values()))
every_vessel = pytest.mark.parametrize("vessel", VESSELS.values(), ids=VESSELS)


def some_goals(count=300, scale=1.0):
    """Goals (count,) and headings (count,)."""
    rng = np.random.default_rng(0)
    goal = rng.uniform(-1.5, 1.5, count) + 1j * rng.uniform(-1.5, 1.5, count)
    return scale * goal, rng.uniform(-np.pi, np.pi, count)


# ---------------------------------------------------------------------- paths


@given(vessels, gains, coordinates, coordinates, angles)
def test_paths_are_as_asked_and_end_on_the_goal(vessel, gains, x, y, turn):
    path = PathPlanner(vessel, gains).plan(np.array([x + 1j * y]), np.array([turn]))
    assert path.length.shape == path.curvature.shape == (1, SEGMENTS)
    np.testing.assert_array_equal(path.start, np.zeros((1, 3)))
    end = path.end[0]
    assert np.hypot(end[0] - x, end[1] - y) < 1e-9
    assert abs(wrap(end[2] - turn)) < 1e-9
    assert path.curvature[0, -1] == 0
    assert path.length[0, -1] <= gains.final_straight * vessel.length * (1 + 1e-12)
    radius = 1 / np.abs(path.curvature[path.curvature != 0]) / (vessel.length / 2)
    assert (radius <= gains.widest_radius * (1 + 1e-12)).all()
    assert (radius >= gains.widest_radius * gains.tightest_radius * (1 - 1e-12)).all()


def test_a_vessel_on_its_goal_need_not_move():
    path = PathPlanner(VESSELS["nominal"], PathGains()).plan(np.zeros(2, complex), np.zeros(2))
    np.testing.assert_array_equal(path.total_length, 0.0)


def test_no_goals_give_no_paths():
    path = PathPlanner(VESSELS["nominal"], PathGains()).plan(np.empty(0, complex), np.empty(0))
    assert path.length.shape == (0, SEGMENTS)


@every_vessel
def test_paths_to_mirrored_goals_are_mirrored(vessel):
    planner, (goal, turn) = PathPlanner(vessel, PathGains()), some_goals()
    path, image = planner.plan(goal, turn), planner.plan(-goal.conj(), -turn)
    np.testing.assert_allclose(image.curvature, -path.curvature, atol=1e-12)
    np.testing.assert_allclose(image.length, path.length, atol=1e-12)


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_paths_scale_with_the_vessel(factor):
    vessel = VESSELS["nominal"]
    path = PathPlanner(vessel, PathGains()).plan(*some_goals())
    larger = PathPlanner(vessel.stretched(factor * vessel.length), PathGains())
    scaled = larger.plan(*some_goals(scale=factor))
    np.testing.assert_allclose(scaled.length, factor * path.length, atol=1e-9)
    np.testing.assert_allclose(scaled.curvature, path.curvature / factor, atol=1e-9)


@every_vessel
def test_path_is_the_shortest_where_comfort_counts_for_nothing(vessel):
    gains, (goal, turn) = PathGains(radius_cost=0.0, straight_cost=0.0), some_goals()
    path = PathPlanner(vessel, gains).plan(goal, turn)
    poses = np.stack([goal.real, goal.imag, turn], axis=-1)
    tightest = gains.widest_radius * gains.tightest_radius * vessel.length / 2
    np.testing.assert_allclose(path.total_length, dubins.length(poses, tightest), rtol=1e-9)


@every_vessel
def test_path_is_the_most_comfortable_where_the_way_counts_for_nothing(vessel):
    gains, (goal, turn) = PathGains(radius_cost=1e3, straight_cost=1e3), some_goals()
    path = PathPlanner(vessel, gains).plan(goal, turn)
    straight = gains.final_straight * vessel.length
    before = goal + 1j * straight * direction(turn)
    poses = np.stack([before.real, before.imag, turn], axis=-1)
    widest = dubins.length(poses, gains.widest_radius * vessel.length / 2)
    np.testing.assert_allclose(path.total_length, widest + straight, rtol=1e-9)


@every_vessel
def test_a_costlier_bend_never_tightens_a_path(vessel):
    goal, turn = some_goals()
    tightest = []
    for tight in (0.0, 0.5, 1.0, 2.0):
        path = PathPlanner(vessel, PathGains(radius_cost=tight, straight_cost=0.0)).plan(goal, turn)
        tightest.append(np.abs(path.curvature).max(axis=-1))
    assert (np.diff(tightest, axis=0) <= 1e-12).all()
    assert (tightest[-1] < tightest[0] - 0.1).any()


# ---------------------------------------------------------------------- timetable


@given(vessels, gains)
def test_vessel_passes_its_goal_as_slowly_as_asked(vessel, gains):
    planner = PathPlanner(vessel, gains)
    assert planner.speed(np.array(0.0)) == pytest.approx(gains.goal_speed, rel=1e-9)
    assert planner.speed(np.array(50.0)) == gains.speed
    assert planner.speed(np.array(-10.0)) == 0.0


@every_vessel
def test_coasting_vessel_comes_to_rest_after_the_way_that_is_left(vessel):
    """A vessel that is never driven nor held back, from the speed of the timetable on."""
    planner = PathPlanner(vessel, PathGains(speed=10.0, braking=1.0, goal_speed=1e-9))
    linear, quadratic = vessel.sway
    for distance in (0.02, 0.2, 0.5):
        solution = solve_ivp(
            lambda s, v: -(linear + quadratic * v) / vessel.masses[1],
            (0.0, distance), [planner.speed(np.array(distance))], rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        assert abs(solution.y[0, -1]) < 1e-7


@given(vessels, gains)
def test_timetable_asks_for_no_braking(vessel, gains):
    """The water alone slows the vessel down by more."""
    planner, step = PathPlanner(vessel, gains), 1e-6
    left = np.linspace(0.0, 3.0, 200)
    speed = planner.speed(left)
    slows = speed * (planner.speed(left + step) - speed) / step
    linear, quadratic = vessel.sway
    drag = (linear + quadratic * speed) * speed / vessel.masses[1]
    assert (slows >= 0).all()
    assert (slows <= drag * (1 + 1e-4)).all()


@every_vessel
@pytest.mark.parametrize("left", [0.1, 0.4, 1.5, 6.0])
def test_time_is_that_of_the_way_at_its_speeds(vessel, left):
    planner = PathPlanner(vessel, PathGains())
    kinks = np.linspace(0.0, min(left, 0.5), 20)[1:-1]
    expected = quad(lambda s: 1 / planner.speed(np.array(s)), 0, left, points=kinks, limit=500)[0]
    assert planner.time(np.array(left)) == pytest.approx(expected, rel=1e-3)


@every_vessel
def test_time_grows_with_the_way(vessel):
    planner = PathPlanner(vessel, PathGains())
    time = planner.time(np.linspace(0.0, 20.0, 1000))
    assert time[0] == 0
    assert (np.diff(time) > 0).all()


def test_a_vessel_that_never_comes_to_rest_is_refused():
    with pytest.raises(ValueError, match="sway"):
        ScriptedPolicy(make_params("push", vessel={"sway": (0.0, 2.0)}))


def test_a_vessel_that_slides_freely_is_refused():
    with pytest.raises(ValueError, match="surge"):
        ScriptedPolicy(make_params("push", vessel={"surge": (0.0, 0.0), "fins": 0.0}))
