"""Properties of the paths, of the speeds along them and of the spiral."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from asv_env.geometry import wrap
from baselines.paper import braitenberg, brownian, dubins, pushing, spiral, two_arc
from baselines.paper.arcs import ArcPath, advance

coordinates = st.floats(-2.0, 2.0)
angles = st.floats(-np.pi, np.pi)
goals = st.tuples(coordinates, coordinates, angles)
radii = st.floats(0.05, 0.6)
curvatures = st.sampled_from([-5.0, 0.0, 5.0]) | st.floats(-5.0, 5.0)
lengths = st.just(0.0) | st.floats(0.0, 2.0)
scales = st.sampled_from([1e-3, 1e-2, 0.5, 100.0, 1e4])
arcs = st.lists(st.tuples(curvatures, lengths), min_size=1, max_size=4)
MIRROR = np.array([-1.0, 1.0, -1.0])


def many_goals(count, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform([-1.5, -1.5, -np.pi], [1.5, 1.5, np.pi], (count, 3))


def pose_error(pose, goal):
    """Largest deviation in x, y and heading."""
    deviation = np.asarray(pose) - np.asarray(goal)
    return np.max(
        np.abs([*np.moveaxis(deviation[..., :2], -1, 0), wrap(deviation[..., 2])]), axis=0
    )


def as_path(segments, start=(0.0, 0.0, 0.0)):
    curvature, length = np.transpose(segments)
    return ArcPath(start, curvature, length)


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
    @settings(max_examples=300, deadline=None)
    def test_plan_ends_on_the_goal(self, goal, alpha1):
        if abs(np.sin(goal[2] / 2)) < 1e-3:
            return
        path = two_arc.plan(goal, alpha1)
        assert pose_error(path.end, goal) < 1.1e-9 * max(1.0, path.total_length)
        assert (np.abs(path.turn) < 2 * np.pi).all()

    @given(goals, radii)
    @settings(max_examples=300, deadline=None)
    def test_shortest_ends_on_the_goal_and_keeps_the_radius(self, goal, radius):
        path = two_arc.shortest(goal, radius)
        assert pose_error(path.end, goal) < 1.1e-9 * max(1.0, path.total_length)
        if two_arc.feasible(path, radius):
            turning = np.abs(path.turn) > 1e-9
            assert (np.abs(path.curvature[turning]) * radius <= 1 + 1e-9).all()
            assert two_arc.reason(path, radius) == ""
        else:
            assert two_arc.reason(path, radius).startswith("segment")

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
    @settings(max_examples=300, deadline=None)
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
    @settings(max_examples=200, deadline=None)
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
        assert "backwards" in two_arc.reason(behind, 0.2)

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
            assert "radius" in two_arc.reason(path, 0.2)

    def test_reasons_of_a_batch(self):
        path = two_arc.plan([[0.55, -0.95, 0.1], [0.6, 0.8, -2.0]], 1.0)
        reasons = two_arc.reason(path, 0.2)
        assert reasons[0] == ""
        assert "0.1772 m" in reasons[1]
        assert "0.2 m" in reasons[1]

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="goal"):
            two_arc.plan((np.nan, 0.0, 0.0), 1.0)
        with pytest.raises(ValueError, match="alpha1"):
            two_arc.plan((1.0, 0.0, 0.5), np.inf)
        with pytest.raises(ValueError, match="shape"):
            two_arc.shortest((1.0, 0.0), 0.2)
        with pytest.raises(ValueError, match="min_radius"):
            two_arc.shortest((1.0, 0.0, 0.5), 0.0)


class TestDubins:
    @given(goals, radii)
    @settings(max_examples=300, deadline=None)
    def test_ends_on_the_goal_and_keeps_the_radius(self, goal, radius):
        path = dubins.shortest(goal, radius)
        assert pose_error(path.end, goal) < 1e-9
        assert (np.abs(path.curvature) * radius <= 1 + 1e-12).all()

    @given(arcs)
    @settings(max_examples=300, deadline=None)
    def test_no_path_of_bounded_curvature_is_shorter(self, segments):
        path = as_path(segments)
        assert dubins.length(path.end, 0.2) <= path.total_length + 1e-8

    @given(goals, radii)
    @settings(max_examples=200, deadline=None)
    def test_mirror_image_and_way_back_are_as_long(self, goal, radius):
        x, y, heading = goal
        forth = dubins.length(goal, radius)
        cos, sin = np.cos(heading), np.sin(heading)
        # Both ends turned about: the way back from the goal, seen from the goal.
        back = (x * cos + y * sin, -x * sin + y * cos, -heading)
        np.testing.assert_allclose(dubins.length(back, radius), forth, rtol=1e-7, atol=1e-8)
        image = dubins.length(np.array(goal) * MIRROR, radius)
        np.testing.assert_allclose(image, forth, rtol=1e-9, atol=1e-9)

    def test_finds_curves_of_two_turns(self):
        """The last goals of a straight between opposite turns: rounding must not lose them."""
        turns = np.random.default_rng(7).uniform(0.05, 1.5, (1000, 2))
        path = ArcPath(np.zeros(3), [5.0, -5.0], 0.2 * turns)
        np.testing.assert_allclose(dubins.length(path.end, 0.2), path.total_length)

    def test_does_not_take_a_rounding_error_for_a_full_turn(self):
        rng = np.random.default_rng(8)
        length = rng.uniform(0, 1, (5000, 3)) * 10 ** rng.uniform(-8, 0, (5000, 1))
        length[rng.random((5000, 3)) < 0.3] = 0
        for bends in ([5.0, 0.0, 5.0], [-5.0, 0.0, 5.0], [5.0, -5.0, 5.0]):
            path = ArcPath(np.zeros(3), bends, length)
            found = dubins.shortest(path.end, 0.2)
            assert (found.total_length <= path.total_length + 1e-9).all()
            assert pose_error(found.end, path.end).max() < 1e-12

    @given(goals, radii, scales)
    @settings(max_examples=100, deadline=None)
    def test_scales(self, goal, radius, scale):
        larger = dubins.length(np.array(goal) * [scale, scale, 1.0], radius * scale)
        np.testing.assert_allclose(larger / scale, dubins.length(goal, radius), atol=1e-9)

    def test_three_turns_win_near_the_start(self):
        path = dubins.shortest(many_goals(20_000, seed=4) * [0.3, 0.3, 1], 0.2)
        assert (path.curvature[:, 1] != 0).mean() > 0.1

    def test_easy_goals(self):
        assert dubins.length([[0.0, 0.0, 0.0], [0.0, 0.0, 2 * np.pi]], 0.2).tolist() == [0.0, 0.0]
        for goal, length in (
            ((0.0, -1.0, 0.0), 1.0),
            ((0.4, 0.0, np.pi), 0.2 * np.pi),
            ((-0.2, -0.2, -np.pi / 2), 0.1 * np.pi),
        ):
            np.testing.assert_allclose(dubins.length(goal, 0.2), length, atol=1e-9)

    def test_broadcasts_goals_and_radii(self):
        path = dubins.shortest(many_goals(6).reshape(2, 3, 3), np.array([0.1, 0.2, 0.3]))
        assert path.total_length.shape == (2, 3)

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="min_radius"):
            dubins.shortest((1.0, 0.0, 0.0), -0.2)
        with pytest.raises(ValueError, match="goal"):
            dubins.shortest((np.inf, 0.0, 0.0), 0.2)


class TestPushing:
    @given(curvatures, goals, st.floats(-0.3, 0.3), st.floats(-0.2, 0.2), st.floats(0.01, 0.3))
    @settings(max_examples=200, deadline=None)
    def test_speeds_are_those_of_the_rigid_motion(self, curvature, start, u, w, mean_speed):
        if abs(curvature) < 1e-3:
            curvature = 0.0
        path = as_path([(curvature, 1.0)], start)

        def point(time):
            x, y, heading = advance(np.array(start), curvature, mean_speed * time)
            cos, sin = np.cos(heading), np.sin(heading)
            return np.array([x + u * cos - w * sin, y + u * sin + w * cos])

        velocity = (point(1e-5) - point(-1e-5)) / 2e-5
        args = (point(0.0), path.centres[0], path.start[:2])
        speed = pushing.speeds(*args, mean_speed)
        np.testing.assert_allclose(speed, np.hypot(*velocity), atol=1e-7)
        course = pushing.directions(point(0.0), path.start, curvature)
        if speed > 1e-3:
            np.testing.assert_allclose(speed * np.cos(course), velocity[0], atol=1e-7)
            np.testing.assert_allclose(speed * np.sin(course), velocity[1], atol=1e-7)
        normal = pushing.normal_speeds(u, curvature, mean_speed)
        minus_n = np.array([np.sin(start[2]), -np.cos(start[2])])
        np.testing.assert_allclose(normal, velocity @ minus_n, atol=1e-7)

    @given(curvatures, st.floats(-0.3, 0.3), st.floats(0.0, 0.2))
    @settings(max_examples=50, deadline=None)
    def test_mirror_image(self, curvature, u, w):
        speed, image = (pushing.normal_speeds(s * u, s * curvature, 0.1) for s in (1, -1))
        assert speed == image
        rho = 1 / curvature if curvature else np.inf
        speed, image = (pushing.speeds((s * u, w), (s * rho, 0), (0, 0), 0.1) for s in (1, -1))
        assert speed == image
        course, image = (
            pushing.directions((s * u, w), (0.0, 0.0, 0.0), s * curvature) for s in (1, -1)
        )
        np.testing.assert_allclose(wrap(np.pi - image - course), 0.0, atol=1e-9)

    def test_straight_is_the_limit_of_large_circles(self):
        points = np.array([[0.2, 0.1], [-0.2, 0.1]])
        straight = pushing.speeds(points, [np.inf, np.inf], [0.0, 0.0], 0.1)
        np.testing.assert_array_equal(straight, [0.1, 0.1])
        large = pushing.speeds(points, [1e9, 0.0], [0.0, 0.0], 0.1)
        np.testing.assert_allclose(large, straight, rtol=1e-8)

    @given(curvatures, st.floats(-0.3, 0.3), st.floats(0.0, 0.2), scales)
    @settings(max_examples=50, deadline=None)
    def test_scales(self, curvature, u, w, scale):
        rho = 1 / curvature if curvature else np.inf
        speed, larger = (
            pushing.speeds((s * u, s * w), (s * rho, 0.0), (0.0, 0.0), 0.1) for s in (1, scale)
        )
        np.testing.assert_allclose(larger, speed)
        normal, larger = (pushing.normal_speeds(s * u, curvature / s, 0.1) for s in (1, scale))
        np.testing.assert_allclose(larger, normal, atol=1e-15)

    def test_boats_pull_nowhere_if_and_only_if_the_radius_is_half_the_length(self):
        u = np.linspace(-0.2, 0.2, 9)
        assert (pushing.normal_speeds(u, 1 / np.array([[0.2], [-0.2], [0.3]]), 0.1) >= 0).all()
        assert (pushing.normal_speeds(u, 1 / np.array([[0.19], [-0.19]]), 0.1) < 0).any(-1).all()

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="radius"):
            pushing.speeds([0.1, 0.1], [0.0, 0.0], [0.0, 0.0], 0.1)
        with pytest.raises(ValueError, match="points"):
            pushing.speeds([0.1, 0.1, 0.0], [1.0, 0.0], [0.0, 0.0], 0.1)
        with pytest.raises(ValueError, match="centre"):
            pushing.speeds([0.1, 0.1], [np.nan, 0.0], [0.0, 0.0], 0.1)
        with pytest.raises(ValueError, match="vessel_pose"):
            pushing.directions([0.1, 0.1], [0.0, 0.0], 1.0)
        with pytest.raises(ValueError, match="curvature"):
            pushing.normal_speeds(0.1, np.inf, 0.1)


def spiral_length_by_quadrature(theta0, sigma):
    """Eq (6) for r0 = 1: integral of sqrt(r^2 + r'^2), split where the integrand bends."""
    share = -np.expm1(-theta0 / sigma)

    def speed(theta):
        return np.hypot(np.expm1(-theta / sigma), np.exp(-theta / sigma) / sigma) / share

    bends = [b for b in (sigma / 10, sigma, 5 * sigma, 20 * sigma) if b < theta0]
    edges = [0.0, *bends, theta0]
    return sum(quad(speed, a, b, epsabs=0, epsrel=1e-12, limit=200)[0] for a, b in pairwise(edges))


class TestSpiral:
    @given(st.floats(-3, 6), st.floats(-6, np.log10(2 * np.pi)))
    @settings(max_examples=200, deadline=None)
    def test_arc_length_agrees_with_quadrature(self, log_sigma, log_theta0):
        sigma, theta0 = 10**log_sigma, 10**log_theta0
        expected = spiral_length_by_quadrature(theta0, sigma)
        np.testing.assert_allclose(spiral.arc_length(1.0, theta0, sigma), expected, rtol=1e-11)

    def test_arc_length_has_finite_limits(self):
        sigma = [1e-300, 1e-100, 1e-5, 1.0, 1e300]
        np.testing.assert_array_equal(spiral.arc_length(2.0, 0.0, sigma), 2.0)
        np.testing.assert_allclose(spiral.arc_length(1.0, 2.0, 1e-300), 3.0)
        archimedean = (np.hypot(1, 2) + np.arcsinh(2) / 2) / 2
        np.testing.assert_allclose(spiral.arc_length(1.0, 2.0, 1e300), archimedean)
        theta0 = 10.0 ** np.arange(-300, -4)
        near = spiral.arc_length(1.0, theta0, np.array([[0.1], [1.0], [1e6]]))
        np.testing.assert_allclose(near - 1, np.broadcast_to(theta0**2 / 6, near.shape), atol=1e-14)

    @given(st.floats(0.0, np.pi), st.floats(0.1, 10.0), scales)
    @settings(max_examples=50, deadline=None)
    def test_scales(self, theta0, sigma, scale):
        for function in (spiral.arc_length, spiral.asymptotic_radius):
            larger = function(scale * 0.7, theta0, sigma)
            np.testing.assert_allclose(larger, scale * function(0.7, theta0, sigma))

    @given(angles, st.floats(0.2, 5.0))
    @settings(max_examples=100, deadline=None)
    def test_exact_offset_follows_the_spiral(self, alpha, sigma):
        theta = spiral.angular_distance(alpha, np.pi / 2)
        slope = np.exp(-theta / sigma) / sigma
        expected = np.arctan2(-np.expm1(-theta / sigma), slope)
        np.testing.assert_allclose(spiral.exact_bearing_offset(alpha, sigma), expected, atol=1e-14)

    @given(angles, st.floats(0.2, 5.0))
    @settings(max_examples=50, deadline=None)
    def test_mirror_image(self, alpha, sigma):
        for offset in (spiral.bearing_offset, spiral.exact_bearing_offset):
            np.testing.assert_allclose(
                offset(np.pi - alpha, sigma), offset(alpha, sigma), atol=1e-14
            )

    def test_asymptotic_radius_of_a_straight_is_infinite(self):
        np.testing.assert_array_equal(spiral.asymptotic_radius([1.0, 0.0], 0.0, 1.0), [np.inf, 0.0])

    def test_approach_speed_keeps_its_bounds(self):
        speed = spiral.approach_speed(
            [1.0, 0.01, 9.0, 1.0], [10.0, 10.0, 10.0, -3.0],
            stop_radius=0.02, max_speed=0.2, min_speed=0.01,
        )  # fmt: skip
        np.testing.assert_allclose(speed, [0.098, 0.01, 0.2, 0.2])

    @pytest.mark.parametrize("sigma", [0.0, -1.0, np.nan, np.inf])
    def test_refuses_a_sigma_that_is_not_positive(self, sigma):
        for function in (spiral.bearing_offset, spiral.exact_bearing_offset):
            with pytest.raises(ValueError, match="sigma"):
                function(0.5, sigma)
        for function in (spiral.arc_length, spiral.asymptotic_radius):
            with pytest.raises(ValueError, match="sigma"):
                function(1.0, 0.5, sigma)

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="r0"):
            spiral.arc_length(-1.0, 0.5, 1.0)
        with pytest.raises(ValueError, match="theta0"):
            spiral.arc_length(1.0, np.nan, 1.0)
        with pytest.raises(TypeError, match="sigma"):
            spiral.bearing_offset(1.0, "wide")
        with pytest.raises(ValueError, match="length"):
            spiral.approach_speed(-1.0, 1.0)
        with pytest.raises(ValueError, match="max_speed"):
            spiral.approach_speed(1.0, 1.0, max_speed=np.nan)
        with pytest.raises(ValueError, match="min_time"):
            spiral.approach_speed(1.0, 1.0, min_time=0.0)
        with pytest.raises(ValueError, match="exceeds"):
            spiral.approach_speed(1.0, 1.0, max_speed=0.1, min_speed=0.2)


