"""The task: slots, starts, closure, delivery, ends, reward, observation, noise, metrics."""

from itertools import permutations
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import DOWN, actions, begin_at, bodies, turned
from hypothesis import given
from hypothesis import strategies as st

from asv_env import make_params
from asv_env.geometry import wrap
from asv_env.sensing import observation
from asv_env.simulation import Simulation
from asv_env.tasks import formation, laws, payment, reward, standing, starts
from asv_env.types import Ending

approx = pytest.approx
ABOUT, AHEAD = (0.0, 0.3), (0.5, 0.0)
"""Tracking actions: turn on the spot, go ahead."""


def begun(params, num_worlds=1, first_seed=0):
    sim = Simulation(params, num_worlds)
    sim.reset(seeds=range(first_seed, first_seed + num_worlds))
    return sim


def begun_at(params, *motions, **start):
    sim = Simulation(params, len(motions))
    begin_at(sim, motions, **start)
    return sim


def step(sim, action=0.0):
    return sim.step(actions(sim, action))


def in_slots(params, pose=(0.0, 0.0, 0.0), gap=1e-3):
    """Motion (B, 6) of a team of four or more at rest in its slots, from -u to +u."""
    vessel, boat = params.vessel, params.boat
    u = vessel.length * (np.arange(params.num_boats) / (params.num_boats - 1) - 0.5)
    w = np.full(params.num_boats, (vessel.width + boat.length) / 2 + gap)
    end = (vessel.length + boat.width) / 2 + 0.005
    u[0], u[-1], w[0], w[-1] = -end, end, 0.0, 0.0
    motion = bodies((), *((x, y, DOWN) for x, y in zip(u, w, strict=True)))
    return turned(motion, pose[2], pose[0] + 1j * pose[1])


# ------------------------------------------------------------------ slots


@pytest.mark.parametrize("team", [4, 5, 10, 100])
def test_ends_are_caged_and_the_rest_spread_along_the_side(team):
    params = make_params(num_boats=team)
    slots = formation.slots(params, team)
    vessel, boat = params.vessel, params.boat
    assert slots[[0, -1]] == approx(
        np.array([-1, 1]) * (vessel.length / 2 + boat.width / 2 + 0.005)
    )
    np.testing.assert_allclose(slots[1:-1].imag, vessel.width / 2 + boat.length / 2)
    expected = vessel.length * (np.arange(1, team - 1) / (team - 1) - 0.5)
    np.testing.assert_allclose(slots[1:-1].real, expected, atol=1e-12)


@pytest.mark.parametrize("team", [2, 3])
def test_small_teams_all_push_from_the_side(team):
    params = make_params(num_boats=team)
    slots = formation.slots(params, team)
    np.testing.assert_allclose(slots.imag, 0.135)
    np.testing.assert_allclose(slots.real, -slots.real[::-1], atol=1e-12)
    assert np.all(np.diff(slots.real) > params.boat.width)
    assert np.abs(slots.real).max() < 0.2 - params.boat.width / 2


@pytest.mark.parametrize("team", [2, 3, 4, 10, 100])
def test_boats_in_their_slots_have_room(team):
    sim = begun(make_params("push", team))
    assert not sim.state.touching.any()
    step(sim)
    assert not sim.state.touching[..., 1].any()


@pytest.mark.parametrize(("side", "sign"), [("+n", 1), ("-n", -1)])
def test_side_mirrors_the_slots_and_the_headings(side, sign):
    sim = begun(make_params("push", side=side))
    boats, slots = sim.state.motion[0, 1:], sim.state.slot[0]
    nominal = begun(make_params("push")).state.slot[0]
    np.testing.assert_allclose(slots, nominal if sign > 0 else nominal.conj())
    np.testing.assert_allclose(boats[:, 2], -sign * np.pi / 2)
    np.testing.assert_allclose(boats[:, 0] + 1j * boats[:, 1], slots, atol=1.01e-3)


@pytest.mark.parametrize(("y", "side"), [(0.5, -1), (-0.5, 1)])
def test_side_away_from_the_goal_pushes_towards_it(y, side):
    sim = begun(make_params("push", side="goal", goal=(0.3, y, 0)))
    assert sim.state.side[0] == side
    assert np.sign(sim.state.motion[0, 2, 1]) == -np.sign(y)
    for _ in range(50):
        step(sim, AHEAD)
    assert np.sign(sim.state.motion[0, 0, 1]) == np.sign(y)


def least_way(boats, slots):
    """Total distance of the best assignment, by trying them all."""
    return min(
        np.abs(boats - slots[list(order)]).sum() for order in permutations(range(len(boats)))
    )


@given(seed=st.integers(0, 10**6), team=st.integers(1, 6))
def test_assignment_is_the_best_of_all(seed, team):
    points = np.random.default_rng(seed).normal(size=(2, team, 2)) @ [1, 1j]
    order = formation.assign(points[0], points[1])
    assert sorted(order) == list(range(team))
    assert np.abs(points[0] - points[1][order]).sum() == approx(least_way(*points))


@pytest.mark.parametrize("team", [2, 4, 5])
def test_boats_are_assigned_to_slots_at_reset_with_the_least_total_way(team):
    params = make_params(num_boats=team)
    sim = begun(params, 5)
    points = formation.slots(params, team)
    for world in range(5):
        boats = sim.state.motion[world, 1:, :2] @ [1, 1j]
        assert sorted(sim.state.slot[world].real) == approx(sorted(points.real))
        assert np.abs(boats - sim.state.slot[world]).sum() == approx(least_way(boats, points))


