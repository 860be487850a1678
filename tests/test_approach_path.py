"""The approach by ideal kinematics: boats that turn at K times the sine of the heading error."""

from dataclasses import dataclass

import numpy as np
import pytest

from baselines.paper import spiral
from baselines.scripted.approach_path import ApproachPath

LENGTH, WIDTH = 0.40, 0.15
BOAT_LENGTH, BOAT_WIDTH = 0.12, 0.065
CLEARANCE, SIGMA = 0.06, 1.0
STOP_RADIUS = 0.02
END = LENGTH / 2 + BOAT_WIDTH / 2 + 0.005
SIDE = WIDTH / 2 + BOAT_LENGTH / 2
SLOTS = np.array([-END, -LENGTH / 6 + 1j * SIDE, LENGTH / 6 + 1j * SIDE, END])
PATH = ApproachPath(LENGTH, WIDTH, CLEARANCE, END, SIGMA)
CIRCLE = 0.4  # encloses the one that clears the hull


def hull_distance(boat):
    """Distance of points from the vessel's rectangle, negative inside."""
    x, y = np.abs(boat.real) - LENGTH / 2, np.abs(boat.imag) - WIDTH / 2
    return np.hypot(np.maximum(x, 0), np.maximum(y, 0)) + np.minimum(np.maximum(x, y), 0)


def random_positions(count, seed, room=0.03):
    """Initial positions outside the inflated hull, half of them within 0.6 m of its centre."""
    rng = np.random.default_rng(seed)
    reach = np.where(rng.random(20 * count) < 0.5, 0.6, 1.5)
    boat = reach * (rng.uniform(-1, 1, 20 * count) + 1j * rng.uniform(-1, 1, 20 * count))
    boat = boat[hull_distance(boat) > CLEARANCE + room][:count]
    bow = np.exp(1j * rng.uniform(-np.pi, np.pi, count))
    return boat, bow, SLOTS[rng.integers(0, len(SLOTS), count)]


@dataclass
class Voyage:
    """What became of each boat: arrays (boats,)."""

    arrival: np.ndarray
    travelled: np.ndarray
    planned: np.ndarray
    gap: np.ndarray
    bow: np.ndarray


def sail(start, bow, slot, *, gain=4.0, dt=0.05, speed=0.03, goal_time=None):
    """Sail every boat to its slot, at one speed or at speeds that end at goal_time."""
    boat, bow, around = start.copy(), bow.copy(), PATH.turn_direction(start, slot)
    planned = PATH.course(boat, slot, around)[1]
    arrival, travelled = np.full(len(start), np.inf), np.zeros(len(start))
    gap = np.full(len(start), np.inf)
    for time in dt * np.arange(int((goal_time or 20 / speed) * 1.5 / dt)):
        away = np.isinf(arrival)
        if not away.any():
            break
        course, left = PATH.course(boat, slot, around)
        if goal_time:
            mean = planned / goal_time
            left_time = max(goal_time - time, 0.0)
            pace = spiral.approach_speed(left, left_time, STOP_RADIUS, 2 * mean, 0.2 * mean)
        else:
            pace = speed
        turn = gain * dt * (course * bow.conj()).imag * away
        step = pace * dt * away
        boat = boat + step * bow * np.exp(0.5j * turn)
        bow, travelled = bow * np.exp(1j * turn), travelled + step
        gap = np.where(away, np.minimum(gap, hull_distance(boat)), gap)
        arrived = np.abs(boat - slot) <= STOP_RADIUS
        arrival = np.where(away & arrived, time + dt, arrival)
    return Voyage(arrival, travelled, planned, gap, bow)


def test_boats_arrive_together_and_none_through_the_hull():
    voyage = sail(*random_positions(500, seed=1), goal_time=80.0)
    assert np.isfinite(voyage.arrival).all()
    assert voyage.gap.min() > 0.0
    under_way = voyage.planned > 0.15
    assert voyage.arrival[under_way].std() < 0.02 * 80.0
    assert np.ptp(voyage.arrival[under_way]) < 0.02 * 80.0
    assert under_way.mean() > 0.98


def test_boats_arrive_bow_first_at_constant_speed():
    voyage = sail(*random_positions(300, seed=2), gain=6.0, speed=0.05)
    assert np.isfinite(voyage.arrival).all()
    assert voyage.gap.min() > 0.0
    far = voyage.planned > 0.3
    assert np.abs(np.angle(1j * voyage.bow))[far].max() < 0.15