class TestBrownian:
    def swarm(self, **options):
        rng = np.random.default_rng(5)
        alpha0 = np.array([-1.4, 0.0, 1.2, 2.0, 4.0])
        speed = spiral.arc_length(1.0, spiral.angular_distance(alpha0, np.pi / 2), 1.0) / 10
        return brownian.simulate(1.0, alpha0, speed, 1.0, rng=rng, dt=0.004, **options)

    @given(angles, st.floats(0.3, 3.0), st.sampled_from([0, 1]))
    @settings(max_examples=50, deadline=None)
    def test_only_the_normalised_drift_has_constant_speed(self, alpha, sigma, sense):
        dr, dalpha = brownian.drift(0.7, alpha, sense, 0.2, sigma, unit_speed=True)
        np.testing.assert_allclose(np.hypot(dr, 0.7 * dalpha), 0.2)
        dr, dalpha = brownian.drift(0.7, alpha, sense, 0.2, sigma)
        np.testing.assert_allclose(abs(dr) + 0.7 * abs(dalpha), 0.2)
        image_dr, image_dalpha = brownian.drift(0.7, np.pi - alpha, 1 - sense, 0.2, sigma)
        np.testing.assert_allclose([image_dr, -image_dalpha], [dr, dalpha], atol=1e-14)
        larger_dr, larger_dalpha = brownian.drift(7.0, alpha, sense, 2.0, sigma)
        np.testing.assert_allclose([larger_dr, larger_dalpha], [10 * dr, dalpha], atol=1e-14)

    def test_unit_speed_arrives_on_time_for_sigma_1(self):
        times, r, _ = self.swarm(duration=12.0, unit_speed=True)
        arrival = times[np.argmax(r <= 0.01, axis=0)]
        np.testing.assert_allclose(arrival, 10.0, atol=0.15)
        _, r, _ = self.swarm(duration=9.5)
        assert (r[-1] > 0.1).any()

    def test_follows_the_orbit_without_noise(self):
        _, r, alpha = self.swarm(duration=5.0)
        theta = spiral.angular_distance(alpha, np.pi / 2)
        np.testing.assert_allclose(r, np.expm1(-theta) / np.expm1(-theta[0]), atol=2e-3)

    @pytest.mark.parametrize("noise", [{"noise_r": 0.01}, {"noise_alpha": 0.02}])
    def test_noise_comes_from_the_generator_and_swarm_still_arrives(self, noise):
        _, r, alpha = self.swarm(duration=20.0, **noise)
        _, again, _ = self.swarm(duration=20.0, **noise)
        np.testing.assert_array_equal(r, again)
        assert (r[-1] <= 0.01).all()
        assert np.isfinite(alpha).all()

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="r must"):
            brownian.drift(0.0, 0.0, 1, 0.1, 1.0)
        with pytest.raises(ValueError, match="direction"):
            brownian.drift(1.0, 0.0, 2, 0.1, 1.0)
        with pytest.raises(ValueError, match="noise"):
            self.swarm(duration=1.0, noise_r=-1.0)
        with pytest.raises(ValueError, match="duration"):
            self.swarm(duration=0.0)


