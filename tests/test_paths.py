"""Arc paths agree with integrated kinematics; two arcs end on their goals, and none is shorter."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_strategies import (
    MIRROR,
    angles,
    arcs,
    as_path,
    curvatures,
    goals,
    lengths,
    many_goals,
    pose_error,
    radii,
    scales,
)
from scipy.integrate import solve_ivp

from baselines.paper import dubins, two_arc
from baselines.paper.arcs import ArcPath, advance


class TestArcPath:
    @given(arcs, goals)
    @settings(max_examples=40, deadline=None)
    def test_agrees_with_integrated_kinematics(self, segments, start):
        path = as_path(segments, start)
        joints = np.concatenate([[0.0], np.cumsum(path.length)])
        pose = np.array(start)
        for k, curvature in enumerate(path.curvature):
            solution = solve_ivp(
                lambda _, p, c=curvature: [np.sin(p[2]), -np.cos(p[2]), c],
                (0.0, path.length[k]), pose, rtol=1e-10, atol=1e-12,
            )  # fmt: skip
            pose = solution.y[:, -1]
            assert pose_error(path.pose_at(joints[k + 1]), pose) < 1e-8
        assert pose_error(path.end, pose) < 1e-8

    @given(arcs, st.floats(0.0, 1.0))
    @settings(max_examples=100, deadline=None)
    def test_moves_along_minus_normal_and_turns_with_its_curvature(self, segments, share):
        path = as_path(segments)
        s = share * path.total_length
        pose = path.pose_at(s)
        step = 1e-6
        ahead = advance(pose, path.curvature_at(s), step)
        np.testing.assert_allclose(
            (ahead - pose) / step,
            [np.sin(pose[2]), -np.cos(pose[2]), path.curvature_at(s)],
            atol=1e-5,
        )

    def test_turns_about_the_centre_on_its_long_axis(self):
        path = ArcPath([0.3, -0.2, 0.7], [2.0, 0.0, -4.0], [0.5, 0.3, 0.4])
        for k, (first, last) in enumerate(pairwise(path.joints)):
            if path.curvature[k] == 0:
                assert np.isinf(path.centres[k]).all()
                continue
            for pose in (first, last):
                axis = np.array([np.cos(pose[2]), np.sin(pose[2])])
                centre = pose[:2] + axis / path.curvature[k]
                np.testing.assert_allclose(centre, path.centres[k], atol=1e-14)

    def test_has_no_jump_at_curvature_zero(self):
        straight, nearly = (advance(np.zeros(3), c, 1.0) for c in (0.0, 1e-9))
        assert pose_error(nearly, straight) < 1.1e-9

    def test_samples_a_batch(self):
        path = ArcPath(np.zeros((5, 3)), np.full((5, 2), 1.5), np.full((5, 2), 0.4))
        s = np.linspace(0, 0.8, 7)[:, None]
        assert path.pose_at(s).shape == (7, 5, 3)
        assert path.curvature_at(s).shape == (7, 5)
        assert path[2].end.shape == (3,)
        assert path[path.total_length > 1].end.shape == (0, 3)

    def test_samples_every_path_at_its_own_distances(self):
        path = dubins.shortest(many_goals(6).reshape(2, 3, 3), 0.2)
        s = np.linspace(0, 1, 5) * path.total_length[..., None]
        poses, bends = path[:, :, None].pose_at(s), path[:, :, None].curvature_at(s)
        assert poses.shape == (2, 3, 5, 3)
        for i, j in np.ndindex(2, 3):
            np.testing.assert_array_equal(poses[i, j], path[i, j].pose_at(s[i, j]))
            np.testing.assert_array_equal(bends[i, j], path[i, j].curvature_at(s[i, j]))
        with pytest.raises(ValueError, match="None"):
            path.pose_at(s)

    def test_holds_its_ends(self):
        path = as_path([(1.0, 0.5), (0.0, 0.5)])
        assert pose_error(path.pose_at(-1.0), path.start) == 0
        assert pose_error(path.pose_at(9.0), path.end) < 1e-15
        np.testing.assert_array_equal(path.segment_at([-1.0, 0.4, 0.5, 9.0]), [0, 0, 1, 1])

    @pytest.mark.parametrize(
        "arguments",
        [
            ([0, 0, np.nan], [1.0], [1.0]),
            ([0, 0, 0], [np.inf], [1.0]),
            ([0, 0, 0], [1.0], [-1.0]),
            ([0, 0], [1.0], [1.0]),
            ([0, 0, 0], 1.0, 1.0),
            ([0, 0, 0], [], []),
            ([0, 0, 0], [1.0], ["far"]),
        ],
    )
    def test_refuses_what_is_no_path(self, arguments):
        with pytest.raises((ValueError, TypeError), match="must"):
            ArcPath(*arguments)


@given(goals, radii, angles)
@settings(max_examples=100, deadline=None)
def test_planned_paths_are_driven_along_minus_n(goal, radius, alpha1):
    paths = [dubins.shortest(goal, radius), two_arc.shortest(goal, radius)]
    if abs(np.sin(goal[2] / 2)) > 1e-3:
        paths.append(two_arc.plan(goal, alpha1))
    for path in paths:
        step = 1e-6 / max(1 / radius, np.abs(path.curvature).max())
        begin = np.cumsum(path.length) - path.length
        s = begin + np.linspace(0.01, 0.99, 9)[:, None] * path.length
        s = s[:, path.length > 1e-3 * path.total_length]
        pose, ahead = path.pose_at(s), path.pose_at(s + step)
        minus_n = np.stack([np.sin(pose[..., 2]), -np.cos(pose[..., 2])], axis=-1)
        driven = ((ahead - pose)[..., :2] * minus_n).sum(axis=-1)
        rounding = 1e-15 * max(1.0, path.total_length)
        np.testing.assert_allclose(driven, step, rtol=1e-5, atol=rounding)


class TestTwoArc:
    @given(goals, angles)
    @settings(max_examples=100, deadline=None)
    def test_plan_ends_on_the_goal(self, goal, alpha1):
        if abs(np.sin(goal[2] / 2)) < 1e-3:
            return
        path = two_arc.plan(goal, alpha1)
        assert pose_error(path.end, goal) < 1.1e-9 * max(1.0, path.total_length)
        assert (np.abs(path.turn) < 2 * np.pi).all()

    @given(goals, radii)
    @settings(max_examples=100, deadline=None)
    def test_shortest_ends_on_the_goal_and_keeps_the_radius(self, goal, radius):
        path = two_arc.shortest(goal, radius)
        assert pose_error(path.end, goal) < 1.1e-9 * max(1.0, path.total_length)
        if two_arc.feasible(path, radius):
            turning = np.abs(path.turn) > 1e-9
            assert (np.abs(path.curvature[turning]) * radius <= 1 + 1e-9).all()

    def test_only_near_goals_are_infeasible(self):
        goal = many_goals(20_000)
        infeasible = ~two_arc.feasible(two_arc.shortest(goal, 0.2), 0.2)
        assert 0.01 < infeasible.mean() < 0.025
        assert np.hypot(*goal[infeasible, :2].T).max() < 0.4

    def test_no_scanned_first_turn_is_shorter(self):
        goal, radius = many_goals(300, seed=1), 0.2
        scan = two_arc.plan(goal[:, None], np.linspace(-np.pi, np.pi, 3001)[1:-1])
        allowed = two_arc.feasible(scan, radius)
        scanned = np.where(allowed, scan.total_length, np.inf).min(axis=1)
        best = two_arc.shortest(goal, radius)
        found = np.where(two_arc.feasible(best, radius), best.total_length, np.inf)
        assert (found <= scanned * (1 + 1e-9)).all()

    @given(st.lists(st.tuples(curvatures, lengths), min_size=2, max_size=2))
    @settings(max_examples=100, deadline=None)
    def test_no_two_allowed_arcs_are_shorter(self, segments):
        path = as_path(segments)
        if (np.abs(path.turn) < 2 * np.pi - 1e-6).all():
            best = two_arc.shortest(path.end, 0.2)
            assert two_arc.feasible(best, 0.2)
            assert best.total_length <= path.total_length * (1 + 1e-9) + 1e-9

    def test_plan_agrees_with_the_centres_of_eq_13(self):
        goal, alpha1 = many_goals(1000, seed=5), np.random.default_rng(6).uniform(-3, 3, 1000)
        x, y, heading = goal.T
        alpha2 = heading - alpha1
        c1x = -(x * np.cos(alpha1 + alpha2 / 2) + y * np.sin(alpha1 + alpha2 / 2)) / (
            2 * np.sin(alpha1 / 2) * np.sin(heading / 2)
        )
        turned = y * np.cos(heading) - x * np.sin(heading)
        c2x = (x * np.cos(alpha1 / 2) + np.sin(alpha1 / 2) * turned) / (
            2 * np.sin(alpha2 / 2) * np.sin(heading / 2)
        )
        c2y = np.cos(alpha1 / 2) * (x * np.cos(heading / 2) + y * np.sin(heading / 2))
        rho2 = (x * np.cos(alpha1 / 2) + y * np.sin(alpha1 / 2)) / (
            2 * np.sin(alpha2 / 2) * np.sin(heading / 2)
        )
        path = two_arc.plan(goal, alpha1)
        scale = 1e-9 * (1 + path.total_length[:, None, None])
        centres = np.stack([c1x, 0 * c1x, c2x, c2y / np.sin(alpha2 / 2)], -1).reshape(-1, 2, 2)
        assert (np.abs(path.centres - centres) < scale).all()
        np.testing.assert_allclose(1 / path.curvature, np.stack([c1x, rho2], -1), rtol=1e-8)

    @given(goals, radii, angles, scales)
    @settings(max_examples=100, deadline=None)
    def test_scales(self, goal, radius, alpha1, scale):
        larger = np.array(goal) * [scale, scale, 1.0]
        pairs = [(two_arc.shortest(goal, radius), two_arc.shortest(larger, radius * scale))]
        if abs(np.sin(goal[2] / 2)) > 1e-3:
            pairs.append((two_arc.plan(goal, alpha1), two_arc.plan(larger, alpha1)))
        for path, image in pairs:
            if two_arc.feasible(path, radius) and np.hypot(*goal[:2]) > 1e-6:
                assert two_arc.feasible(image, radius * scale)
                rtol = 1e-9 * max(1.0, path.total_length)
                np.testing.assert_allclose(image.total_length / scale, path.total_length, rtol)

    def test_plan_is_as_good_as_the_candidate_it_is_given(self):
        goal = many_goals(1000, seed=2)
        best = two_arc.shortest(goal, 0.1)
        again = two_arc.plan(goal, best.turn[:, 0])
        np.testing.assert_allclose(again.length, best.length, rtol=1e-6, atol=1e-9)

    def test_never_shorter_than_dubins(self):
        goal = many_goals(20_000, seed=3)
        path = two_arc.shortest(goal, 0.2)
        allowed = two_arc.feasible(path, 0.2)
        shortest = dubins.length(goal, 0.2)
        assert (path.total_length >= shortest * (1 - 1e-9))[allowed].all()

    @given(goals, angles, radii)
    @settings(max_examples=80, deadline=None)
    def test_mirror_image(self, goal, alpha1, radius):
        mirrored = np.array(goal) * MIRROR
        pairs = [(two_arc.shortest(goal, radius), two_arc.shortest(mirrored, radius))]
        if abs(np.sin(goal[2] / 2)) > 1e-3:
            pairs.append((two_arc.plan(goal, alpha1), two_arc.plan(mirrored, -alpha1)))
        for path, image in pairs:
            if two_arc.feasible(path, radius):
                assert two_arc.feasible(image, radius)
                # Nearly backward goals amplify rounding errors by the length of the path.
                rtol = 1e-9 * max(1.0, path.total_length)
                np.testing.assert_allclose(image.total_length, path.total_length, rtol, atol=1e-9)

    @pytest.mark.parametrize("alpha1", [0.0, 0.3, 2 * np.pi])
    @pytest.mark.parametrize("x", [-0.5, 0.5])
    def test_straight_limits(self, alpha1, x):
        path = two_arc.plan((x, -1.0, 0.3), alpha1)
        assert pose_error(path.end, (x, -1.0, 0.3)) < 1e-15 * path.total_length + 2e-9
        assert two_arc.feasible(path, 0.2) == (path.total_length < 100)
        nearby = two_arc.plan((x, -1.0, 0.3), alpha1 + 1e-7)
        if path.total_length < 100:
            np.testing.assert_allclose(nearby.total_length, path.total_length, rtol=1e-5)

    def test_unchanged_heading_fixes_the_first_turn(self):
        goal = (0.5, -1.0, 0.0)
        path = two_arc.plan(goal, 2 * np.arctan2(0.5, 1.0))
        assert pose_error(path.end, goal) < 1e-12
        np.testing.assert_allclose(1 / path.curvature, [0.625, -0.625])
        with pytest.raises(ValueError, match="alpha1"):
            two_arc.plan(goal, 1.0)

    def test_straight_ahead_and_straight_behind(self):
        ahead = two_arc.shortest((0.0, -1.0, 0.0), 0.2)
        np.testing.assert_allclose(ahead.total_length, 1.0)
        assert not ahead.curvature.any()
        behind = two_arc.shortest((0.0, 1.0, 0.0), 0.2)
        assert not two_arc.feasible(behind, 0.2)

    def test_one_arc_goal_takes_one_arc(self):
        for side in (-1, 1):
            path = two_arc.shortest((side * 0.2, -0.2, side * np.pi / 2), 0.2)
            np.testing.assert_allclose(path.total_length, 0.1 * np.pi)

    def test_goal_at_the_start_pose_is_a_path_of_length_zero(self):
        for path in (two_arc.shortest(np.zeros(3), 0.2), two_arc.plan(np.zeros(3), 0.0)):
            assert path.total_length == 0
            assert pose_error(path.end, np.zeros(3)) == 0

    def test_turn_on_the_spot_is_planned_but_not_feasible(self):
        goal = (0.0, 0.0, 1.0)
        for path in (two_arc.shortest(goal, 0.2), two_arc.plan(goal, 0.4)):
            assert pose_error(path.end, goal) < 1e-11
            assert not two_arc.feasible(path, 0.2)

    def test_feasibility_of_a_batch(self):
        path = two_arc.plan([[0.55, -0.95, 0.1], [0.6, 0.8, -2.0]], 1.0)
        np.testing.assert_array_equal(two_arc.feasible(path, 0.2), [True, False])
        np.testing.assert_array_equal(two_arc.feasible(path, 0.177), [True, True])

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="goal"):
            two_arc.plan((np.nan, 0.0, 0.0), 1.0)
        with pytest.raises(ValueError, match="alpha1"):
            two_arc.plan((1.0, 0.0, 0.5), np.inf)
        with pytest.raises(ValueError, match="shape"):
            two_arc.shortest((1.0, 0.0), 0.2)
        with pytest.raises(ValueError, match="min_radius"):
            two_arc.shortest((1.0, 0.0, 0.5), 0.0)
