"""Straight legs among obstacles, checked by dense sampling of the box that is driven."""

from itertools import pairwise

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.geometry import direction, wrap
from baselines.allocation import AllocationPolicy
from baselines.allocation.straight_paths import Box, Room, Times, search
from baselines.rollout import runner

BOX = Box(along=0.2, aside=0.25, reach=float(np.hypot(0.2, 0.25)), axis=np.pi / 2)
TIMES, ROOM = Times(0.08, 0.3, 9.0), Room(0.01, 0.05, 0.16, 0.8)
FAR = np.array([[9.0, 9.0, 9.0, 9.0, 0.1]])

places = st.floats(-1.2, 1.2)
angles = st.floats(-np.pi, np.pi)
pillars = st.lists(st.tuples(places, places, st.floats(0.04, 0.1)), min_size=3, max_size=6)


def box_clearance(position, heading, rows):
    """Distance (n,) of the box at positions (n,) and a heading to the nearest of round pillars."""
    local = (rows[:, 0] + 1j * rows[:, 1] - position[:, None]) * direction(-heading - BOX.axis)
    beyond = np.maximum(np.abs(local.real) - BOX.along, 0.0)
    beside = np.maximum(np.abs(local.imag) - BOX.aside, 0.0)
    return (np.hypot(beyond, beside) - rows[:, 4]).min(axis=1)


def circle_clearance(position, rows):
    return np.min(np.abs(rows[:, 0] + 1j * rows[:, 1] - position) - rows[:, 4]) - BOX.reach


@settings(deadline=None, max_examples=40)
@given(places, places, angles, pillars)
def test_legs_are_straight_and_clear_and_meet_where_the_vessel_can_turn(x, y, heading, circles):
    goal = np.array([x, y, heading])
    rows = FAR
    for a, b, radius in circles:  # Those that leave room to turn at start and goal.
        row = np.array([[a, b, a, b, radius]])
        if min(circle_clearance(end, row) for end in (0j, complex(x, y))) > ROOM.least:
            rows = np.concatenate([rows, row])
    path = search(np.zeros(3), goal, BOX, TIMES, ROOM, rows)
    assume(len(path.point))
    np.testing.assert_allclose(path.point[-1], complex(x, y))
    corners = np.concatenate([[0j], path.point])
    for leg, (begin, end) in enumerate(pairwise(corners)):
        if abs(end - begin) > 0.0:
            across = (end - begin) / direction(path.heading[leg] + BOX.axis)
            assert abs(across.imag) < 1e-9
        way = begin + (end - begin) * np.linspace(0.0, 1.0, 100)
        assert box_clearance(way, path.heading[leg], rows).min() >= ROOM.least - 1e-9
    headings = np.concatenate([[0.0], path.heading, [heading]])
    for place, turn in zip(corners, np.abs(wrap(np.diff(headings))), strict=True):
        assert turn < 1e-5 or circle_clearance(place, rows) >= ROOM.least - 1e-9


@settings(deadline=None, max_examples=40)
@given(places, places, angles)
def test_in_open_water_the_path_is_straight_and_takes_the_least_turning(x, y, heading):
    assume(abs(complex(x, y)) > 0.01)
    path = search(np.zeros(3), np.array([x, y, heading]), BOX, TIMES, ROOM, FAR)
    assert len(path.point) == 1
    ahead = np.arctan2(y, x) - BOX.axis
    turning = [np.abs(wrap(way)) + np.abs(wrap(heading - way)) for way in (ahead, ahead + np.pi)]
    taken = np.abs(wrap(path.heading[0])) + np.abs(wrap(heading - path.heading[0]))
    np.testing.assert_allclose(taken, min(turning), atol=1e-9)


def test_there_is_no_path_out_of_a_ring_of_walls():
    corners = 0.8 * np.exp(0.5j * np.pi * np.arange(5))
    rows = [[a.real, a.imag, b.real, b.imag, 0.02] for a, b in pairwise(corners)]
    path = search(np.zeros(3), np.array([2.0, 0.0, 0.0]), BOX, TIMES, ROOM, np.array(rows))
    assert not len(path.point)


def test_the_policy_delivers_among_pillars_and_decides_in_each_world_alone():
    params = make_params("transport", obstacles="pillars", delivery="holding")
    together = runner.run(AllocationPolicy, params, range(6), 6)
    episodes = sorted((log.episode for log in together), key=lambda row: row.seed)
    assert sum(row.success for row in episodes) >= 5
    (alone,) = runner.run(AllocationPolicy, params, range(4, 5), 1)
    assert alone.episode == episodes[4]