class TestSteeringLaw:
    @pytest.mark.parametrize("gain", [5.0, 20.0])
    def test_pure_rotation_drifts_outwards(self, gain):
        """r^2 = r0^2 + 2 S^2 t / K after the heading has settled; a unit track, so K = 2 beta."""
        speed = 0.1

        def rates(_, pose):
            x, y, heading = pose
            alpha = np.arctan2(y, x)
            left, right = braitenberg.wheel_speeds(heading, alpha, 1, np.pi / 2, speed, gain / 2)
            return speed * np.cos(heading), speed * np.sin(heading), right - left

        solution = solve_ivp(
            rates, (0, 100), (1.0, 0.0, np.pi / 2), rtol=1e-9, atol=1e-9, t_eval=[20, 100]
        )
        growth = np.diff((solution.y[:2] ** 2).sum(axis=0))
        np.testing.assert_allclose(growth, 2 * speed**2 * 80 / gain, rtol=2e-3)

    @given(angles, st.floats(0.0, np.pi / 2), st.sampled_from([0, 1]), angles)
    @settings(max_examples=100, deadline=None)
    def test_mirror_image_swaps_the_wheels(self, alpha, phi, sense, heading):
        left, right = braitenberg.wheel_speeds(heading, alpha, sense, phi, 0.1, 0.05)
        image = braitenberg.wheel_speeds(np.pi - heading, np.pi - alpha, 1 - sense, phi, 0.1, 0.05)
        np.testing.assert_allclose(image, [right, left], atol=1e-14)

    @given(angles, st.floats(0.0, np.pi / 2), st.sampled_from([0, 1]), st.floats(-1.5, 1.5))
    @settings(max_examples=100, deadline=None)
    def test_wheels_turn_towards_the_desired_heading(self, alpha, phi, sense, error):
        heading = braitenberg.desired_heading(alpha, sense, phi) + error
        left, right = braitenberg.wheel_speeds(heading, alpha, sense, phi, 0.1, 0.05)
        np.testing.assert_allclose(right - left, -0.1 * np.sin(error), atol=1e-12)

    @pytest.mark.parametrize(("sense", "turn"), [(0, -1), (1, 1)])
    def test_senses_are_clockwise_and_counter_clockwise(self, sense, turn):
        heading = braitenberg.desired_heading(0.0, sense, np.pi / 2)
        np.testing.assert_allclose(np.sin(heading), turn)

    def test_sense_is_the_shorter_way_and_signed_above(self):
        np.testing.assert_array_equal(braitenberg.turn_direction([-1.0, 1.0], 0.0), [0, 1])
        positions = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
        senses = braitenberg.updated_turn_direction(positions, [0.0, 0.0], [1, 0, 1, 0])
        np.testing.assert_array_equal(senses, [0, 1, 1, 0])

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="beta"):
            braitenberg.wheel_speeds(0.0, 0.0, 1, 0.5, 0.1, -0.05)
        with pytest.raises(ValueError, match="direction"):
            braitenberg.desired_heading(0.0, 2, 0.5)


