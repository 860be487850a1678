"""The push phase: how the wrench is shared out, how paths are followed, and what comes of it."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.geometry import direction, wrap
from asv_env.tasks.formation import relate, slots
from asv_env.types import copied, rows
from baselines.paper.arcs import advance
from baselines.scripted import PathGains, PathPlanner, PushGains, ScriptedPolicy, Tolerances
from baselines.scripted.path_following import OFF_PATH, PAST_GOAL, PathFollower, PathMemory
from baselines.scripted.push_controller import PushController

TEAMS = st.sampled_from([2, 3, 4, 5, 8, 20])
AHEAD = (0.1, -1.2, 0.2)
"""A goal that the vessel need not turn round for."""


@functools.cache
def planner_of(params):
    return PathPlanner(params.hulls()[0], PathGains())


@functools.cache
def controller_of(params):
    return PushController(params, planner_of(params), PushGains(), Tolerances())


def follower_of(params):
    return PathFollower(params.hulls()[0], planner_of(params), PushGains(), Tolerances())


def places_of(params):
    """Slots (1, A) from -u to +u, and which of them cage the vessel's ends."""
    slot = slots(params, params.num_boats)[None]
    return slot, np.abs(slot.real) > params.vessel.length / 2


def full_drag(params):
    """Drag of the vessel at the speed of the push, N."""
    linear, quadratic = params.hulls()[0].sway
    return (linear + quadratic * PathGains().speed) * PathGains().speed


def shared(params, ahead, moment):
    """Forces (A,) of boats in their slots, and the moment that is said to come about."""
    slot, caging = places_of(params)
    each, comes = controller_of(params).allocate(
        np.array([ahead]), np.array([moment]), slot.real, ~caging
    )
    return each[0], comes[0], slot[0].real, caging[0]


def begun(params, seeds):
    """What the boats know at the start of episodes."""
    sim = Simulation(params, len(seeds))
    sim.reset(seeds=list(seeds))
    return copied(sim.sensed)


def decide(policy, sensed, memory=None):
    fresh = np.full(len(sensed.side), memory is None)
    return policy.act(sensed, np.empty(0), memory, fresh)


def moved(sensed, poses):
    """The same with vessels at other poses (W, 3), their boats taken along."""
    motion, old = sensed.measured.copy(), sensed.measured[:, :1]
    turn = poses[:, None, 2] - old[..., 2]
    offset = motion[..., 0] - old[..., 0] + 1j * (motion[..., 1] - old[..., 1])
    offset = offset * direction(turn)
    motion[..., 0], motion[..., 1] = poses[:, :1] + offset.real, poses[:, 1:2] + offset.imag
    motion[..., 2] = wrap(motion[..., 2] + turn)
    return replace(sensed, measured=motion, estimate=motion)


def drive(params, seconds, worlds=2):
    """Simulation after so many seconds of the policy, and its memory."""
    sim, policy, memory = Simulation(params, worlds), ScriptedPolicy(params), None
    observation, fresh = sim.reset(seeds=range(worlds)), np.ones(worlds, dtype=bool)
    for _ in range(round(seconds * params.clock.control)):
        action, memory = policy.act(sim.sensed, observation, memory, fresh)
        observation, fresh = sim.step(action).observation, np.zeros(worlds, dtype=bool)
    return sim, memory


# ---------------------------------------------------------------------- shares


@given(TEAMS, st.floats(0.0, 2.0), st.floats(-3.0, 3.0))
def test_boats_can_only_push(team, ahead, moment):
    """Force in units of the drag at full speed; moment, of that at a quarter of the length."""
    params = make_params("push", team)
    force = full_drag(params)
    each, comes, u, caging = shared(
        params, ahead * force, moment * force * params.vessel.length / 4
    )
    assert (each[~caging] > 0).all()
    np.testing.assert_array_equal(each[caging], 0.0)
    assert each.sum() >= ahead * force * (1 - 1e-12)
    np.testing.assert_allclose(comes, -(each * u)[~caging].sum(), atol=1e-15)


@given(TEAMS, st.floats(0.3, 2.0), st.floats(-0.5, 0.5))
def test_a_small_wrench_comes_about_as_it_is_asked(team, ahead, moment):
    params = make_params("push", team)
    ahead = ahead * full_drag(params)
    _, _, u, caging = shared(params, ahead, 0.0)
    u, pushers = u[~caging], (~caging).sum()
    moment = moment * ahead * (u**2).sum() / pushers / np.abs(u).max()
    each, comes, _, _ = shared(params, ahead, moment)
    assert each.sum() == pytest.approx(ahead)
    assert comes == pytest.approx(moment, abs=1e-15)


@given(TEAMS, st.floats(0.0, 1.0), st.floats(1.0, 1e3))
def test_no_moment_is_too_large_to_ask(team, ahead, moment):
    """What comes of it is the most there is, the same for all that is too much."""
    params = make_params("push", team)
    ahead = ahead * full_drag(params)
    most = shared(params, ahead, 1e6)
    each, comes, u, caging = shared(params, ahead, moment)
    np.testing.assert_allclose(each, most[0])
    assert 0 < comes <= each.sum() * np.abs(u[~caging]).max()
    assert each.sum() < 3 * full_drag(params)