def test_path_length_is_exact_for_a_boat_that_follows_the_course():
    start, _, slot = random_positions(200, seed=3, room=0.0)
    course, _ = PATH.course(start, slot, PATH.turn_direction(start, slot))
    voyage = sail(start, course, slot, gain=12.0, dt=0.03, speed=0.05)
    left = voyage.planned - voyage.travelled
    outside = np.abs(start) > CIRCLE
    assert (np.abs(left - STOP_RADIUS) < 0.02 + 0.02 * voyage.planned)[outside].all()
    assert voyage.gap.min() > 0.035


@pytest.mark.parametrize("sigma", [0.5, 1.0, 3.0])
def test_course_is_the_mirror_image_of_the_mirrored_boat(sigma):
    path = ApproachPath(LENGTH, WIDTH, CLEARANCE, END, sigma)
    start, _, slot = random_positions(2000, seed=4)
    around = path.turn_direction(start, slot)
    np.testing.assert_array_equal(path.turn_direction(-start.conj(), -slot.conj()), 1 - around)
    for chosen in (around, np.ones_like(around)):
        course, left = path.course(start, slot, chosen)
        image, image_left = path.course(-start.conj(), -slot.conj(), 1 - chosen)
        np.testing.assert_allclose(-course.conj(), image, atol=1e-9)
        np.testing.assert_allclose(left, image_left, rtol=1e-9)


def test_the_kept_way_round_is_the_shorter_one():
    start, _, slot = random_positions(2000, seed=6)
    kept = PATH.turn_direction(start, slot)
    shorter, longer = (PATH.course(start, slot, around)[1] for around in (kept, 1 - kept))
    assert (shorter <= longer).all()


def test_boat_beside_the_end_descends_straight():
    height = np.linspace(0.0, 0.3, 31)
    for x in (-END, END):
        course, left = PATH.course(x + 1j * height, np.full(31, x + 0j), np.ones(31, dtype=int))
        np.testing.assert_allclose(course, -1j, atol=1e-12)
        np.testing.assert_allclose(left, height, atol=1e-12)


def test_course_jumps_only_where_the_spiral_begins():
    """Along the path of a boat that follows it through every stage."""
    for slot in SLOTS[2:]:
        boat, courses = 0.5 - 0.6j, []
        around = PATH.turn_direction(np.array(boat), slot)
        while abs(boat - slot) > 0.002:
            course, _ = PATH.course(np.array(boat), slot, around)
            courses.append(complex(course))
            boat = boat + 0.002 * complex(course)
        jumps = np.abs(np.angle(np.array(courses[1:]) / courses[:-1]))
        assert jumps.max() < 1.0
        assert np.sum(jumps > 0.1) <= 1


def test_kept_sense_is_obeyed():
    boat, slot = np.array(0.05 - 0.8j), SLOTS[2]
    assert PATH.turn_direction(boat, slot) == 1
    for around, towards in ((0, -1), (1, 1)):
        course, _ = PATH.course(boat, slot, np.array(around))
        assert np.sign(course.real) == towards


def test_batch_axes_are_free():
    boat = random_positions(24, seed=5)[0].reshape(6, 4)
    around = PATH.turn_direction(boat, SLOTS)
    course, left = PATH.course(boat, SLOTS, around)
    assert course.shape == left.shape == around.shape == (6, 4)
    one, _ = PATH.course(boat[2, 3], SLOTS[3], around[2, 3])
    assert one == course[2, 3]


@pytest.mark.parametrize("name", ["length", "width", "clearance", "reach", "sigma"])
@pytest.mark.parametrize("value", [0.0, -0.1, np.nan])
def test_refuses_bad_sizes(name, value):
    sizes = {"length": 0.4, "width": 0.15, "clearance": 0.1, "reach": 0.2, "sigma": 1.0}
    with pytest.raises(ValueError, match=name):
        ApproachPath(**{**sizes, name: value})


def test_refuses_a_boat_nowhere():
    with pytest.raises(ValueError, match="finite"):
        PATH.course(np.array(complex(np.nan, 0.0)), SLOTS[0], np.array(1))
