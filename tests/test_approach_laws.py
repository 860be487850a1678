"""The spiral, its length and speed, the Brownian agents, and the steering law."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_strategies import angles, scales
from scipy.integrate import quad, solve_ivp

from baselines.paper import braitenberg, brownian, spiral


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
    @settings(max_examples=80, deadline=None)
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
        return brownian.simulate(1.0, alpha0, speed, 1.0, rng=rng, dt=0.01, **options)

    @given(angles, st.floats(0.3, 3.0), st.sampled_from([0, 1]))
    @settings(max_examples=50, deadline=None)
    def test_only_the_normalised_drift_has_constant_speed(self, alpha, sigma, turn):
        dr, dalpha = brownian.drift(0.7, alpha, turn, 0.2, sigma, unit_speed=True)
        np.testing.assert_allclose(np.hypot(dr, 0.7 * dalpha), 0.2)
        dr, dalpha = brownian.drift(0.7, alpha, turn, 0.2, sigma)
        np.testing.assert_allclose(abs(dr) + 0.7 * abs(dalpha), 0.2)
        image_dr, image_dalpha = brownian.drift(0.7, np.pi - alpha, 1 - turn, 0.2, sigma)
        np.testing.assert_allclose([image_dr, -image_dalpha], [dr, dalpha], atol=1e-14)
        larger_dr, larger_dalpha = brownian.drift(7.0, alpha, turn, 2.0, sigma)
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
    def test_mirror_image_swaps_the_wheels(self, alpha, phi, turn, heading):
        left, right = braitenberg.wheel_speeds(heading, alpha, turn, phi, 0.1, 0.05)
        image = braitenberg.wheel_speeds(np.pi - heading, np.pi - alpha, 1 - turn, phi, 0.1, 0.05)
        np.testing.assert_allclose(image, [right, left], atol=1e-14)

    @given(angles, st.floats(0.0, np.pi / 2), st.sampled_from([0, 1]), st.floats(-1.5, 1.5))
    @settings(max_examples=100, deadline=None)
    def test_wheels_turn_towards_the_desired_heading(self, alpha, phi, turn, error):
        heading = braitenberg.desired_heading(alpha, turn, phi) + error
        left, right = braitenberg.wheel_speeds(heading, alpha, turn, phi, 0.1, 0.05)
        np.testing.assert_allclose(right - left, -0.1 * np.sin(error), atol=1e-12)

    @pytest.mark.parametrize(("turn", "sine"), [(0, -1), (1, 1)])
    def test_turn_directions_are_clockwise_and_counter_clockwise(self, turn, sine):
        heading = braitenberg.desired_heading(0.0, turn, np.pi / 2)
        np.testing.assert_allclose(np.sin(heading), sine)

    def test_turn_direction_is_that_of_the_shorter_path_and_updated_above(self):
        np.testing.assert_array_equal(braitenberg.turn_direction([-1.0, 1.0], 0.0), [0, 1])
        positions = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
        turns = braitenberg.updated_turn_direction(positions, [0.0, 0.0], [1, 0, 1, 0])
        np.testing.assert_array_equal(turns, [0, 1, 1, 0])

    def test_refuses_bad_input(self):
        with pytest.raises(ValueError, match="beta"):
            braitenberg.wheel_speeds(0.0, 0.0, 1, 0.5, 0.1, -0.05)
        with pytest.raises(ValueError, match="direction"):
            braitenberg.desired_heading(0.0, 2, 0.5)