CALLS = {
    spiral.angular_distance: (0.3, 2.0),
    spiral.bearing_offset: (0.3, 1.0),
    spiral.exact_bearing_offset: (0.3, 1.0),
    spiral.asymptotic_radius: (0.5, 1.0, 1.0),
    spiral.arc_length: (0.5, 1.0, 1.0),
    spiral.approach_speed: (0.5, 10.0, 0.02, 0.2, 0.01, 0.5),
    brownian.drift: (0.5, 0.3, 1, 0.1, 1.0),
    braitenberg.desired_heading: (0.3, 1, 0.4),
    braitenberg.wheel_speeds: (0.3, 0.2, 1, 0.4, 0.1, 0.05),
    pushing.normal_speeds: (0.1, 2.0, 0.1),
}
GOAL, CENTRE, POINT = [0.5, -1.0, 0.3], [1.0, 0.0], [0.1, 0.2]
ROW_CALLS = {
    dubins.length: (GOAL, 0.2),
    pushing.speeds: (POINT, CENTRE, [0.0, 0.0], 0.1),
    pushing.directions: (POINT, GOAL, 0.5),
    lambda goal, alpha1: two_arc.plan(goal, alpha1).total_length: (GOAL, 0.5),
    lambda goal, radius: two_arc.shortest(goal, radius).total_length: (GOAL, 0.2),
    lambda start, bend, way, s: ArcPath(start, bend, way).curvature_at(s): (
        GOAL,
        [1.0],
        [1.0],
        0.5,
    ),
}