# ------------------------------------------------------------------ starts


@pytest.mark.parametrize("task", ["approach", "transport"])
def test_boats_start_all_round_the_vessel_apart_and_at_rest(task):
    state = begun(make_params(task), 300).state
    np.testing.assert_array_equal(state.motion[:, 0], 0)
    np.testing.assert_array_equal(state.motion[..., 3:], 0)
    boats = state.motion[:, 1:, :2] @ [1, 1j]
    assert 0.5 <= np.abs(boats).min() < 0.55
    assert 1.45 < np.abs(boats).max() <= 1.5
    gaps = np.abs(boats[:, :, None] - boats[:, None, :]) + 9 * np.eye(4)
    assert 0.18 <= gaps.min() < 0.25
    quadrants = np.histogram(np.angle(boats), 4, (-np.pi, np.pi))[0] / boats.size
    np.testing.assert_allclose(quadrants, 0.25, atol=0.05)
    inner = (np.abs(boats) < np.sqrt((0.5**2 + 1.5**2) / 2)).mean()
    assert inner == approx(0.5, abs=0.05)


def test_boats_start_with_any_heading():
    headings = begun(make_params(), 300).state.motion[:, 1:, 2]
    shares = np.histogram(headings, 4, (-np.pi, np.pi))[0] / headings.size
    np.testing.assert_allclose(shares, 0.25, atol=0.05)


def test_goals_lie_in_their_range_in_all_directions_with_any_heading():
    goal = begun(make_params(), 400).state.goal
    distance = np.hypot(goal[:, 0], goal[:, 1])
    assert 0.4 <= distance.min() < 0.5
    assert np.abs(goal[:, :2]).max() <= 1.2
    assert distance.max() > 1.1
    for angle in (np.arctan2(goal[:, 1], goal[:, 0]), goal[:, 2]):
        shares = np.histogram(angle, 4, (-np.pi, np.pi))[0] / 400
        np.testing.assert_allclose(shares, 0.25, atol=0.08)


def test_goal_given_at_reset_overrides_the_drawn_one():
    sim = Simulation(make_params(), 2)
    sim.reset(seeds=[0, 1], goal=(0.55, -0.95, 0.1))
    np.testing.assert_allclose(sim.state.goal, [(0.55, -0.95, 0.1)] * 2)


# ------------------------------------------------------------------ closure


def occupied(params, motion, slot):
    """Which boats of a motion (B, 6) occupy their slots (A,)."""
    team = SimpleNamespace(
        goal=np.zeros((1, 3)), slot=slot[None], side=np.ones(1),
        working=np.ones((1, len(slot)), bool), closed=np.zeros(1, bool),
    )  # fmt: skip
    return standing.advanced(team, motion[None], params, 1).occupied[0]


def holds(params, moved):
    """Whether one boat, moved (6,) from its slot in the vessel's frame, holds it."""
    motion = in_slots(params, gap=0.0)
    motion[1] += moved
    vessel = np.array([0.4, -0.2, 0.8])
    motion = turned(motion, vessel[2], vessel[0] + 1j * vessel[1])
    slot = in_slots(params, gap=0.0)[1:, :2] @ [1, 1j]
    held = occupied(params, motion, slot)
    assert held[1:].all()
    return bool(held[0])


@pytest.mark.parametrize(
    ("moved", "held"),
    [
        ((0, 0, 0), True),
        ((0.02, -0.02, 0.29, 0.013, -0.014, 9), True),
        ((0.031, 0, 0), False),
        ((0, -0.031, 0), False),
        ((0, 0, 0.31), False),
        ((0, 0, -0.31), False),
        ((0, 0, np.pi), False),
        ((0, 0, 0, 0.021, 0), False),
        ((0, 0, 0, 0, -0.021), False),
    ],
)
def test_slot_is_held_only_near_it_facing_across_it_and_at_rest(moved, held):
    params = make_params()
    assert holds(params, np.pad(np.array(moved, dtype=float), (0, 6 - len(moved)))) is held


def test_boat_that_moves_and_turns_with_the_vessel_holds_its_slot():
    params = make_params()
    motion = in_slots(params, gap=0.0)
    x, y = motion[:, 0], motion[:, 1]
    motion[:, 3], motion[:, 4], motion[:, 5] = 0.1 - 0.5 * y, 0.05 + 0.5 * x, 0.5
    slot = motion[1:, :2] @ [1, 1j]
    assert occupied(params, motion, slot).all()


def test_push_starts_in_closure_and_the_other_tasks_do_not():
    assert begun(make_params("push")).state.closed.all()
    assert not begun(make_params("transport")).state.closed.any()
    assert not begun(make_params("approach")).state.closed.any()


@pytest.mark.parametrize("hold_time", [1.0, 0.5, 2.0])
def test_approach_succeeds_once_all_slots_were_held_for_the_hold_time(hold_time):
    params = make_params("approach", hold_time=hold_time)
    sim = begun_at(params, in_slots(params))
    endings = []
    while not endings or not endings[-1].terminated[0]:
        endings.append(step(sim).ending)
    assert len(endings) == round(10 * hold_time)
    assert endings[-1].reached.all()
    assert sim.summary()["is_success"].all()


