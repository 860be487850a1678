"""Drawings of the reproduction show the geometry of the code."""

import numpy as np
import pytest

from asv_env import make_params
from asv_env.geometry import wrap, xy
from asv_env.render.layout import outline
from asv_env.tasks import formation
from baselines.paper import two_arc
from baselines.paper.arcs import advance
from baselines.paper.spiral import arc_length, exact_bearing_offset
from baselines.reproduce import (
    fig1_2_definitions,
    fig3_4_approach,
    fig5_paths,
    fig6_9_states,
    planner_comparison,
    single_runs,
    sketch,
    style,
)
from baselines.reproduce.artefact import Job

JOB = Job(seed=0, trials=3, episodes=4)


def marks(axes):
    """Points of all crosses on a panel."""
    return np.concatenate([line.get_xydata() for line in axes.lines if line.get_marker() == "x"])


def test_fig_1_shows_the_vessel_and_the_slots_of_the_code():
    (axes,) = fig1_2_definitions.closure(JOB).axes
    params = make_params("push")
    outlines = [patch.get_xy()[:-1] for patch in axes.patches if hasattr(patch, "get_xy")]
    np.testing.assert_allclose(outlines[0], params.vessel.corners)
    slots = formation.slots(params, 4)
    np.testing.assert_allclose(marks(axes), np.stack([slots.real, slots.imag], -1))
    bows = [outline[np.argmin(outline[:, 1])][1] for outline in outlines[1:]]
    np.testing.assert_allclose(bows, slots.imag - params.boat.length / 2)


def test_fig_2_shows_the_centres_of_the_papers_goal():
    _, axes = fig1_2_definitions.quantities(JOB).axes
    known = [[0.57727235, 0], [-0.07284169, -1.01249262], [0.26537077, -0.48575793]]
    np.testing.assert_allclose(marks(axes), known, atol=1e-8)


def test_fig_2_shows_angles_that_fit_the_boat():
    axes, _ = fig1_2_definitions.quantities(JOB).axes
    x, y = fig1_2_definitions.EXAMPLE_BOAT
    spiral = next(line for line in axes.lines if line.get_linestyle() == "--").get_xydata()
    np.testing.assert_allclose(spiral[0], [x, y])
    np.testing.assert_allclose(spiral[-1], 0.0, atol=1e-12)


@pytest.mark.parametrize(("theta", "sense"), [(0.7, 0), (2.9, 1)])
def test_drawn_spiral_has_the_length_and_the_headings_of_the_equations(theta, sense):
    points = fig3_4_approach.spiral_points(1.3, theta, 0.7, sense) @ [1, 1j]
    steps = np.diff(points)
    assert np.abs(steps).sum() == pytest.approx(float(arc_length(1.3, theta, 0.7)), rel=1e-4)
    middle = (points[1:] + points[:-1])[:-20] / 2
    offset = np.angle(steps[:-20] / -middle) * (1 - 2 * sense) * -1
    expected = exact_bearing_offset(np.angle(middle), 0.7)
    np.testing.assert_allclose(np.abs(offset), expected, atol=0.02)
    assert np.sign(np.diff(np.unwrap(np.angle(middle))).sum()) == 2 * sense - 1


def test_fig_5_corrects_a_first_arc_that_boats_cannot_push():
    path = two_arc.plan(np.array(fig5_paths.CORRECTED_GOAL), fig1_2_definitions.ALPHA1)
    wrong = fig5_paths.uncorrected_lengths(path)
    assert wrong[0] < 0 < wrong[1]
    assert (path.length > 0).all()
    for lengths in (wrong, path.length):
        pose = np.zeros(3)
        for curvature, length in zip(path.curvature, lengths, strict=True):
            pose = advance(pose, curvature, length)
        np.testing.assert_allclose(pose[:2], fig5_paths.CORRECTED_GOAL[:2], atol=1e-9)
        assert wrap(pose[2] - fig5_paths.CORRECTED_GOAL[2]) == pytest.approx(0, abs=1e-9)


def test_maps_are_never_below_the_dubins_length():
    for panel in fig5_paths.feasibility(JOB).axes[:8]:
        ratio = panel.collections[0].get_array().compressed()
        assert len(ratio) > 0.5 * fig5_paths.CELLS**2
        assert ratio.min() > 1 - 1e-9


def test_outlines_of_hulls_at_poses():
    vessel = make_params().vessel
    corners = outline(vessel, np.array([[1.0, 2.0, np.pi / 2], [0.0, 0.0, np.pi]]))
    np.testing.assert_allclose(corners[0], np.array(vessel.corners) @ [[0, 1], [-1, 0]] + [1, 2])
    np.testing.assert_allclose(corners[1], -np.array(vessel.corners), atol=1e-12)


def test_every_boat_has_a_colour_of_its_own():
    for team in (4, 8, 10):
        assert len({tuple(np.atleast_1d(c)) for c in style.boat_colours(team)}) == team


def test_poses_seen_from_a_frame():
    frame, pose = np.array([0.3, -0.2, 2.0]), np.array([0.1, 0.4, -1.5])
    seen = single_runs.in_frame(pose, frame)
    point = xy(np.array([seen[0] + 1j * seen[1]]) * np.exp(2j)) + frame[:2]
    np.testing.assert_allclose(point[0], pose[:2])
    assert wrap(seen[2] + 2.0) == pytest.approx(-1.5)


def driven(closure):
    """A run whose vessel drives the planned path exactly, as ``typical_run`` gives it."""
    goal = np.array([0.55, -0.95, 0.1])
    path = two_arc.plan(goal, fig1_2_definitions.ALPHA1)
    way = path.pose_at(np.linspace(0, float(path.total_length), 58))
    vessel = np.concatenate([np.zeros((10, 3)), way])
    boats = np.stack([sketch.slots(make_params(), pose) for pose in vessel])
    poses = np.concatenate([vessel[:, None], boats], axis=1)
    return {
        "closure": closure,
        "times": (np.arange(len(poses)) / 5).tolist(),
        "poses": poses.tolist(),
        "goal": goal.tolist(),
    }


def test_states_of_a_run_are_found():
    shown = single_runs.Run.read(driven(closure=2.0))
    assert shown.closure == 10
    np.testing.assert_allclose(shown.path.end[:2], [0.55, -0.95], atol=1e-9)
    joint = shown.path.joints[1, :2]
    assert np.hypot(*(shown.poses[shown.switch, 0, :2] - joint)) < 0.02
    before, at = np.hypot(*(shown.poses[shown.stop - 1 : shown.stop + 1, 0, :2] - [0.55, -0.95]).T)
    assert at < 0.2 <= before


@pytest.mark.parametrize("closure", [2.0, None])
def test_a_run_is_drawn_with_and_without_closure(closure):
    figure = fig6_9_states.experiment_states(JOB, driven(closure))
    assert len(figure.axes) == 6
    drawn = figure.axes[5].patches[0].get_xy()[:-1]
    expected = outline(make_params().vessel, np.array(driven(closure)["poses"][-1][0]))
    np.testing.assert_allclose(drawn, expected)


def test_shares_of_episodes_rise_by_one_episode_each():
    axes = style.panels(80, 60)[1][0]
    for values, points in (([3.0, None, 1.0, None], [[1, 0], [1, 0.25], [3, 0.5]]), ([None], [])):
        planner_comparison.draw_fractions(axes, values)
        np.testing.assert_allclose(axes.lines[-1].get_xydata(), np.reshape(points, (-1, 2)))
