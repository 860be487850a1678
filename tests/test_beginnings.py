"""Worlds that are accepted can begin, and those that cannot are refused when they are made."""

import math
from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import ks_2samp

import asv_env
from asv_env import Simulation, make_params
from asv_env.checks import FunctionError
from asv_env.tasks import APPROACH, PUSH, TRANSPORT, starts
from asv_env.tasks.initial_state import checked
from asv_env.types import InitialState


def start(params, seed=0):
    return starts.sample(params, np.random.default_rng(seed))


def distances(params, seeds=range(20)):
    """Distances of goals (n,) and boats (n, A) from the vessel at the beginning."""
    some = [start(params, seed) for seed in seeds]
    goals = np.array([np.hypot(*one.goal[:2]) for one in some])
    return goals, np.array([np.hypot(*one.motion[1:, :2].T) for one in some])


# ------------------------------------------------------------------ goals


def faces(**options):
    """The ways to reset to a goal."""
    joint = gym.make("asv_env/Push-v0", **options)
    vector = gym.make_vec("asv_env/Push-v0", num_envs=2, **options)
    parallel = asv_env.parallel_env("push", **options)
    for env in (joint, vector, parallel):
        yield lambda goal, env=env: env.reset(options={"goal": goal})
    yield lambda goal: Simulation(make_params("push", **options)).reset(goal=goal)
    yield lambda goal: make_params("push", goal=goal, **options)
    yield lambda goal: replace(make_params("push", **options).task, goal=goal)


@pytest.mark.parametrize("goal", [(1.5, 0, 0), (0, -0.99, 0.0), (0.9, 0, 0), (0.7, 0.7, math.nan)])
def test_goal_in_or_beyond_the_walls_is_refused_everywhere(goal):
    *ways, _ = faces(water={"walls": 1.0})
    for way in ways:
        with pytest.raises(ValueError, match=r"goal = .*(walls at 1 m|finite)"):
            way(goal)


@pytest.mark.parametrize("goal", [(3.01, 0, 0), (0, -1e9, 0), "home", None, (1, 2), [[0, 0, 0]]])
def test_goal_outside_the_arena_or_malformed_is_refused_everywhere(goal):
    for way in faces():
        if goal is not None:
            with pytest.raises(ValueError, match="goal = "):
                way(goal)


def test_vessel_may_reach_the_walls_as_far_as_the_tolerance_of_its_place():
    params = make_params("push", water={"walls": 1.0})
    tip = 1.0 - params.vessel.length / 2
    sideways = 1.0 - params.vessel.width / 2
    for goal in [(tip + 0.049, 0, 0), (0, sideways + 0.049, 0), (sideways, tip, math.pi / 2)]:
        assert params.checked_goal(goal)[:2] == goal[:2]
    for goal in [(tip + 0.051, 0, 0), (0, sideways + 0.051, math.pi), (tip, 0, math.pi / 4)]:
        if not params.goal_fits(goal):
            with pytest.raises(ValueError, match="walls"):
                params.checked_goal(goal)
    assert not params.goal_fits((tip + 0.051, 0, 0))
    assert replace(params, water=replace(params.water, walls=None)).goal_fits((9.0, 9.0, 0.0))


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10**6),
    tolerance=st.sampled_from([1e-3, 0.05]),
    aspect=st.sampled_from([1.0, 2.0]),
)
def test_goal_that_was_sampled_can_be_given(seed, tolerance, aspect):
    vessel = {"length": 0.4, "width": 0.4 / aspect}
    params = make_params(preset="tank", position_tolerance=tolerance, vessel=vessel)
    goal = start(params, seed).goal
    np.testing.assert_allclose(params.checked_goal(goal), goal)


RINGS = [(0.8, 0.8), (0.8, 0.8 + 1e-9), (0.8, 0.80001), (2.8, 2.8), (3.9, 3.95), (2.5, 1e5)]
RINGS += [(0.0, 0.0), (1e-9, 1e-9)]


@pytest.mark.parametrize("ring", RINGS)
def test_goals_lie_in_the_ring_however_narrow_it_is(ring):
    params = make_params("push", goal_distance=ring)
    goals, _ = distances(params)
    assert (goals >= ring[0] * (1 - 1e-12)).all()
    assert (goals <= ring[1] * (1 + 1e-12)).all()
    poses = np.array([start(params, seed).goal for seed in range(20)])
    assert np.abs(poses[:, :2]).max() <= 2.8 * (1 + 1e-12)
    assert len({tuple(pose) for pose in poses}) == 20
    if ring[0] > 0:
        assert len(set(map(tuple, np.sign(poses[:, :2])))) == 4