def test_boat_out_of_its_slot_keeps_approach_from_succeeding():
    params = make_params("approach")
    sim = begun_at(params, in_slots(params))
    for _ in range(6):
        step(sim)
    assert sim.state.occupied_ticks[0] == 6
    for _ in range(30):
        ending = step(sim, [(0, 0), (-0.5, 0), (0, 0), (0, 0)]).ending
    assert sim.state.occupied_ticks[0] == 0
    assert not ending.terminated.any()


def test_closure_is_lost_when_a_boat_leaves_and_counted():
    params = make_params("approach", hold_time=100.0)
    sim = begun_at(params, in_slots(params))
    step(sim)
    assert sim.state.closed.all()
    for _ in range(50):
        step(sim, [(0, 0), (-0.5, 0), (0, 0), (0, 0)])
    assert not sim.state.closed.any()
    assert sim.summary()["closure_lost"] == 1


# ------------------------------------------------------------------ ends


def test_approach_does_not_care_about_the_goal():
    assert not step(begun(make_params("approach", goal=(0, 0, 0)))).ending.terminated.any()


@pytest.mark.parametrize("body", [0, 1, 4])
def test_body_that_leaves_the_arena_ends_the_episode_as_a_failure(body):
    params = make_params()
    motion = bodies((), (1, 1), (1, -1), (-1, 1), (-1, -1))
    motion[body] = (0, -2.99, 0, 0, -0.2, 0)
    sim = begun_at(params, motion)
    ending = step(sim).ending
    assert ending.strayed.all()
    assert ending.terminated.all()
    assert not (ending.truncated | ending.reached).any()
    assert not sim.summary()["is_success"].any()


def test_delivery_with_a_body_outside_the_arena_is_a_failure():
    params = make_params(goal=(0, 0, 0))
    motion = bodies((), (0, -2.99, 0, 0, -0.2), (1, -1), (-1, 1), (-1, -1))
    ending = step(begun_at(params, motion)).ending
    assert ending.strayed.all()
    assert not ending.reached.any()


def test_time_limit_truncates_and_does_not_terminate():
    sim = begun(make_params(time_limit=2.0))
    endings = [step(sim).ending for _ in range(20)]
    assert not any(e.terminated.any() or e.truncated.any() for e in endings[:-1])
    assert endings[-1].truncated.all()
    assert not endings[-1].terminated.any()


def test_end_at_the_time_limit_is_a_termination():
    yes, no = np.ones(1, dtype=bool), np.zeros(1, dtype=bool)
    for ending in (Ending(yes, no, yes), Ending(no, yes, yes)):
        assert ending.terminated.all()
        assert not ending.truncated.any()


# ------------------------------------------------------------------ failures and anchors

FAILS_AT_1_S = {"variation": {"failures": 1, "failure_time": (1.0, 1.0)}}


def test_thrusters_of_one_boat_die_at_the_drawn_time():
    sim = begun(make_params(action_mode="thrusters", **FAILS_AT_1_S))
    working, thrust = [], []
    for _ in range(20):
        step(sim, 1.0)
        working.append(sim.state.working[0].copy())
        thrust.append(sim.state.thrust[0, :, 0].copy())
    dead = np.flatnonzero(~working[-1])
    assert len(dead) == 1
    assert [flags.all() for flags in working] == [True] * 9 + [False] * 11
    fading = np.array(thrust)[9:, dead[0]]
    np.testing.assert_allclose(fading[1:] / fading[:-1], np.exp(-1), rtol=1e-6)
    np.testing.assert_allclose(np.delete(thrust[-1], dead), 0.010, rtol=1e-3)


def test_slots_are_shared_out_among_those_that_work():
    params = make_params(num_boats=5, **FAILS_AT_1_S)
    sim = begun(params)
    for _ in range(10):
        step(sim)
    working = sim.state.working[0]
    slots, boats = sim.state.slot[0], sim.state.motion[0, 1:, :2] @ [1, 1j]
    points = formation.slots(params, 4)
    assert sorted(slots[working].real) == approx(sorted(points.real))
    assert np.abs(boats - slots)[working].sum() == approx(least_way(boats[working], points))


def test_failures_come_at_any_time_between_5_and_60_s_to_any_boat():
    params, rng = make_params(scenario="failure"), np.random.default_rng(0)
    ticks = np.array([starts.sample(params, rng).failure_tick for _ in range(400)])
    assert ((ticks >= 0).sum(axis=1) == 1).all()
    when = ticks.max(axis=1)
    assert 50 <= when.min() < 70
    assert 580 < when.max() <= 600
    assert when.mean() == approx(325, rel=0.05)
    np.testing.assert_allclose((ticks >= 0).mean(axis=0), 0.25, atol=0.08)


def test_failed_boat_that_drifts_about_does_not_keep_the_others_from_succeeding():
    params = make_params("approach", slot_distance=5.0, slot_angle=np.pi)
    motion = bodies((), (0.7, 0, 0, 0.2), (0, 1), (0, -1), (-1, 0))
    hale = begun_at(params, motion)
    failed = begun_at(params, motion, failure_tick=np.array([2, -1, -1, -1]))
    endings = [[step(sim).ending.reached[0] for _ in range(12)] for sim in (hale, failed)]
    assert endings[0] == [False] * 12
    assert endings[1] == [False] * 11 + [True]


def test_goal_anchored_at_closure_is_taken_from_where_the_vessel_is_then():
    params = make_params(goal=(0.5, -0.9, 0.2), goal_anchor="closure")
    sim = begun_at(params, in_slots(params, (0.3, 0.1, 0.7)))
    np.testing.assert_allclose(sim.state.goal[0], (0.5, -0.9, 0.2))
    step(sim)
    x, y, h = sim.state.motion[0, 0, :3]
    point = x + 1j * y + np.exp(1j * h) * (0.5 - 0.9j)
    np.testing.assert_allclose(sim.state.goal[0], (point.real, point.imag, h + 0.2), atol=1e-9)


