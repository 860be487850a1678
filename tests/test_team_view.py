"""What a boat sees depends neither on the world's frame nor on the order of the boats."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import decide, known_at_start, turned

from asv_env import make_params
from asv_env.polygons import complex_corners, contains, gap_to, outline
from asv_env.types import Sensed
from baselines.allocation import AllocationPolicy
from baselines.learned.seen import MIRROR, Seen
from baselines.learned.team_view import TeamView, outline_points
from baselines.mirror import mirror_image

EXACT = {"rtol": 0, "atol": 1e-5}
PARAMS = make_params("transport", 4)
PILLARS = make_params("transport", 6, obstacles="pillars")


def look(sensed: Sensed, params=PARAMS) -> Seen:
    """What boats see when an episode begins."""
    fresh = np.ones(len(sensed.side), dtype=bool)
    return TeamView(params).observe(sensed, None, fresh)[0]


def same_sight(one: Seen, other: Seen):
    """Asserts that both are equal, but for the order of their sets."""
    np.testing.assert_allclose(one.own, other.own, **EXACT)
    for a, b in zip(one[1:], other[1:], strict=True):
        # Sums of functions of the items do not depend on their order.
        np.testing.assert_allclose(a.sum(axis=2), b.sum(axis=2), rtol=0, atol=1e-4)
        np.testing.assert_allclose((a**2).sum(axis=2), (b**2).sum(axis=2), rtol=0, atol=1e-3)


def test_nothing_depends_on_the_frame_of_the_world():
    sensed = known_at_start(PARAMS, range(8))
    motion = turned(sensed.estimate, 2.0, 0.3 - 0.8j)
    goal = turned(sensed.goal, 2.0, 0.3 - 0.8j)
    same_sight(look(sensed), look(replace(sensed, estimate=motion, measured=motion, goal=goal)))


def test_a_symmetric_hull_has_no_bow():
    """A plank whose heading is called the opposite one, as that of its goal, is the same plank."""
    sensed = known_at_start(PARAMS, range(8))
    motion, goal = sensed.estimate.copy(), sensed.goal.copy()
    motion[:, 0, 2] = (motion[:, 0, 2] + 2 * np.pi) % (2 * np.pi) - np.pi
    goal[:, 2] = (goal[:, 2] + 2 * np.pi) % (2 * np.pi) - np.pi
    same_sight(look(sensed), look(replace(sensed, estimate=motion, measured=motion, goal=goal)))


def test_in_the_mirror_image_numbers_change_their_signs_alone():
    params = make_params("transport", 4, obstacles="pillars")  # Their formation is symmetric.
    sensed = known_at_start(params, range(8))
    seen = look(sensed, params)
    mirrored = Seen(*(part * sign for part, sign in zip(seen, MIRROR, strict=True)))
    same_sight(mirrored, look(mirror_image(sensed, -np.ones(8)), params))


def test_boats_are_seen_by_what_they_do_and_not_by_their_numbers():
    sensed, order = known_at_start(PILLARS, range(8)), np.array([3, 0, 5, 1, 4, 2])
    boats = {
        name: getattr(sensed, name)[:, order]
        for name in ("slot", "occupied", "working", "touching")
    }
    motion = sensed.estimate[:, [0, *order + 1]]
    other = replace(sensed, estimate=motion, measured=motion, **boats)
    seen = Seen(*(part[:, order] for part in look(sensed, PILLARS)))
    same_sight(seen, look(other, PILLARS))


def test_contact_points_are_those_of_the_policy_that_is_imitated():
    params = make_params("transport", 6, "failure")
    sensed = known_at_start(params, range(8))
    sensed.working[::2, 1] = False
    _, memory = decide(AllocationPolicy(params), sensed)
    _, view = TeamView(params).observe(sensed, None, np.ones(8, dtype=bool))
    np.testing.assert_array_equal(view.place, memory.place)
    np.testing.assert_array_equal(view.inward, memory.inward)


def test_without_a_formation_contact_points_are_slots():
    params = make_params("approach", 4)
    sensed = known_at_start(params, range(4))
    _, view = TeamView(params).observe(sensed, None, np.ones(4, dtype=bool))
    np.testing.assert_array_equal(view.place, sensed.slot)
    assert not view.allocated.any()


def test_a_world_of_another_scale_looks_the_same():
    small, large = PARAMS, make_params("transport", 4, scale=3.0)
    same_sight(look(known_at_start(small, range(4))), look(known_at_start(large, range(4)), large))


@pytest.mark.parametrize("vessel", ["plank", "disc", "T"])
def test_points_of_the_outline_lie_on_it_with_normals_that_point_outwards(vessel):
    params = make_params("transport", vessel=vessel)
    point, normal = outline_points(params)
    corners = complex_corners(params.vessel.corners)
    assert max(abs(gap_to(outline(corners), complex(one))) for one in point) < 1e-9
    assert all(contains(corners, complex(one)) for one in point - 1e-4 * normal)
    assert not any(contains(corners, complex(one)) for one in point + 1e-4 * normal)


def test_thruster_actions_are_refused():
    with pytest.raises(ValueError, match="make it with action_mode='tracking'"):
        TeamView(make_params(action_mode="thrusters"))