def test_goals_of_a_narrow_ring_are_uniform():
    rng, near, far, bound = np.random.default_rng(0), 0.9, 1.3, 1.0
    thin = np.array([starts._in_ring(rng, near, far, bound) for _ in range(4000)])
    wide = rng.uniform(-bound, bound, (40_000, 2)) @ [1, 1j]
    wide = wide[(np.abs(wide) >= near) & (np.abs(wide) <= far)]
    for values in (np.abs, np.angle):
        assert ks_2samp(values(thin), values(wide)).pvalue > 0.01


@pytest.mark.parametrize("walls", [None, 1.3, 2.0, 50.0])
def test_episodes_begin_within_arena_and_walls_whichever_is_nearer(walls):
    options = {"arena": 1.5, "goal_distance": (0.0, 9.0), "start_distance": (0.5, 9.0)}
    params, nearer = make_params(water={"walls": walls}, **options), min(walls or 1.5, 1.5)
    some = [start(params, seed) for seed in range(60)]
    assert 0.7 * nearer < max(np.abs(one.goal[:2]).max() for one in some) < nearer
    assert 0.7 * nearer < max(np.abs(one.motion[:, :2]).max() for one in some) < nearer


@pytest.mark.parametrize("ring", [(4.0, 4.0), (3.97, 9.0)])
def test_goals_out_of_reach_are_refused_when_the_world_is_made(ring):
    with pytest.raises(ValueError, match="goal_distance"):
        make_params("push", goal_distance=ring)


# ------------------------------------------------------------------ boats

CROWDED = [
    {"start_distance": (0.8, 0.8)},
    {"start_distance": (1.0, 1.0), "start_spacing": 11.7},
    {"start_spacing": 12.0},
    {"start_distance": (4.0, 4.07)},
    {"start_distance": (3.9, 1e4)},
    {"num_boats": 30, "start_distance": (1.3, 1.4), "start_spacing": 1.0},
]


@pytest.mark.parametrize("options", CROWDED, ids=repr)
def test_boats_that_just_fit_begin_apart_in_their_ring(options):
    params = make_params("approach", **options)
    near, far = params.task.start_distance
    apart = params.task.start_spacing * params.boat.length
    for seed in range(5):
        boats = start(params, seed).motion[1:, :2] @ [1, 1j]
        assert (np.abs(boats) >= near * (1 - 1e-9)).all()
        assert (np.abs(boats) <= far * (1 + 1e-9)).all()
        assert np.abs([boats.real, boats.imag]).max() <= params.task.arena - params.boat.length
        gaps = np.abs(boats[:, None] - boats)[~np.eye(len(boats), dtype=bool)]
        assert gaps.min() >= apart * (1 - 1e-9)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"start_spacing": 20.0}, "start_spacing"),
        ({"num_boats": 2, "start_spacing": 100.0}, "start_spacing"),
        ({"start_distance": (4.2, 5.0)}, "start_distance"),
        ({"start_distance": (0.01, 0.1)}, "start_distance"),
        ({"arena": 0.4}, "arena"),
        ({"water": {"walls": 0.45}}, "walls"),
        ({"num_boats": 40, "start_distance": (3.0, 3.0), "start_spacing": 5.0}, "start_spacing"),
        ({"preset": "tank", "num_boats": 30}, "start_distance"),
        ({"preset": "tank", "goal_distance": (2.0, 3.0)}, "goal_distance"),
        ({"water": {"walls": 1.0}, "vessel": {"length": 1.0}}, "walls"),
    ],
)
@pytest.mark.parametrize("task", ["approach", "transport"])
def test_boats_without_a_place_are_refused_when_the_world_is_made(task, options, named):
    with pytest.raises(ValueError, match=named):
        make_params(task, **options)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"arena": 0.2}, "arena"),
        ({"end_gap": 3.0}, "end_gap"),
        ({"preset": "tank", "vessel": {"length": 3.1}}, "walls|arena"),
        ({"vessel": {"width": 7.0}}, "arena"),
        ({"boat": {"length": 6.0}}, "arena"),
        ({"water": {"walls": 0.25}, "start_distance": (0.2, 0.2)}, "walls"),
    ],
)  # fmt: skip
def test_slots_outside_the_basin_are_refused_when_the_world_is_made(options, named):
    with pytest.raises(ValueError, match=named):
        make_params("push", **options)