def test_anchored_goal_stays_where_it_is():
    params = make_params(goal=(0.5, -0.9, 0.2), goal_anchor="closure")
    sim = begun_at(params, in_slots(params, (0.3, 0.1, 0.7)))
    step(sim)
    goal = sim.state.goal.copy()
    for _ in range(20):
        step(sim, AHEAD)
    np.testing.assert_array_equal(sim.state.goal, goal)


def test_goal_that_is_not_yet_anchored_cannot_be_reached():
    params = make_params(goal=(0.5, -0.9, 0), goal_anchor="closure")
    sim = begun_at(params, bodies((0.5, -0.9), (2, 2), (2, -2), (-2, 2), (-2, -2)))
    assert not step(sim).ending.reached.any()


def test_errors_before_the_goal_is_anchored_do_not_count_as_the_smallest():
    params = make_params(goal=(0.3, 0.1, 1.0), goal_anchor="closure")
    sim = begun_at(params, in_slots(params, (0.3, 0.1, 0.7)))
    for _ in range(5):
        step(sim)
    assert sim.state.anchored.all()
    assert sim.summary()["position_error"] > 0.25
    assert sim.summary()["min_position_error"] > 0.25


# ------------------------------------------------------------------ reward


def random_walk(params, ticks, num_worlds=2, hold=5, seed=0):
    """A simulation after random actions, and what every step gave back."""
    sim, rng = begun(params, num_worlds), np.random.default_rng(seed)
    before = reward.evaluated(sim.state, params).potential
    steps = []
    for tick in range(ticks):
        if tick % hold == 0:
            action = rng.uniform(-1, 1, sim.state.thrust.shape)
        steps.append(step(sim, action))
    return sim, before, steps


@pytest.mark.parametrize("task", ["approach", "push", "transport"])
def test_reward_is_the_sum_of_its_terms(task):
    sim, _, steps = random_walk(make_params(task, scenario="gyre"), 20)
    for done in steps:
        total = sum(np.broadcast_to(term, done.reward.shape) for term in done.terms.values())
        np.testing.assert_allclose(done.reward, total, atol=1e-15)
    returns = sum(done.reward.mean(axis=1) for done in steps)
    np.testing.assert_allclose(sim.summary()["episode_return"], returns)


def test_progress_terms_sum_to_the_difference_of_their_potentials():
    params = make_params(scenario="gyre")
    sim, before, steps = random_walk(params, 150)
    after = reward.evaluated(sim.state, params).potential
    for column, name in enumerate(("closure", "delivery", "precision")):
        gained = sum(done.terms[name][:, 0] for done in steps)
        risen = after[:, column] - before[:, column]
        np.testing.assert_allclose(gained, getattr(params.reward, name) * risen, atol=1e-9)
        assert np.abs(gained).max() > 0


def way(x, y, turn, side=1.0, size=1.0):
    """Way to a goal in the vessel's frame that is turned against it."""
    turned = np.angle(np.exp(1j * turn))
    return laws.cost_to_go(complex(x, y), -turned, side, size)


RADIAN, SIDEWAYS = laws.HEADING_WEIGHT, laws.SIDEWAYS


@pytest.mark.parametrize(
    ("goal", "length"),
    [
        ((0, 0, 0), 0.0),
        ((0, -1, 0), 1.0),  # straight ahead
        ((0, 0, 0.7), 0.7 * RADIAN),  # on the spot
        ((1, 0, 0), 1.0 + np.pi * RADIAN),  # a right angle there, and back again
        ((1, 0, np.pi / 2), 1.0 + np.pi / 2 * RADIAN),  # turned already as it goes
        ((0, 1, 0), 1.0 + 2 * np.pi * RADIAN),  # behind
        ((0.05, 0, 0), 0.05 * SIDEWAYS),  # near: as it is
        ((0.05, 0, 0.2), 0.05 * SIDEWAYS + 0.2 * RADIAN),
    ],
)
def test_the_way_to_goals_of_which_it_is_known(goal, length):
    assert way(*goal) == pytest.approx(length, abs=1e-12)
    x, y, turn = goal
    assert way(x, -y, -turn, side=-1.0) == pytest.approx(length, abs=1e-12)
    assert way(3 * x, 3 * y, turn, size=3.0) == pytest.approx(3 * length, abs=1e-12)


@given(
    goal=st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-4, 4)),
    step=st.tuples(*[st.floats(-1e-4, 1e-4)] * 3),
)
def test_the_way_falls_no_faster_than_the_vessel_moves(goal, step):
    """Also where it goes over from the one way to the other: nothing is gained at once."""
    moved = np.add(goal, step)
    far = SIDEWAYS * np.hypot(*step[:2]) + RADIAN * abs(step[2])
    # A turn of the bearing is a step over the distance, which is the larger the nearer it is; but
    # nearer than this the straight way is the shorter one.
    far += 2 * RADIAN * np.hypot(*step[:2]) / max(np.hypot(*goal[:2]) - 1e-4, 1e-3)
    assert abs(way(*moved) - way(*goal)) <= far + 1e-9


