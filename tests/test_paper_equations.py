"""The paper's equations against values computed two independent ways (lengths in cm, as filed)."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from baselines.paper import braitenberg, brownian, dubins, pushing, spiral, two_arc

VECTORS = json.loads((Path(__file__).parent / "data" / "paper_vectors.json").read_text())


def column(family, *names):
    """Columns of one family of vectors as arrays."""
    rows = VECTORS[family] if isinstance(VECTORS[family], list) else VECTORS[family]["rows"]
    columns = [np.array([row[name] for row in rows]) for name in names]
    return columns[0] if len(columns) == 1 else columns


def assert_close(actual, expected, rtol=1e-9):
    np.testing.assert_allclose(actual, expected, rtol=rtol, atol=1e-12)


def goals(family):
    return np.stack(column(family, "x_f", "y_f", "h_f"), axis=-1).astype(float)


def test_angular_distance():
    a, b, expected = column("arcmin", "theta1", "theta2", "arcmin")
    assert_close(spiral.angular_distance(a, b), expected)


def test_bearing_offset_is_eq_2():
    alpha, sigma, phi = column("phi_sigma", "alpha", "sigma", "phi")
    assert_close(spiral.bearing_offset(alpha, sigma), phi)


def test_exact_bearing_offset():
    family = "phi_star_exact_spiral_steering"
    alpha, sigma, phi = column(family, "alpha", "sigma", "phi_star")
    assert_close(spiral.exact_bearing_offset(alpha, sigma), phi)


def test_wheel_speeds_are_the_corrected_eq_3():
    family = "wheel_speeds_corrected_eq3"
    heading, alpha, turn, sigma = column(family, "h", "alpha", "D", "sigma")
    speed, beta, left, right = column(family, "S1", "beta", "V_L", "V_R")
    phi = spiral.bearing_offset(alpha, sigma)
    assert_close(braitenberg.wheel_speeds(heading, alpha, turn, phi, speed, beta), [left, right])


def test_arc_length_is_eq_6():
    r0, theta0, sigma, length = column("spiral_length_eq6", "r0", "theta0", "sigma", "L")
    assert_close(spiral.arc_length(r0, theta0, sigma), length)


def test_asymptotic_radius_is_eq_5():
    r0, theta0, sigma, r_pi = column("r_pi_eq5", "r0", "theta0", "sigma", "r_pi")
    assert_close(spiral.asymptotic_radius(r0, theta0, sigma), r_pi)


def test_approach_speed_is_eq_7():
    x0, y0, tx, ty, sigma = column("approach_speed_eq7", "x0", "y0", "Tx", "Ty", "sigma")
    time, r0, theta0 = column("approach_speed_eq7", "T_goal", "r0", "theta0")
    turn, length, speed = column("approach_speed_eq7", "D", "L", "S1")
    alpha = np.arctan2(y0 - ty, x0 - tx)
    assert_close(np.hypot(x0 - tx, y0 - ty), r0)
    assert_close(spiral.angular_distance(alpha, np.pi / 2), theta0)
    assert_close(braitenberg.turn_direction(x0, tx), turn)
    own_length = spiral.arc_length(np.hypot(x0 - tx, y0 - ty), theta0, sigma)
    assert_close(own_length, length)
    assert_close(spiral.approach_speed(own_length, time), speed)


@pytest.mark.parametrize("row", VECTORS["eq8_arrival"]["rows"])
def test_brownian_drift_arrives_as_eq_8(row):
    def per_radius(_, state):
        """Rates of ln r, theta and t in a time that runs as dt / r, which takes no end."""
        r = np.exp(state[0])
        dr, dalpha = brownian.drift(r, np.pi / 2 - state[1], 1, 1.0, row["sigma"])
        return dr, -dalpha * r, r

    start = (0.0, row["theta0"], 0.0)
    solution = solve_ivp(per_radius, (0, 60), start, method="DOP853", rtol=1e-12, atol=1e-13)
    arrival = solution.y[2, -1]
    assert_close(arrival, row["T_arrival_times_S_over_r0"])
    in_time = arrival / spiral.arc_length(1.0, row["theta0"], row["sigma"])
    assert_close(in_time, row["T_arrival_over_Tgoal"])


def test_two_arc_plan_is_the_corrected_eqs_9_to_15():
    family = "two_arc_eq13"
    path = two_arc.plan(goals(family), column(family, "alpha1"))
    assert_close(1 / path.curvature, np.stack(column(family, "rho1", "rho2"), -1))
    assert_close(path.turn, np.stack(column(family, "A1", "A2"), -1))
    raw = np.stack(column(family, "alpha1", "alpha2_raw"), -1)
    corrected = np.stack(column(family, "corrected1", "corrected2"), -1)
    assert_close(np.exp(1j * (path.turn - raw)), np.ones(raw.shape))
    np.testing.assert_array_equal(path.turn * raw < 0, corrected)
    assert_close(path.length, np.stack(column(family, "length1", "length2"), -1))
    assert_close(path.total_length, column(family, "total_length"))
    assert_close(path.joints[:, 1, :2], column(family, "switch"))
    assert_close(path.centres, np.stack(column(family, "C1", "C2"), 1))
    feasible = two_arc.feasible(path, column(family, "min_radius"))
    np.testing.assert_array_equal(feasible, column(family, "feasible"))


@pytest.mark.parametrize("row", VECTORS["two_arc_optimal_alpha1"]["rows"])
def test_shortest_two_arc_path(row):
    path = two_arc.shortest([row["x_f"], row["y_f"], row["h_f"]], row["min_radius"])
    assert two_arc.feasible(path, row["min_radius"]) == row["feasible"]
    if row["feasible"]:
        assert_close(1 / path.curvature, [row["rho1"], row["rho2"]])
        assert_close(path.turn, [row["A1"], row["A2"]])
        assert_close(np.exp(1j * (path.turn[0] - row["alpha1"])), 1.0)
        assert_close(path.total_length, row["total_length"])


def test_dubins_length():
    family = "dubins_length_R20"
    assert_close(dubins.length(goals(family), 20.0), column(family, "length"), rtol=1e-6)


def test_pushing_speed_is_eq_16():
    family = "pushing_speed_eq16"
    position, rho = column(family, "P", "rho")
    robot, mean_speed, centre, point = column(family, "robot_in_vessel_frame", "S2", "C", "X")
    speed, normal = column(family, "V", "V_normal")
    assert_close(pushing.speeds(point, centre, position, mean_speed), speed)
    assert_close(pushing.normal_speeds(robot[:, 0], 1 / rho, mean_speed), normal)
