"""Every law takes numbers and arrays of any shape, and refuses bad numbers by name."""

import numpy as np
import pytest

from baselines.paper import braitenberg, brownian, dubins, pushing, spiral, two_arc
from baselines.paper.arcs import ArcPath

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
    lambda goal, alpha1: two_arc.plan(goal, alpha1).total_length: (GOAL, 0.5),
    lambda goal, radius: two_arc.shortest(goal, radius).total_length: (GOAL, 0.2),
    lambda start, bend, length, s: ArcPath(start, bend, length).curvature_at(s): (
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