@given(bearing=st.floats(-1.5, 1.5), distance=st.floats(0.4, 1.2), turn=st.floats(-3, 3))
def test_the_first_turn_is_a_step_forward(bearing, distance, turn):
    """Where a plain distance with its turn would often call it a step back."""
    goal = -1j * distance * np.exp(1j * bearing)
    before = way(goal.real, goal.imag, turn)
    part = 0.5 * bearing
    seen = goal * np.exp(-1j * part)
    assert way(seen.real, seen.imag, turn - part) <= before + 1e-9


def judged(params, before, after, reached=False, strayed=False, tick=1, distance=0.0):
    """Weighted terms of one tick between two potentials (3,), of idle boats; and their sums."""
    happened = payment.Happened(
        np.array([reached]), np.array([strayed]), np.array([tick]),
        np.zeros((1, 4, 2)), np.zeros((1, 4, 2), bool), np.zeros(1, bool),
    )  # fmt: skip
    paid, weight = reward.blank_payments(1, 4), reward.Terms(reward.TERMS, params).weight
    worth = payment.Worth(np.reshape(after, (1, 3)), np.array([[distance, 0.0]]))
    changes = np.reshape(before, (1, 3)), worth
    payment.pay(0, *changes, happened, payment.prices(params), weight, paid)
    columns = {term.name: term.column for term in reward.TERMS}
    found = np.concatenate([np.tile(paid.shared, (4, 1)), paid.own[0]], axis=1)
    return {name: found[:, column] for name, column in columns.items()}, paid.reward[0]


potentials = st.tuples(st.floats(-50, 0), st.floats(-50, 0), st.floats(0, 1))


@given(
    before=potentials,
    after=potentials,
    strayed=st.booleans(),
    tick=st.integers(1, 1800),
    distance=st.floats(0, 1),
)
def test_every_term_is_bounded(before, after, strayed, tick, distance):
    params = make_params()
    terms, _ = judged(params, before, after, not strayed, strayed, tick, distance)
    weight, second = params.reward, 1 / params.clock.control
    bounds = {
        "closure": weight.closure,
        "delivery": weight.delivery,
        "precision": weight.precision,
        "success": weight.success,
        "strayed": weight.strayed + weight.time * params.task.time_limit,
        "time": weight.time * second,
        "effort": weight.effort * second,
        "collision": weight.collision * second,
    }
    assert set(terms) == set(bounds)
    assert all(np.abs(terms[name]).max() <= bounds[name] + 1e-12 for name in bounds)


@given(tick=st.integers(1, 1799), at=potentials)
def test_straying_is_worse_than_running_out_of_time(tick, at):
    params = make_params()
    _, strays = judged(params, at, at, strayed=True, tick=tick)
    _, idles = judged(params, at, at, tick=tick)
    assert np.all(strays < idles * (1801 - tick) - 1)


def test_way_out_of_the_arena_earns_less_than_waiting():
    params = make_params(arena=2.0, time_limit=20.0)
    returns = {}
    for name, action in (("waits", 0.0), ("strays", (1.0, 0.0))):
        sim = begun(params)
        while not (ending := step(sim, action).ending).terminated[0] and not ending.truncated[0]:
            pass
        assert ending.strayed[0] == (name == "strays")
        returns[name] = sim.summary()["episode_return"][0]
    assert returns["strays"] < returns["waits"]


def test_success_pays_and_straying_costs_what_their_weights_say():
    params = make_params(reward={"success": 7.0, "accuracy": 0.5, "strayed": 3.0, "time": 0.1})
    at = (-1.0, -1.0, 0.0)
    assert judged(params, at, at, reached=True)[0]["success"] == approx(7.0)
    assert judged(params, at, at, reached=True, distance=1.0)[0]["success"] == approx(3.5)
    late, _ = judged(params, at, at, strayed=True, tick=1800)
    assert late["strayed"] == approx(-3.0)
    early, _ = judged(params, at, at, strayed=True, tick=800)
    assert early["strayed"] == approx(-3.0 - 0.01 * 1000)


def test_effort_is_the_boats_own():
    sim = begun(make_params(action_mode="thrusters"))
    for _ in range(20):
        done = step(sim, [(0, 0), (1, 1), (0.5, 0), (0, 0)])
    assert done.terms["effort"][0] == approx([0, -0.0001, -0.0000125, 0], rel=1e-3)
    others = {name: term for name, term in done.terms.items() if name != "effort"}
    assert all(np.ptp(np.broadcast_to(term, (1, 4))) == 0 for term in others.values())


def test_collision_is_of_those_that_collide():
    params = make_params()
    sim = begun_at(params, bodies((), (1, 1), (1, 1.064), (-1, 1), (-1, -1)))
    terms = step(sim).terms
    assert terms["collision"][0] == approx([-0.001, -0.001, 0, 0])
    assert sim.summary()["collisions"] == 2


def test_touching_the_vessel_is_no_collision():
    params = make_params("push")
    sim = begun_at(params, in_slots(params, gap=-1e-4))
    terms = step(sim).terms
    assert sim.state.touching[0, 1:3, 0].all()
    assert not terms["collision"].any()


def test_change_of_slots_pays_nothing():
    sim = begun(make_params(**FAILS_AT_1_S))
    terms = [step(sim).terms["closure"] for _ in range(15)]
    assert not sim.state.working.all()
    np.testing.assert_allclose(terms, 0, atol=1e-12)


