"""Formations: where teams push, and that they can exert what a direct path takes."""

import numpy as np
import pytest
from scipy.optimize import linprog

from asv_env import make_params, polygons
from asv_env.presets import SHAPES
from baselines.allocation.contact_points import columns, effort, formation, gyration, needed

HULLS = [name for name in SHAPES if name != "disc"]


def formed(team, hull="plank", **options):
    """Formation, columns (n, 3), and the hulls of vessel and boat."""
    vessel, boat = make_params("push", team, vessel=hull, **options).hulls()
    found = formation(vessel, boat, team)
    point = found.place + found.inward * boat.length / 2
    return found, columns(point, found.inward, gyration(vessel)), vessel, boat


def reachable(column, wrench):
    """Whether non-negative forces exert a wrench, by linear programming."""
    return linprog(np.ones(len(column)), A_eq=column.T, b_eq=wrench).status == 0


@pytest.mark.parametrize("hull", HULLS)
@pytest.mark.parametrize("team", [4, 7])
def test_the_wrench_cone_contains_drive_brake_and_turns(hull, team):
    found, column, _, _ = formed(team, hull)
    assert found.spans
    for wrench in needed(np.asarray(found.axis))[2:]:
        assert reachable(column, wrench)
    for side in (1, -1):  # Along the axis, with whatever goes beside it.
        pushes = side * (found.inward * np.conj(found.axis)).real
        assert pushes.max() > 0.2


def test_boats_on_a_plank_face_each_other_in_pairs():
    found, _, vessel, boat = formed(4)
    assert abs(found.axis.real) < 1e-12
    np.testing.assert_allclose(
        sorted(np.abs(found.place.imag)), [(vessel.width + boat.length) / 2] * 4
    )
    assert (np.sign(found.place.imag) == -found.inward.imag).all()
    assert sorted(np.sign(found.place.real) * 2 + np.sign(found.place.imag)) == [-3, -1, 1, 3]


@pytest.mark.parametrize("hull", HULLS)
@pytest.mark.parametrize("team", [3, 6, 12])
def test_bows_touch_the_hull_and_boats_have_room(hull, team):
    found, _, vessel, boat = formed(team, hull)
    outline = polygons.outline(polygons.complex_corners(vessel.corners))
    bow = found.place + found.inward * boat.length / 2
    assert max(abs(polygons.to_outline(outline, point)) for point in bow) < 1e-9
    assert min(polygons.gap_to(outline, point) for point in found.place) > 0.99 * boat.length / 2
    gaps = np.abs(found.place[:, None] - found.place) + np.eye(team)
    assert gaps.min() >= 1.2 * boat.width or team > 6  # Small hulls have not room for all teams.


@pytest.mark.parametrize(("team", "hull"), [(2, "plank"), (6, "disc")])
def test_two_boats_and_round_hulls_have_no_such_formation(team, hull):
    assert not formed(team, hull)[0].spans


def test_effort_is_the_least_sum_of_squares():
    column = np.array([[0.0, 1.0, 0.5], [0.0, 1.0, -0.5], [0.0, -1.0, 0.0]])
    wrench = np.array([[0.0, 2.0, 0.0], [0.0, -1.0, 0.0]])
    all_push = np.ones((2, 3), dtype=bool)
    np.testing.assert_allclose(
        effort(np.stack([column] * 2), wrench, all_push), [2.0, 1.0], rtol=0.02
    )
    without = all_push & np.array([True, True, False])
    assert effort(np.stack([column] * 2), wrench, without)[1] > 50  # Nobody is left to brake.
