"""The approach on the real physics: teams that grasp the vessel whatever disturbs them."""

from dataclasses import replace

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.tasks.formation import relate, slots
from baselines.rollout.loop import rollout
from baselines.scripted import GraspGains, ScriptedPolicy
from baselines.scripted.docking import GraspMemory
from baselines.scripted.grasp_controller import MAX_SIDESTEP, GraspController, sidestep
from baselines.scripted.observer import VesselMemory

GAINS = GraspGains()
HALF_TURN = np.pi / make_params().boat.full_yaw_rate
"""Time in which a boat turns round, s: boats that come late to their slots need no longer."""


def approach(params, seeds, seconds=None, share=1.0):
    """Simulation after the approach, and when each world was first grasped for a second, s.

    It ends after so many seconds, or else once a share of all is grasped or at the time limit.
    """
    simulation, hz = Simulation(params, len(seeds)), params.clock.control
    grasped, ticks = np.full(len(seeds), np.inf), int((seconds or params.task.time_limit) * hz) - 1
    for tick, _ in enumerate(rollout(simulation, ScriptedPolicy(params).act, seeds, ticks)):
        first = np.isinf(grasped) & (simulation.state.occupied_ticks >= hz)
        grasped[first] = (tick + 1) / hz
        if seconds is None and np.isfinite(grasped).mean() >= share:
            break
    return simulation, grasped


def lasting(scenario, num_boats=4, **options):
    """Parameters of an approach in which no world ends before its time."""
    params = make_params("approach", num_boats, scenario, arena=1e3, **options)
    return replace(params, task=replace(params.task, hold_time=params.task.time_limit))


@pytest.mark.parametrize(
    ("scenario", "num_boats", "share", "median"),
    [
        ("nominal", 2, 0.95, 25.0),
        ("nominal", 4, 0.95, 30.0),
        ("nominal", 10, 0.85, 40.0),
        ("noisy", 4, 0.95, 30.0),
        ("noisy", 8, 0.9, 40.0),
        ("gyre", 4, 0.9, 65.0),
        ("mismatch", 4, 0.95, 30.0),
    ],
)
def test_teams_grasp_the_vessel(scenario, num_boats, share, median):
    _, grasped = approach(lasting(scenario, num_boats), range(12), share=share)
    assert np.isfinite(grasped).mean() >= share
    assert np.median(grasped) < median


@pytest.fixture(scope="module")
def minute():
    """Simulation after a minute, and when each world was first grasped for a second, s."""
    return approach(lasting("nominal"), range(12), 60.0)


def test_boats_hold_their_slots_together(minute):
    simulation, grasped = minute
    spread = simulation.summary()["closure_spread"]
    assert np.isfinite(grasped).all()
    assert np.median(spread) < HALF_TURN


def test_grasp_lasts_while_nobody_pushes(minute):
    simulation, grasped = minute
    assert (simulation.state.occupied_ticks > 10 * (50.0 - grasped)).mean() >= 0.9


def test_team_grasps_again_when_a_boat_fails_far_from_the_vessel():
    early = {"failures": 1, "failure_time": (3.0, 8.0)}
    simulation, grasped = approach(lasting("failure", 6, variation=early), range(20), share=0.85)
    assert not simulation.state.working.all()
    assert np.isfinite(grasped).mean() >= 0.85


@pytest.fixture
def team():
    """A team at rest in its slots, and its controller."""
    params = make_params("push", 6, goal=(0.0, -1.0, 0.0))
    simulation = Simulation(params, 1)
    simulation.reset(seeds=[0])
    return simulation, GraspController(params, GAINS)


def steered(team, motion, slot, memory=None, drift=0.0):
    """One decision (A, 2) of the controller, from its beginning unless there is a memory.

    The team knows the ``drift`` of the water, m/s.
    """
    simulation, controller = team
    sensed = replace(simulation.sensed, estimate=motion, slot=slot)
    relations = relate(motion, sensed.goal, slot, sensed.side)
    begins = np.array([memory is None])
    memory = memory or GraspMemory.empty(*slot.shape)
    vessel = VesselMemory.empty(*slot.shape)
    vessel.drift[:] = drift
    return controller.act(relations, sensed, vessel, memory, begins)[0], memory


def test_boats_in_their_slots_stay(team):
    state = team[0].state
    action, memory = steered(team, state.motion, state.slot)
    assert memory.descending.all()
    assert np.abs(action[:, 0]).max() < 0.02
    assert np.abs(action[:, 1]).max() < 0.1


def test_boats_in_each_others_slots_go_astern(team):
    """The row of slots leaves no room to go round."""
    state = team[0].state
    swapped = np.argsort(state.slot[0].real)[[2, 3]]
    wrong = state.slot.copy()
    wrong[0, swapped] = wrong[0, swapped[::-1]]
    action, memory = steered(team, state.motion, wrong)
    assert memory.astern[0, swapped].all()
    assert (action[swapped, 0] < -0.02).all()


def test_new_slots_begin_a_new_approach(team):
    state = team[0].state
    _, memory = steered(team, state.motion, state.slot)
    assert memory.descending.all()
    moved = state.slot + 0.2
    steered(team, state.motion, moved, memory)
    np.testing.assert_array_equal(memory.slot, moved)
    assert not memory.descending.any()


def test_speeds_are_relative_to_the_vessel(team):
    """Those who drift with the water want what they would want at rest, and drift on."""
    state, drift = team[0].state, np.array([0.03, -0.01])
    motion = state.motion.copy()
    still, _ = steered(team, motion, state.slot)
    motion[..., 3:5] += drift
    moving, _ = steered(team, motion, state.slot, drift=complex(*drift))
    bow = np.exp(1j * motion[0, 1:, 2])
    along = (complex(*drift) * bow.conj()).real
    np.testing.assert_allclose(moving[:, 0] - still[:, 0], along, atol=1e-9)
    np.testing.assert_allclose(moving[:, 1], still[:, 1], atol=1e-9)


@pytest.mark.parametrize("stream", [-0.01, 0.01])
def test_boats_turn_against_water_that_flows_past_the_hull(team, stream):
    state = team[0].state
    still, _ = steered(team, state.motion, state.slot)
    action, _ = steered(team, state.motion, state.slot, drift=stream)
    assert ((action - still)[:, 1] * np.sign(stream) < -0.05).all()


def test_boats_step_aside_from_a_failed_one_in_the_row(team):
    simulation, _ = team
    state = simulation.state
    order = np.argsort(state.slot[0].real)
    works = np.ones((1, 6), dtype=bool)
    works[0, order[2]] = False
    sensed = simulation.sensed
    relations = relate(state.motion, sensed.goal, state.slot, sensed.side)
    points = slots(simulation.params, 5)
    target = np.where(works, 0, relations.boat)
    target[works] = points[np.argsort(np.argsort(state.slot[works].real))]
    width, limit = simulation.params.boat.width, MAX_SIDESTEP * simulation.params.task.slot_distance
    shift = sidestep(target, relations.boat, ~works, width, limit)[0, order].real
    gaps = target[0, order].real - relations.boat[0, order[2]].real
    crowded = (np.abs(gaps) < simulation.params.boat.width) & works[0, order]
    assert crowded.any()
    assert (np.sign(shift) == np.where(crowded, np.sign(gaps), 0)).all()
    assert np.abs(shift).max() < simulation.params.task.slot_distance