def test_anchoring_of_the_goal_pays_nothing():
    params = make_params(goal=(0.5, -0.9, 0.2), goal_anchor="closure")
    sim = begun_at(params, in_slots(params, (0.3, 0.1, 0.7)))
    terms = [step(sim).terms for _ in range(5)]
    assert sim.state.anchored.all()
    for name in ("delivery", "precision"):
        np.testing.assert_allclose([term[name] for term in terms], 0, atol=1e-9)


def test_reward_is_of_the_truth_not_of_the_measurement():
    _, _, exact = random_walk(make_params(), 30)
    _, _, noisy = random_walk(make_params(scenario="noisy"), 30)
    assert np.abs(exact[-1].observation - noisy[-1].observation).max() > 0.01
    for done, blurred in zip(exact, noisy, strict=True):
        np.testing.assert_array_equal(done.reward, blurred.reward)


# ------------------------------------------------------------------ observation


@pytest.mark.parametrize("team", [2, 3, 4, 10, 100])
def test_observation_has_the_same_size_for_every_team(team):
    seen = begun(make_params(num_boats=team)).reset()
    assert seen.shape == (1, team, len(observation.BOUND))
    assert seen.dtype == np.float32


numbers = st.floats(-1e5, 1e5)


@given(st.lists(numbers, min_size=30, max_size=30), st.tuples(numbers, numbers, numbers))
@pytest.mark.parametrize("scenario", ["nominal", "harsh"])
def test_observation_is_bounded_for_any_state(scenario, motion, goal):
    sim = Simulation(make_params(scenario=scenario))
    seen = begin_at(sim, [np.reshape(motion, (5, 6))], goal=np.array(goal))
    assert np.isfinite(seen).all()
    assert np.all(np.abs(seen) <= observation.BOUND)


def test_observation_is_not_clipped_in_the_run_of_things():
    _, _, steps = random_walk(make_params(), 50)
    seen = np.array([done.observation for done in steps])
    clipped = np.abs(seen) >= observation.BOUND
    bounds_met = clipped.any(axis=(0, 1, 2)) & (observation.BOUND > 1)
    assert not bounds_met.any()


GOAL = np.array([0.6, -0.8, 0.4])


def seen_from(params, angle=0.0, shift=0j, order=(0, 1, 2, 3), action=0.0, ticks=3):
    """Observations (T + 1, A, K) in a world turned, moved, and with its boats in some order."""
    motion = bodies((0.1, 0, 0.3, 0.01, -0.02, 0.1), *np.random.default_rng(3).normal(size=(4, 6)))
    motion[1:, 3:] *= 0.1
    motion[1:] = motion[1:][list(order)]
    sim = Simulation(params)
    turn = {"goal": turned(GOAL, angle, shift)}
    first = begin_at(sim, [turned(motion, angle, shift)], **turn)
    action = np.broadcast_to(action, (4, 2))[list(order)]
    return np.array([first[0]] + [step(sim, action).observation[0] for _ in range(ticks)])


@pytest.mark.parametrize("angle", [0.0, 0.9, np.pi, -2.5])
@pytest.mark.parametrize("shift", [0j, 0.7 - 1.1j])
def test_turning_and_moving_the_whole_world_changes_no_observation(angle, shift):
    params = make_params(arena=10.0)
    action = np.random.default_rng(1).uniform(-1, 1, (4, 2))
    here = seen_from(params, action=action)
    there = seen_from(params, angle, shift, action=action)
    np.testing.assert_allclose(there, here, atol=2e-5)


@pytest.mark.parametrize("order", [(0, 2, 1, 3), (0, 3, 1, 2), (0, 3, 2, 1)])
def test_order_of_the_others_changes_nothing_for_a_boat(order):
    params = make_params(arena=10.0)
    action = np.random.default_rng(1).uniform(-1, 1, (4, 2))
    plain = seen_from(params, action=action)
    mixed = seen_from(params, order=order, action=action)
    np.testing.assert_allclose(mixed, plain[:, list(order)], atol=1e-5)


def of_neighbours(seen):
    """Columns (W, A, 4, 5) of the neighbours in a default observation: x, y, vx, vy, present."""
    first = observation.NAMES.index("neighbour_1_x")
    return seen[..., first : first + 20].reshape(*seen.shape[:2], 4, 5)


def test_absent_neighbours_are_zero_and_marked():
    pair, team = (of_neighbours(begun(make_params(num_boats=n)).reset())[0] for n in (2, 10))
    assert (pair[:, 1:] == 0).all()
    np.testing.assert_array_equal(pair[:, 0, -1], 1)
    np.testing.assert_array_equal(team[..., -1], 1)


def test_nearest_boats_come_first():
    places = of_neighbours(begun(make_params(num_boats=10), 20).reset())[..., :2]
    distances = np.hypot(places[..., 0], places[..., 1])
    assert np.all(np.diff(distances, axis=-1) >= 0)


def test_observation_changes_with_all_that_a_boat_must_know():
    params = make_params(arena=10.0)
    plain = seen_from(params, ticks=0)
    for body, column in [(0, 0), (0, 2), (0, 3), (0, 5), (1, 1), (1, 2), (1, 4), (1, 5), (2, 0)]:
        sim = Simulation(params)
        motion = bodies(
            (0.1, 0, 0.3, 0.01, -0.02, 0.1), *np.random.default_rng(3).normal(size=(4, 6))
        )
        motion[1:, 3:] *= 0.1
        motion[body, column] += 0.01
        assert np.abs(begin_at(sim, [motion], goal=GOAL)[0, 0] - plain[0, 0]).max() > 1e-4


