"""The approach by ideal kinematics: boats that turn at K times the sine of the heading error."""

from dataclasses import dataclass

import numpy as np
import pytest

from asv_env.geometry import wrap
from baselines import braitenberg, spiral

LENGTH, WIDTH = 0.40, 0.15
BOAT_LENGTH, BOAT_WIDTH = 0.12, 0.065
CLEARANCE, SIGMA = 0.06, 1.0
STOP_RADIUS = 0.02
HULL = (LENGTH, WIDTH, CLEARANCE, SIGMA)
END = LENGTH / 2 + BOAT_WIDTH / 2 + 0.005
SIDE = WIDTH / 2 + BOAT_LENGTH / 2
SLOTS = np.array([(-END, 0.0), (-LENGTH / 6, SIDE), (LENGTH / 6, SIDE), (END, 0.0)])


def hull_distance(position):
    """Distance of points from the vessel's rectangle, negative inside."""
    beyond = np.abs(position) - [LENGTH / 2, WIDTH / 2]
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return outside + np.minimum(beyond.max(axis=-1), 0.0)


def random_starts(count, seed, room=0.0):
    """Starts outside the inflated hull, half of them within 0.6 m of its centre."""
    rng = np.random.default_rng(seed)
    reach = np.where(rng.random((20 * count, 1)) < 0.5, 0.6, 1.5)
    position = reach * rng.uniform(-1, 1, (20 * count, 2))
    position = position[hull_distance(position) > CLEARANCE + room][:count]
    heading = rng.uniform(-np.pi, np.pi, count)
    return position, heading, SLOTS[rng.integers(0, len(SLOTS), count)]


@dataclass
class Voyage:
    """What became of each boat: arrays (boats,)."""

    arrival: np.ndarray
    travelled: np.ndarray
    planned: np.ndarray
    gap: np.ndarray
    heading: np.ndarray


def sail(start, heading, slot, *, gain=4.0, dt=0.05, speed=0.03, goal_time=None, **options):
    """Sail every boat to its slot, at one speed or at speeds that end at goal_time."""
    position, heading = start.copy(), heading.copy()
    planned = braitenberg.approach_heading(position, slot, *HULL, **options)[1]
    arrival, travelled = np.full(len(start), np.inf), np.zeros(len(start))
    gap = np.full(len(start), np.inf)
    for time in dt * np.arange(int((goal_time or 20 / speed) * 1.5 / dt)):
        away = np.isinf(arrival)
        if not away.any():
            break
        desired, left = braitenberg.approach_heading(position, slot, *HULL, **options)
        if goal_time:
            mean = planned / goal_time
            pace = spiral.approach_speed(left, goal_time - time, STOP_RADIUS, 2 * mean, 0.2 * mean)
        else:
            pace = speed
        turn = -gain * dt * np.sin(heading - desired) * away
        course, step = heading + turn / 2, pace * dt * away
        position += (step * [np.cos(course), np.sin(course)]).T
        heading, travelled = heading + turn, travelled + step
        gap = np.where(away, np.minimum(gap, hull_distance(position)), gap)
        arrived = np.linalg.norm(position - slot, axis=-1) <= STOP_RADIUS
        arrival = np.where(away & arrived, time + dt, arrival)
    return Voyage(arrival, travelled, planned, gap, heading)


def test_2000_boats_arrive_together_and_none_through_the_hull():
    start, heading, slot = random_starts(2000, seed=1)
    voyage = sail(start, heading, slot, goal_time=80.0)
    assert np.isfinite(voyage.arrival).all()
    assert voyage.gap.min() > 0.03
    under_way = voyage.planned > 0.15
    assert voyage.arrival[under_way].std() < 0.02 * 80.0
    assert np.ptp(voyage.arrival[under_way]) < 0.02 * 80.0
    assert under_way.mean() > 0.98


@pytest.mark.parametrize("tangent", [False, True])
def test_boats_arrive_bow_first_at_constant_speed(tangent):
    start, heading, slot = random_starts(600, seed=2, room=0.03)
    voyage = sail(start, heading, slot, gain=6.0, speed=0.05, tangent=tangent)
    assert np.isfinite(voyage.arrival).all()
    assert voyage.gap.min() > 0.0
    far = voyage.planned > 0.3
    assert np.abs(wrap(voyage.heading + np.pi / 2))[far].max() < 0.15


