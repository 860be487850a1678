"""The push phase: what the boats do for the force and moment wanted, and how the vessel moves."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import decide, known_at_start, moved

from asv_env import Simulation, make_params
from asv_env.geometry import wrap
from asv_env.tasks.formation import slots
from asv_env.types import rows
from baselines.rollout.loop import rollout
from baselines.scripted import (
    GraspGains,
    PathGains,
    PathPlanner,
    PushGains,
    ScriptedPolicy,
    Tolerances,
)
from baselines.scripted.observer import VesselObserver
from baselines.scripted.push_controller import PushController

AHEAD = (0.1, -1.2, 0.2)
"""A goal that the vessel need not turn round for."""


def drive(params, seconds, worlds=2):
    """Simulation after so many seconds of the policy, and its memory."""
    sim, ticks = Simulation(params, worlds), round(seconds * params.clock.control)
    *_, last = rollout(sim, ScriptedPolicy(params).act, range(worlds), ticks)
    return sim, last.memory


@pytest.mark.parametrize("preset", ["nominal", "paper_simulation"])
def test_boats_are_spread_but_stay_on_the_hull_and_apart(preset):
    for team in (2, 3, 4, 5, 8, 13, 20, 40):
        params = make_params("push", team, preset=preset)
        planner = PathPlanner(params.hulls()[0], PathGains())
        controller = PushController(params, planner, PushGains(), Tolerances())
        slot = slots(params, team)[None]
        caging = np.abs(slot.real) > params.vessel.length / 2
        places = controller.places(slot, ~caging, np.ones(1))[0]
        at_side = places[~caging[0]]
        room = params.vessel.length / 2 - params.boat.width
        assert np.abs(at_side.real).max() <= room * (1 + 1e-12)
        assert (np.diff(at_side.real) >= params.boat.width * (1 - 1e-12)).all()
        assert (np.abs(at_side.real) >= np.abs(slot[~caging].real)).all()
        np.testing.assert_array_equal(places[caging[0]], slot[caging])
        np.testing.assert_array_equal(places.imag, slot[0].imag)


# ---------------------------------------------------------------------- decisions


def disturbed(params, seeds):
    """Initial states of pushes, where vessels and boats are off their places and move."""
    sensed, rng = known_at_start(params, seeds), np.random.default_rng(0)
    noise = rng.normal(size=sensed.measured.shape) * [0.01, 0.01, 0.1, 0.02, 0.02, 0.05]
    motion = sensed.measured + noise
    return replace(sensed, measured=motion, estimate=motion)


def end_for_end(sensed):
    """The world in a mirror across the vessel: its +n side stays, its ends change places."""
    image = sensed.measured * [-1, 1, -1, -1, 1, -1]
    image[:, 1:, 2] = wrap(image[:, 1:, 2] + np.pi)
    goal = sensed.goal * [-1, 1, -1]
    return replace(sensed, measured=image, estimate=image, goal=goal, slot=-sensed.slot.conj())


@pytest.mark.parametrize("num_boats", [2, 3, 4, 7])
def test_mirrored_worlds_get_mirrored_actions(num_boats):
    """To pass the goal, for which no team changes sides."""
    params = make_params("push", num_boats, delivery="passing")
    policy, seeds = ScriptedPolicy(params), range(32)
    sensed = disturbed(params, seeds)
    memory = image_memory = None
    for _ in range(3):
        action, memory = decide(policy, sensed, memory)
        image, image_memory = decide(policy, end_for_end(sensed), image_memory)
        np.testing.assert_allclose(image, action * [1, -1], atol=1e-5)
    assert memory.pushing.all()
    assert (np.abs(action) < 1).mean() > 0.5


@pytest.mark.parametrize("cross_track", [-0.05, 0.05])
def test_the_boat_at_the_far_end_presses_the_vessel_back_to_its_path(cross_track):
    """Both turn their bows to the hull, and that one gives more thrust."""
    params = make_params("push", 4, goal=(0.0, -1.0, 0.0))
    sensed, policy = known_at_start(params, [0]), ScriptedPolicy(params)
    _, memory = decide(policy, sensed)
    displaced = moved(sensed, np.array([[cross_track, 0.0, 0.0]]))
    slot = sensed.slot[0].real
    far, near = np.argmax(slot * np.sign(cross_track)), np.argmin(slot * np.sign(cross_track))
    on_path, _ = decide(policy, sensed, memory)
    off_path, _ = decide(policy, displaced, memory)
    thrust = (off_path - on_path)[0, :, 0]
    assert thrust[far] > 0.01
    assert thrust[near] == pytest.approx(0.0, abs=1e-3)
    assert -on_path[0, far, 1] * np.sign(slot[far]) > 0
    assert -on_path[0, near, 1] * np.sign(slot[near]) > 0


def test_worlds_do_not_touch_each_other():
    """Among them worlds whose team has lost a boat, and with it the cage round the vessel."""
    params = make_params("push", 4)
    policy, sensed = ScriptedPolicy(params), disturbed(params, range(6))
    sensed.working[::2, 0] = False
    sensed.slot[::2, 1:] = slots(params, 3)
    together, _ = decide(policy, sensed)
    for world in range(6):
        alone, _ = decide(policy, rows(sensed, slice(world, world + 1)))
        np.testing.assert_array_equal(alone[0], together[world])


@pytest.mark.parametrize("num_boats", [4, 6])
def test_a_boat_that_failed_is_left_out(num_boats):
    """Wherever it lies, the others do the same."""
    params = make_params("push", num_boats)
    policy, decisions = ScriptedPolicy(params), []
    for place in (0.1 + 0.2j, 0.5 + 0.2j, -0.3 + 1.0j):
        sensed = known_at_start(params, [0])
        sensed.working[0, 0] = False
        sensed.slot[0, 1:] = slots(params, num_boats - 1)
        sensed.slot[0, 0] = place
        sensed.measured[0, 1, :2] = place.real, place.imag
        action, _ = decide(policy, replace(sensed, estimate=sensed.measured))
        decisions.append(action[0, 1:])
    np.testing.assert_allclose(decisions[1], decisions[0], atol=1e-6)
    np.testing.assert_allclose(decisions[2], decisions[0], atol=1e-6)


@pytest.mark.parametrize("failed", [False, True])
def test_a_team_pushes_without_closure_where_a_failed_boat_prevents_it(failed):
    """All are at their slots, but the estimate says that closure has never been formed."""
    params = make_params("push", 6)
    sensed, hz = known_at_start(params, [0]), params.clock.control
    sensed.closed[:] = False
    if failed:
        sensed.working[0, 2] = False
    policy, pushes = ScriptedPolicy(params), []
    _, memory = decide(policy, sensed)
    memory.grasp.descending[:] = True
    for more in (-1, 1):
        patience = GraspGains().descent_patience + more
        memory.grasp.due[:] = sensed.tick - patience * hz
        pushes.append(bool(decide(policy, sensed, memory)[1].pushing[0]))
    assert pushes == [False, failed]


# ---------------------------------------------------------------------- on the water


@pytest.mark.parametrize("num_boats", [2, 4, 9])
def test_boats_exert_the_force_that_they_mean_to(num_boats):
    """Straight ahead at a constant speed it is the drag on the vessel."""
    params = make_params("push", num_boats, goal=(0.0, -2.9, 0.0))
    sim, memory = drive(params, 20, worlds=1)
    vessel, speed = params.hulls()[0], -sim.state.motion[0, 0, 4]
    drag = (vessel.sway[0] + vessel.sway[1] * speed) * speed
    surplus = vessel.masses[1] * VesselObserver(params).acceleration(memory.vessel)[0, 1]
    assert abs(surplus) < 0.15 * drag
    assert speed == pytest.approx(PathGains().speed, rel=0.05)
    assert np.abs(sim.state.motion[0, 0, [0, 2]]).max() < 0.01


@pytest.mark.parametrize(
    ("num_boats", "options"),
    [(n, {"goal": AHEAD}) for n in (2, 3, 5, 12, 20)]
    + [
        (10, {"preset": "paper_simulation", "goal": AHEAD}),
        (4, {"preset": "tank", "goal": AHEAD}),
        (4, {"preset": "experiment", "goal": AHEAD}),
        (5, {"side": "-n", "goal": (0.1, 1.2, -0.2)}),
        (6, {"scenario": "failure", "variation": {"failure_time": (1.0, 3.0)}, "goal": AHEAD}),
        (4, {"scenario": "current", "goal": AHEAD}),
        (4, {"scenario": "harsh", "goal": AHEAD}),
        (4, {"vessel": {"yaw": (0.0, 0.0)}, "goal": AHEAD}),
    ],
)
def test_every_team_moves_the_vessel_towards_its_goal(num_boats, options):
    sim, _ = drive(make_params("push", num_boats, **options), 12)
    covered = np.abs(sim.state.goal[:, 1]) - sim.relations.goal_error
    assert (covered > 0.3).all()