def column(name):
    return observation.NAMES.index(name)


@pytest.mark.parametrize("turn", [-0.07, 0.03, 0.6, np.pi - 0.01])
def test_what_counts_at_the_goal_is_magnified(turn):
    """A hundredth of a radian, a millimetre a second: a tenth and more of a feature's range."""
    motion = bodies((0.1, 0, 0.3, 0.01, -0.02, 0.1), *np.random.default_rng(3).normal(size=(4, 6)))
    goal = np.array([0.6, -0.8, 0.3 + turn])
    seen = begin_at(Simulation(make_params(arena=10.0)), [motion], goal=goal)[0, 0]
    velocity = (0.01 - 0.02j) * np.exp(-0.3j)
    magnified = {
        "turn_to_goal_fine": np.clip(turn / 0.1, -1, 1),
        "vessel_yaw_rate_fine": 0.1 / 0.15,
        "vessel_velocity_fine_x": velocity.real / 0.04,
        "vessel_velocity_fine_y": velocity.imag / 0.04,
    }
    for name, expected in magnified.items():
        assert seen[column(name)] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("team", [2, 4, 8, 32])
def test_a_boat_knows_the_sizes_of_its_team_and_of_the_vessel(team):
    failure = {"failures": 1, "failure_time": (0.1, 0.1)}
    params = make_params(num_boats=team, variation=failure)
    sim = begun(params)
    seen = sim.reset()[0]
    after = step(sim, 0.0).observation[0]
    size = column("inverse_team_size")
    np.testing.assert_allclose(seen[:, size], 2 / team)
    np.testing.assert_allclose(after[:, size], 2 / (team - 1))
    length = column("inverse_vessel_length")
    np.testing.assert_allclose(after[:, length], 0.4 / params.vessel.length, rtol=1e-6)


# ------------------------------------------------------------------ noise


def watched(params, ticks=60, num_worlds=48):
    """Errors (T, W, B, 6) of measurement and estimate while the boats go about."""
    sim, rng = begun(params, num_worlds), np.random.default_rng(0)
    errors = {"measured": [], "estimate": []}
    for tick in range(ticks):
        if tick % 10 == 0:
            action = rng.uniform(-1, 1, sim.state.thrust.shape)
        step(sim, action)
        for name, found in errors.items():
            error = getattr(sim.sensed, name) - sim.state.motion
            error[..., 2] = wrap(error[..., 2])
            found.append(error)
    return np.array(errors["measured"]), np.array(errors["estimate"])


@pytest.fixture(scope="module")
def noisy_errors():
    return watched(make_params(scenario="noisy"))


def test_measurement_has_the_noise_asked_for(noisy_errors):
    spread = noisy_errors[0].reshape(-1, 6).std(axis=0)
    np.testing.assert_allclose(spread, [0.01, 0.01, 0.05, 0.01, 0.01, 0.1], rtol=0.03)
    assert np.abs(noisy_errors[0].reshape(-1, 6).mean(axis=0) / spread).max() < 0.04


def test_noise_is_fresh_at_every_tick_and_of_every_hull(noisy_errors):
    error = noisy_errors[0] / noisy_errors[0].std(axis=(0, 1, 2))
    assert abs((error[1:] * error[:-1]).mean()) < 0.02
    assert abs((error[:, :, 1:] * error[:, :, :-1]).mean()) < 0.02
    assert abs((error[:, 1:] * error[:, :-1]).mean()) < 0.02


def test_estimate_is_better_than_the_measurement(noisy_errors):
    measured, estimate = (np.sqrt((e[20:] ** 2).mean(axis=(0, 1, 2))) for e in noisy_errors)
    assert np.all(estimate < 0.9 * measured)


def test_sensing_without_noise_is_exact():
    sim, _, _ = random_walk(make_params(), 10)
    np.testing.assert_array_equal(sim.sensed.measured, sim.state.motion)
    np.testing.assert_array_equal(sim.sensed.estimate, sim.state.motion)


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("position_noise", [0, 1]),
        ("heading_noise", [2]),
        ("speed_noise", [3, 4]),
        ("yaw_rate_noise", [5]),
    ],
)
def test_each_noise_blurs_what_it_is_named_for(name, columns):
    measured, _ = watched(make_params(sensors={name: 0.02}), ticks=20, num_worlds=8)
    blurred = measured.std(axis=(0, 1, 2)) > 1e-6
    assert np.flatnonzero(blurred).tolist() == columns


def test_noise_does_not_move_anything():
    noisy, _, _ = random_walk(make_params(scenario="noisy"), 20)
    exact, _, _ = random_walk(make_params(), 20)
    np.testing.assert_array_equal(noisy.state.motion, exact.state.motion)


def test_measured_headings_are_wrapped():
    params = make_params(sensors={"heading_noise": 1.0})
    sim = begun(params, 50)
    for _ in range(5):
        step(sim)
        for motion in (sim.sensed.measured, sim.sensed.estimate):
            assert np.abs(motion[..., 2]).max() <= np.pi


# ------------------------------------------------------------------ metrics


def held_plainly(params, motion, slot):
    """(A,) whether each boat of one world holds its slot on the +n side, boat by boat."""
    x, y, h, vx, vy, r = motion[0]
    held = []
    for boat, place in zip(motion[1:], slot, strict=True):
        px = x + place.real * np.cos(h) - place.imag * np.sin(h)
        py = y + place.real * np.sin(h) + place.imag * np.cos(h)
        off = np.hypot(boat[0] - px, boat[1] - py)
        turn = (boat[2] - (h - np.pi / 2) + np.pi) % (2 * np.pi) - np.pi
        dx, dy = boat[0] - x, boat[1] - y
        slip = np.hypot(boat[3] - vx + r * dy, boat[4] - vy - r * dx)
        held.append(off < 0.03 and abs(turn) < 0.3 and slip < 0.02)
    return np.array(held)