@given(TEAMS, st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_mirrored_wrench_is_shared_by_the_mirrored_boats(team, ahead, moment):
    params = make_params("push", team)
    force = full_drag(params)
    asked = ahead * force, moment * force * params.vessel.length / 4
    each, comes, _, _ = shared(params, *asked)
    image, mirrored, _, _ = shared(params, asked[0], -asked[1])
    np.testing.assert_allclose(image, each[::-1], atol=1e-15)
    assert mirrored == pytest.approx(-comes, abs=1e-15)


@given(TEAMS, st.floats(0.01, 2.0))
def test_a_vessel_that_is_too_fast_is_left_alone(team, surplus):
    params = make_params("push", team)
    each, _, _, caging = shared(params, -surplus * full_drag(params), 0.0)
    assert (each[~caging] < 0).all()


@pytest.mark.parametrize("preset", ["nominal", "paper_simulation"])
def test_boats_are_spread_but_stay_on_the_hull_and_apart(preset):
    for team in range(2, 41):
        params = make_params("push", team, preset=preset)
        slot, caging = places_of(params)
        places = controller_of(params).places(slot, ~caging)[0]
        at_side = places[~caging[0]]
        room = params.vessel.length / 2 - params.boat.width
        assert np.abs(at_side.real).max() <= room * (1 + 1e-12)
        assert (np.diff(at_side.real) >= params.boat.width * (1 - 1e-12)).all()
        assert (np.abs(at_side.real) >= np.abs(slot[~caging].real)).all()
        np.testing.assert_array_equal(places[caging[0]], slot[caging])
        np.testing.assert_array_equal(places.imag, slot[0].imag)


# ---------------------------------------------------------------------- path


@given(st.floats(0.05, 0.95), st.floats(-0.05, 0.05), st.floats(-0.5, 0.5))
def test_vessel_knows_where_it_is_on_its_path(share, aside, turned):
    """Beside the path abreast of a point of it, and turned off its heading there."""
    params = make_params("push", goal=(0.8, -1.0, 0.7))
    sensed, follower = begun(params, [0]), follower_of(params)
    memory, still = PathMemory.empty(1), np.zeros(1, complex)
    follower.plan(
        relate(sensed.measured, sensed.goal, sensed.slot, sensed.side),
        still, memory, np.ones(1, dtype=bool),
    )  # fmt: skip
    s = share * memory.length.sum()
    abreast = memory.start[0]
    for bend, length in zip(memory.curvature[0], memory.length[0], strict=True):
        abreast = advance(abreast, bend, min(s, length))
        s -= min(s, length)
    off_path = np.array([aside * np.cos(abreast[2]), aside * np.sin(abreast[2]), turned])
    placed = moved(sensed, (abreast + off_path)[None])
    relations = relate(placed.measured, placed.goal, placed.slot, placed.side)
    speed = np.array([0.05])
    for _ in range(60):
        seen = follower.track(relations, still, speed, memory)
    offset, off, left, curvature = seen
    total = memory.length.sum()
    assert offset[0] == pytest.approx(aside, abs=1e-6)
    assert off[0] == pytest.approx(turned, abs=1e-6)
    assert left[0] == pytest.approx((1 - share) * total, abs=1e-6)
    ends = np.cumsum(memory.length[0])
    ahead = share * total + speed * follower.preview_times
    sharp = np.abs(ahead[:, None] - ends).min(axis=1) < 1e-4
    segment = (ahead[:, None] >= ends).sum(axis=1)
    expected = np.append(memory.curvature[0], 0.0)[segment]
    np.testing.assert_array_equal(curvature[0, ~sharp], expected[~sharp])


def test_path_and_water_meet_at_the_goal():
    """The water carries what follows the path to the goal when its time is over."""
    params, seeds = make_params("push"), range(50)
    sensed, follower = begun(params, seeds), follower_of(params)
    rng = np.random.default_rng(0)
    sensed = moved(sensed, rng.uniform(-1, 1, (len(seeds), 3)) * [0.5, 0.5, np.pi])
    drift = 0.01 * np.exp(1j * rng.uniform(-np.pi, np.pi, len(seeds)))
    memory = PathMemory.empty(len(seeds))
    relations = relate(sensed.measured, sensed.goal, sensed.slot, sensed.side)
    follower.plan(relations, drift, memory, np.ones(len(seeds), dtype=bool))
    pose = memory.start
    for bend, length in zip(memory.curvature.T, memory.length.T, strict=True):
        pose = advance(pose, bend, length)
    np.testing.assert_allclose(pose[:, :2], sensed.goal[:, :2], atol=1e-9)
    np.testing.assert_allclose(wrap(pose[:, 2] - sensed.goal[:, 2]), 0.0, atol=1e-9)
    carried = drift * planner_of(params).time(memory.length.sum(axis=1))
    begins = memory.start[:, 0] + 1j * memory.start[:, 1] - carried
    vessel = sensed.measured[:, 0, 0] + 1j * sensed.measured[:, 0, 1]
    assert np.median(np.abs(begins - vessel)) < 0.02 * params.vessel.length


@pytest.mark.parametrize(
    ("along", "across", "missed"),
    [(0.5 * PAST_GOAL, 0.0, False), (2 * PAST_GOAL, 0.0, True), (-1.0, 0.9 * OFF_PATH, False),
     (-1.0, 1.1 * OFF_PATH, True), (-1.0, -1.1 * OFF_PATH, True)],
)  # fmt: skip
def test_a_vessel_that_misses_its_goal_gets_a_new_path(along, across, missed):
    """Straight ahead of the goal by so many lengths, and beside its path."""
    params = make_params("push", goal=(0.0, -1.0, 0.0))
    sensed, policy = begun(params, [0]), ScriptedPolicy(params)
    _, memory = decide(policy, sensed)
    path, length = memory.path, params.vessel.length
    assert path.length.sum() == pytest.approx(1.0, abs=1e-9)
    there = moved(sensed, np.array([[across * length, -1.0 - along * length, 0.0]]))
    for _ in range(2):
        _, memory = decide(policy, there, memory)
    if not missed:
        np.testing.assert_array_equal(memory.path.start, path.start)
        np.testing.assert_array_equal(memory.path.length, path.length)
        return
    np.testing.assert_allclose(memory.path.start[0], there.measured[0, 0, :3], atol=1e-5)
    pose = memory.path.start[0]
    for bend, way in zip(memory.path.curvature[0], memory.path.length[0], strict=True):
        pose = advance(pose, bend, way)
    np.testing.assert_allclose(pose[:2], params.task.goal[:2], atol=1e-9)


# ---------------------------------------------------------------------- decisions


def disturbed(params, seeds):
    """Starts of pushes, where vessels and boats are off their places and move."""
    sensed, rng = begun(params, seeds), np.random.default_rng(0)
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
    params = make_params("push", num_boats)
    policy, seeds = ScriptedPolicy(params), range(32)
    sensed = disturbed(params, seeds)
    memory = image_memory = None
    for _ in range(3):
        action, memory = decide(policy, sensed, memory)
        image, image_memory = decide(policy, end_for_end(sensed), image_memory)
        np.testing.assert_allclose(image, action * [1, -1], atol=1e-5)
    assert memory.pushing.all()
    assert (np.abs(action) < 1).mean() > 0.5


@pytest.mark.parametrize("aside", [-0.05, 0.05])
def test_the_boat_at_the_far_end_presses_the_vessel_back_to_its_path(aside):
    """It turns its bow to the hull, and the one at the other end lets go."""
    params = make_params("push", 4, goal=(0.0, -1.0, 0.0))
    sensed, policy = begun(params, [0]), ScriptedPolicy(params)
    _, memory = decide(policy, sensed)
    beside = moved(sensed, np.array([[aside, 0.0, 0.0]]))
    slot = sensed.slot[0].real
    far, near = np.argmax(slot * np.sign(aside)), np.argmin(slot * np.sign(aside))
    on_path, _ = decide(policy, sensed, memory)
    off_path, _ = decide(policy, beside, memory)
    turns = (off_path - on_path)[0, :, 1] * np.sign(aside)
    assert turns[far] < -0.01
    assert turns[near] <= 0
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
def test_a_boat_that_failed_is_not_reckoned_with(num_boats):
    """Wherever it lies, the others do the same."""
    params = make_params("push", num_boats)
    policy, decisions = ScriptedPolicy(params), []
    for place in (0.1 + 0.2j, 0.5 + 0.2j, -0.3 + 1.0j):
        sensed = begun(params, [0])
        sensed.working[0, 0] = False
        sensed.slot[0, 1:] = slots(params, num_boats - 1)
        sensed.slot[0, 0] = place
        sensed.measured[0, 1, :2] = place.real, place.imag
        action, _ = decide(policy, replace(sensed, estimate=sensed.measured))
        decisions.append(action[0, 1:])
    np.testing.assert_allclose(decisions[1], decisions[0], atol=1e-6)
    np.testing.assert_allclose(decisions[2], decisions[0], atol=1e-6)


# ---------------------------------------------------------------------- on the water


@pytest.mark.parametrize("num_boats", [2, 4, 9])
def test_boats_exert_the_force_that_they_mean_to(num_boats):
    """Straight ahead at a constant speed it is the drag on the vessel."""
    params = make_params("push", num_boats, goal=(0.0, -2.9, 0.0))
    sim, memory = drive(params, 20, worlds=1)
    vessel, speed = params.hulls()[0], -sim.state.motion[0, 0, 4]
    drag = (vessel.sway[0] + vessel.sway[1] * speed) * speed
    lacks = vessel.total_mass * memory.vessel.acceleration[0, 1]
    assert abs(lacks) < 0.15 * drag
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
    way = np.abs(sim.state.goal[:, 1]) - sim.relations.goal_error
    assert (way > 0.3).all()