def results(function, arguments):
    """Results of a call, always as a tuple."""
    result = function(*arguments)
    return result if isinstance(result, tuple) else (result,)


@pytest.mark.parametrize(("function", "arguments"), [*CALLS.items(), *ROW_CALLS.items()])
def test_leading_axes_are_free(function, arguments):
    """Numbers give numbers; arrays and lists, of one argument or of all, give arrays."""
    single = results(function, arguments)
    assert all(isinstance(number, float) for number in single)
    for lead in ((4,), (2, 3), (0,), (1, 1, 1)):
        full = [np.broadcast_to(a, lead + np.shape(a)) for a in arguments]
        mixes = [full, [a.tolist() for a in full]] if 0 not in lead else [full]
        mixes += [
            [full[i] if i == k else a for i, a in enumerate(arguments)]
            for k in range(len(arguments))
        ]
        for mix in mixes:
            for array, number in zip(results(function, mix), single, strict=True):
                assert array.dtype == np.float64
                np.testing.assert_array_equal(array, np.full(lead, number), strict=True)


@pytest.mark.parametrize(("function", "arguments"), [*CALLS.items(), *ROW_CALLS.items()])
@pytest.mark.parametrize("bad", [np.nan, np.inf, "far"])
def test_bad_numbers_are_refused_and_named(function, arguments, bad):
    for k in range(len(arguments)):
        if bad == np.inf and (function, k) in {(spiral.approach_speed, 3), (pushing.speeds, 1)}:
            continue
        spoilt = [np.full(np.shape(a), bad)[()] if i == k else a for i, a in enumerate(arguments)]
        with pytest.raises((ValueError, TypeError), match=r"must|exceeds"):
            function(*spoilt)


def test_results_of_a_path_are_of_the_expected_types():
    path = two_arc.shortest(GOAL, 0.2)
    assert isinstance(path.total_length, float)
    assert isinstance(path.segment_at(0.3), np.integer)
    assert isinstance(two_arc.feasible(path, 0.2), np.bool_)
    assert (
        path.end.shape == path.pose_at(0.3).shape == path.pose_at(path.total_length).shape == (3,)
    )
    assert (path.joints.shape, path.centres.shape) == ((3, 3), (2, 2))
    assert dubins.shortest(GOAL, 0.2).length.shape == (3,)