@pytest.mark.parametrize("tangent", [False, True])
def test_path_length_is_exact_for_a_boat_that_follows_the_heading(tangent):
    start, _, slot = random_starts(200, seed=3)
    heading, _ = braitenberg.approach_heading(start, slot, *HULL, tangent=tangent)
    voyage = sail(start, heading, slot, gain=12.0, dt=0.03, speed=0.05, tangent=tangent)
    left = voyage.planned - voyage.travelled
    assert (np.abs(left - STOP_RADIUS) < 0.02 + 0.02 * voyage.planned).all()
    assert voyage.gap.min() > 0.035


@pytest.mark.parametrize("sigma", [0.5, 1.0, 3.0])
def test_heading_is_the_mirror_image_of_the_mirrored_boat(sigma):
    start, _, slot = random_starts(2000, seed=4)
    for options in ({}, {"tangent": True}, {"direction": 1}):
        image = {**options, "direction": 0} if "direction" in options else options
        mirror = [-1.0, 1.0]
        heading, left = braitenberg.approach_heading(start, slot, *HULL[:3], sigma, **options)
        other, image_left = braitenberg.approach_heading(
            start * mirror, slot * mirror, *HULL[:3], sigma, **image
        )
        np.testing.assert_allclose(wrap(np.pi - heading - other), 0.0, atol=1e-9)
        np.testing.assert_allclose(left, image_left, rtol=1e-9)


def test_boat_beside_the_end_descends_straight():
    height = np.linspace(0.0, 0.3, 31)
    for x in (-END, END):
        position = np.column_stack([np.full_like(height, x), height])
        heading, left = braitenberg.approach_heading(position, (x, 0.0), *HULL)
        np.testing.assert_allclose(heading, -np.pi / 2)
        np.testing.assert_allclose(left, height, atol=1e-12)


def test_heading_is_continuous_along_the_way():
    """Between neighbouring points of a track that crosses every stage, but for the sense."""
    for slot in SLOTS[2:]:
        position, track = np.array([0.5, -0.6]), []
        while np.linalg.norm(position - slot) > 0.002:
            heading, _ = braitenberg.approach_heading(position, slot, *HULL)
            track.append(float(heading))
            position = position + 0.002 * np.array([np.cos(heading), np.sin(heading)])
        assert np.abs(wrap(np.diff(track))).max() < 0.3


def test_kept_direction_is_obeyed():
    position, slot = np.array([0.05, -0.8]), SLOTS[2]
    assert braitenberg.approach_direction(position, slot, *HULL) == 1
    for sense, towards in ((0, -1), (1, 1)):
        heading, _ = braitenberg.approach_heading(position, slot, *HULL, direction=sense)
        assert np.sign(np.cos(heading)) == towards


def test_batch_axes_are_free():
    position = random_starts(24, seed=5)[0].reshape(6, 4, 2)
    heading, left = braitenberg.approach_heading(position, SLOTS, *HULL)
    assert heading.shape == left.shape == (6, 4)
    one, _ = braitenberg.approach_heading(position[2, 3], SLOTS[3], *HULL)
    assert one == heading[2, 3]
    sizes = np.linspace(0.3, 0.5, 6)[:, None]
    assert braitenberg.approach_heading(position, SLOTS, sizes, 0.15, 0.06, 1.0)[0].shape == (6, 4)


def test_refuses_bad_input():
    for name, hull in (
        ("vessel_length", (0.0, WIDTH, CLEARANCE, SIGMA)),
        ("clearance", (LENGTH, WIDTH, -0.1, SIGMA)),
        ("sigma", (LENGTH, WIDTH, CLEARANCE, 0.0)),
    ):
        with pytest.raises(ValueError, match=name):
            braitenberg.approach_heading((1.0, 0.0), SLOTS[0], *hull)
    with pytest.raises(ValueError, match="position"):
        braitenberg.approach_heading((np.nan, 0.0), SLOTS[0], *HULL)
    with pytest.raises(ValueError, match="direction"):
        braitenberg.approach_heading((1.0, 0.0), SLOTS[0], *HULL, direction=-1)