@settings(max_examples=40)
@given(
    spacing=st.floats(1.0, 15.0),
    near=st.floats(0.3, 4.5),
    width=st.floats(0.0, 0.5),
    team=st.sampled_from([2, 3, 4, 8, 20]),
)
def test_what_is_accepted_begins_with_every_seed(spacing, near, width, team):
    try:
        params = make_params(
            num_boats=team, start_spacing=spacing, start_distance=(near, near + width)
        )
    except ValueError:
        return
    distances(params, range(3))


def test_holding_for_longer_than_an_episode_is_refused():
    with pytest.raises(ValueError, match=r"hold_time = 60 s: longer than time_limit = 30 s"):
        make_params("approach", hold_time=60.0, time_limit=30.0)
    assert make_params("approach", time_limit=0.5).time_limit_ticks == 5
    assert make_params("push", hold_time=1e3).task.hold_time == 1e3


def test_parameters_that_are_replaced_are_checked_like_those_that_are_made():
    params = make_params()
    for changes in (
        {"task": replace(params.task, start_spacing=20.0)},
        {"task": replace(params.task, goal_distance=(9.0, 9.0))},
        {"water": replace(params.water, walls=0.4)},
        {"definition": APPROACH, "task": replace(params.task, hold_time=1e3)},
        {"variation": replace(params.variation, failures=4)},
    ):
        with pytest.raises(ValueError, match=r"start_|goal_|walls|hold_time|failures"):
            replace(params, **changes)


# ------------------------------------------------------------------ initial states of one's own


def never(params, rng, goal):
    raise AssertionError("tried before it was asked for")


def test_initial_states_of_ones_own_are_not_tried():
    params = make_params(replace(TRANSPORT, name="own", initial_states=never))
    with pytest.raises(FunctionError, match=r"initial states of task 'own' failed: .*: tried"):
        Simulation(params).reset(seeds=[0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motion": np.zeros((4, 6))}, r"motion = .*must be of shape \(5, 6\)"),
        ({"motion": np.full((5, 6), np.nan)}, "motion = .*finite"),
        ({"motion": np.full((5, 6), 1e300)}, "motion"),
        ({"motion": None}, "motion = None"),
        ({"goal": (0.0, 0.0)}, "goal"),
        ({"goal": (0.0, math.inf, 0.0)}, "goal"),
        ({"side": 0.0}, "side = 0: must be 1 or -1"),
        ({"lag": 0.0}, "lag"),
        ({"mass_gain": np.zeros(5)}, "mass_gain"),
        ({"drag_gain": -np.ones(5)}, "drag_gain"),
        ({"thrust_gain": "full"}, "thrust_gain"),
        ({"friction": math.nan}, "friction"),
        ({"failure_tick": np.zeros(3)}, "failure_tick"),
        ({"failure_tick": np.zeros(4)}, "failure_tick: fewer than all"),
    ],
)
def test_initial_state_that_is_none_is_refused_before_the_world_begins(changes, message):
    def own(params, rng, goal):
        return replace(starts.in_slots(params, rng, goal), **changes)

    for sim in (
        Simulation(make_params(replace(PUSH, name="own", initial_states=own))),
        Simulation(make_params("push"), initial_states=own),
    ):
        with pytest.raises(ValueError, match=f"^initial states: {message}"):
            sim.reset(seeds=[0])


def test_something_else_than_an_initial_state_is_refused():
    with pytest.raises(TypeError, match="InitialState"):
        Simulation(make_params(), initial_states=lambda *_: None).reset()


def test_initial_state_is_taken_as_it_is_and_kept_apart():
    params = make_params(scenario="harsh", task="push")
    given_state = start(params)
    taken = checked(given_state, params, np.random.default_rng(0))
    for name, value in vars(given_state).items():
        expected = np.ones(4) if name == "boat_size" else value
        np.testing.assert_array_equal(getattr(taken, name), expected)
        if isinstance(value, np.ndarray):
            assert not np.shares_memory(getattr(taken, name), value)
    given_state.motion[:, 2] = 7.0
    turned = checked(given_state, params, np.random.default_rng(0))
    np.testing.assert_allclose(turned.motion[:, 2], 7.0 - 2 * math.pi)
    assert isinstance(turned, InitialState)
