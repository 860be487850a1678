"""Dubins paths end on their goals, and no path of bounded curvature is shorter."""

import numpy as np
import pytest
from hypothesis import given, settings
from path_strategies import MIRROR, arcs, as_path, goals, many_goals, pose_error, radii, scales

from baselines.paper import dubins
from baselines.paper.arcs import ArcPath


class TestDubins:
    @given(goals, radii)
    @settings(max_examples=100, deadline=None)
    def test_ends_on_the_goal_and_keeps_the_radius(self, goal, radius):
        path = dubins.shortest(goal, radius)
        assert pose_error(path.end, goal) < 1e-9
        assert (np.abs(path.curvature) * radius <= 1 + 1e-12).all()

    @given(arcs)
    @settings(max_examples=100, deadline=None)
    def test_no_path_of_bounded_curvature_is_shorter(self, segments):
        path = as_path(segments)
        assert dubins.length(path.end, 0.2) <= path.total_length + 1e-8

    @given(goals, radii)
    @settings(max_examples=80, deadline=None)
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