@pytest.fixture(scope="module")
def pushed():
    """Params, summary, simulation and records of a vessel grasped by late boats, then pushed."""
    params = make_params(goal=(0.15, -0.22, 0.6))
    motion = in_slots(params)
    motion[[2, 4], 1] += 0.15, 0.10
    sim = begun_at(params, motion)
    records = [(sim.state.motion[0].copy(), sim.state.thrust[0].copy(), 0.0)]
    slow, stop = (0.3, 0.0), (0.0, 0.0)
    for tick in range(200):
        last = slow if sim.state.motion[0, 4, 1] > 0.02 else stop
        action = [stop, slow, stop, last] if tick < 60 else [slow, slow, (0.1, 0.0), slow]
        done = step(sim, action)
        records.append((sim.state.motion[0].copy(), sim.state.thrust[0].copy(), done.reward))
        assert not done.ending.terminated.any()
    return params, {name: value[0] for name, value in sim.summary().items()}, sim, records


def test_path_length_is_that_of_the_recorded_way(pushed):
    _, summary, _, records = pushed
    way = np.array([motion[0, :2] for motion, _, _ in records])
    assert summary["path_length"] == approx(np.hypot(*np.diff(way, axis=0).T).sum())
    assert summary["path_length"] > 0.2


def test_errors_are_those_of_the_recorded_way(pushed):
    params, summary, _, records = pushed
    goal = np.array(params.task.goal)
    off = np.array([motion[0, :3] - goal for motion, _, _ in records])
    distance = np.hypot(off[:, 0], off[:, 1])
    nearest = int(distance.argmin())
    assert 0 < nearest < len(records) - 1
    assert summary["min_position_error"] == approx(distance[nearest])
    assert summary["heading_error_at_min"] == approx(off[nearest, 2])
    assert summary["position_error"] == approx(distance[-1])
    assert summary["heading_error"] == approx(off[-1, 2])


def test_closure_times_are_those_of_the_record(pushed):
    params, summary, sim, records = pushed
    held = [held_plainly(params, motion, sim.state.slot[0]) for motion, _, _ in records[1:]]
    arrivals = 1 + np.argmax(held, axis=0)
    closure = 1 + int(np.argmax(np.all(held, axis=1)))
    assert np.any(held, axis=0).all()
    assert summary["time_to_closure"] == approx(closure / 10)
    assert summary["closure_spread"] == approx((arrivals.max() - arrivals.min()) / 10)
    assert summary["closure_spread"] > 1


def test_effort_is_the_mean_time_at_full_thrust(pushed):
    _, summary, _, records = pushed
    thrust = np.array([thrust for _, thrust, _ in records[1:]])
    assert summary["effort"] == approx(np.abs(thrust / 0.010).mean() * len(thrust) / 10)


def test_return_is_the_sum_of_the_mean_rewards(pushed):
    _, summary, _, records = pushed
    assert summary["episode_return"] == approx(sum(np.mean(paid) for _, _, paid in records[1:]))


def test_what_never_came_has_no_time():
    summary = random_walk(make_params(), 5)[0].summary()
    for name in ("time_to_closure", "closure_spread", "time_to_goal"):
        assert np.isinf(summary[name]).all()


def test_collision_is_counted_when_it_begins_not_while_it_lasts():
    params = make_params(action_mode="thrusters")
    sim = begun_at(params, bodies((), (1, 1, 0), (1.16, 1, np.pi), (-1, 1), (-1, -1)))
    for _ in range(60):
        step(sim, [(1, 1), (1, 1), (0, 0), (0, 0)])
    assert sim.state.touching[0, :2, 1].all()
    assert sim.summary()["collisions"] == 2


def test_metrics_begin_anew_with_each_episode():
    sim, _, _ = random_walk(make_params(), 40)
    assert (sim.summary()["effort"] > 0).all()
    sim.reset(np.array([True, False]))
    summary = sim.summary()
    assert (summary["effort"] > 0).tolist() == [False, True]
    assert summary["path_length"][0] == summary["episode_return"][0] == 0


@pytest.mark.parametrize(("side", "ahead"), [("+n", [-1j]), ("-n", [1j]), ("goal", [-1j, 1j])])
def test_goals_are_sampled_where_the_team_pushes(side, ahead):
    params = make_params(
        "push", side=side, goal_bearing=0.4, goal_turn=0.3, goal_distance=(0.2, 0.5)
    )
    rng = np.random.default_rng(0)
    goals = np.array([starts.sample(params, rng).goal for _ in range(300)])
    place = goals[:, 0] + 1j * goals[:, 1]
    off = np.array([abs(np.angle(place / one)) for one in ahead]).min(axis=0)
    assert 0.38 < off.max() <= 0.4
    assert 0.28 < abs(goals[:, 2]).max() <= 0.3
    # Uniform by area: the mean of the square lies in the middle.
    assert (abs(place) ** 2).mean() == approx((0.2**2 + 0.5**2) / 2, rel=0.07)
    assert (abs(place) >= 0.2).all()
    assert len(ahead) == len({round(y) for y in np.sign(place.imag)})
