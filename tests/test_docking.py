"""The states of a team that docks, and how boats keep clear of each other."""

from types import SimpleNamespace

import numpy as np
import pytest

from asv_env import make_params
from baselines.scripted import GraspGains
from baselines.scripted.docking import Docking, GraspMemory
from baselines.scripted.grasp_controller import STARBOARD, avoidance_velocity

PARAMS, GAINS = make_params("approach", 4), GraspGains()
WAYPOINTS = np.array([[-0.2 + 0.3j, -0.1 + 0.3j, 0.1 + 0.3j, 0.2 + 0.3j]])


def descends(boat, *, descending, astern=0, working=4, seconds=0.0):
    """Whether a team at positions (1, 4) descends next, so long after its boats were due."""
    memory = GraspMemory.empty(1, 4)
    memory.descending[:] = descending
    memory.astern[0, :astern] = True
    sensed = SimpleNamespace(
        working=np.arange(4)[None] < working, tick=np.array([seconds * PARAMS.clock.control])
    )
    relations = SimpleNamespace(boat=boat, alignment=np.ones((1, 4), complex))
    Docking(PARAMS, GAINS).update_team(relations, WAYPOINTS, sensed, memory)
    return bool(memory.descending[0])


def test_team_descends_once_all_wait_at_their_waypoints():
    late = WAYPOINTS + np.array([0, 0, 0, 0.5])
    assert descends(WAYPOINTS, descending=False)
    assert not descends(late, descending=False)
    assert descends(late, descending=False, working=3)
    assert descends(late, descending=False, seconds=GAINS.patience + 1)


@pytest.mark.parametrize(
    ("astern", "working", "expected"), [(1, 4, True), (2, 4, False), (2, 3, True)]
)
def test_team_gathers_again_when_too_many_miss_their_slots(astern, working, expected):
    low = WAYPOINTS - 0.08j + 0.05
    assert descends(low, descending=True, astern=astern, working=working) == expected


@pytest.mark.parametrize(("working", "expected"), [(4, False), (3, True)])
def test_team_gathers_again_when_boats_jam_at_the_hull(working, expected):
    """It does not where a boat has failed, which may lie in the way for ever."""
    jammed = WAYPOINTS - 0.1j + np.array([0.0, 0.1, -0.1, 0.0])
    patient = GAINS.descent_patience - 1
    assert descends(jammed, descending=True, working=working, seconds=patient)
    late = GAINS.descent_patience + 1
    assert descends(jammed, descending=True, working=working, seconds=late) == expected


@pytest.mark.parametrize(("descending", "patience"), [(False, 10), (True, 30)])
def test_team_is_late_when_its_patience_ends(descending, patience):
    memory, hz = GraspMemory.empty(1, 4), PARAMS.clock.control
    memory.descending[:], memory.due[:] = descending, 50
    docking = Docking(PARAMS, GAINS)
    for tick, late in [(50 + patience * hz, False), (51 + patience * hz, True)]:
        assert docking.late(SimpleNamespace(tick=np.array([tick])), memory) == late


def test_boats_avoid_those_within_reach_to_starboard():
    boat = np.array([[0.0, 0.05, 1.0j]])
    seen = np.ones((1, 3), dtype=bool)
    velocity = avoidance_velocity(boat, seen, reach=0.2, speed=0.08)[0]
    np.testing.assert_allclose(velocity[0], -0.08 * 0.75 * STARBOARD)
    np.testing.assert_allclose(velocity, [velocity[0], -velocity[0], 0.0], atol=1e-15)
    seen[0, 1] = False
    unaware = avoidance_velocity(boat, seen, reach=0.2, speed=0.08)[0]
    np.testing.assert_allclose(unaware, [0.0, -velocity[0], 0.0], atol=1e-15)
