"""The speeds of the boats that push are those of the vessel's rigid motion."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_strategies import as_path, curvatures, goals, scales

from baselines.paper import pushing
from baselines.paper.arcs import advance


class TestPushing:
    @given(curvatures, goals, st.floats(-0.3, 0.3), st.floats(-0.2, 0.2), st.floats(0.01, 0.3))
    @settings(max_examples=80, deadline=None)
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
        with pytest.raises(ValueError, match="curvature"):
            pushing.normal_speeds(0.1, np.inf, 0.1)
