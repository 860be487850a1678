"""Obstacles: contact, collisions, what is refused, and that worlds with them stay exact."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from helpers import AHEAD, DOWN, World, actions, begin_at, bodies, open_water
from hypothesis import given, settings
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.capsules import clearance
from asv_env.params.obstacle_params import Circle, Polygon, Segment, grouping
from asv_env.render.layout import outline
from asv_env.sensing.feature_table import NAMES, table
from asv_env.sensing.global_state import global_state
from asv_env.tasks import starts

LAYOUTS = ("pillars", "channel", "dock")
BLOCK = [(1.0, -1.0), (2.0, -1.0), (2.0, 1.0), (1.0, 1.0)]
IN_THE_WAY = {
    "circle": Circle((1.5, 0.0), 0.5),
    "segment": Segment((1.05, -1.0), (1.05, 1.0), 0.05),
    "polygon": Polygon(BLOCK),
}
"""Obstacles whose nearest point ahead of the origin is (1, 0)."""


def gaps(params, state):
    """Distances (W, B) of the hulls to the nearest obstacle, m."""
    groups, hulls = grouping(params).groups, [params.vessel, *[params.boat] * params.num_boats]
    return np.array(
        [
            [
                clearance(rows, groups, np.ascontiguousarray(outline(hull, motion)))
                for hull, motion in zip(hulls, world, strict=True)
            ]
            for world, rows in zip(state.motion, state.obstacle, strict=True)
        ]
    )


# ------------------------------------------------------------------ contact


@pytest.mark.parametrize("shape", IN_THE_WAY)
def test_boat_stops_at_an_obstacle_and_touches_it(shape):
    params = open_water(control=10, obstacles=[IN_THE_WAY[shape]])
    world = World(params, bodies((0, 5), (0, 0), (0, 3)))
    world.run(20, AHEAD)
    bow = world.motion[1, 0] + params.boat.length / 2
    assert bow == pytest.approx(1.0, abs=1e-3)
    assert world.sim.state.touching[0].tolist() == [[False, True], [False, False]]
    assert not world.sim.state.aground[0]
    assert world.sim.summary()["collisions"] == 1


@pytest.mark.parametrize("shape", IN_THE_WAY)
def test_vessel_that_is_pushed_onto_an_obstacle_is_aground(shape):
    params = open_water(control=10, obstacles=[IN_THE_WAY[shape]], reward={"collision": 1.0})
    pushers = [(0.0, y, 0.0) for y in (-0.05, 0.05)]
    x = 0.5
    start = bodies((x, 0, np.pi / 2), *[(x - 0.14, y, 0.0) for _, y, _ in pushers])
    world, paid = World(params, start), []
    for _ in range(200):
        paid.append(world.sim.step(actions(world.sim, AHEAD)).terms["collision"][0])
    assert world.sim.state.aground[0]
    assert world.motion[0, 0] + params.vessel.width / 2 == pytest.approx(1.0, abs=2e-3)
    assert world.sim.summary()["collisions"] >= 1
    np.testing.assert_allclose(paid[-1], -0.1)  # of each boat, for a tenth of a second
    np.testing.assert_array_equal(paid[0], 0.0)


@pytest.mark.parametrize(
    "shape",
    [
        Segment((0.07, -0.2), (0.3, -0.3), 0.04),
        Segment((0.3, -0.3), (0.07, -0.2), 0.04),
        Segment((0.07, -0.2), (0.07, -0.5), 0.04),
        Circle((0.07, -0.2), 0.04),
        Polygon([(0.07, -0.16), (0.3, -0.3), (-0.1, -0.3)]),
    ],
    ids=repr,
)
def test_vessel_that_meets_the_end_of_an_obstacle_turns_round_it(shape):
    """The point of the hull that touches (0.07, -0.16) stops, and the hull does not sink in."""
    world = World(open_water(obstacles=[shape]), bodies((0, 0, 0, 0, -0.1), (5, 5), (6, 6)))
    while not world.sim.state.aground[0]:
        world.step()
    motion, deepest = world.motion[0], gaps(world.params, world.sim.state)[0, 0]
    assert motion[4] + motion[5] * 0.07 == pytest.approx(0.0, abs=1e-4)
    assert motion[5] > 0.1
    for _ in range(20):
        world.step()
        deepest = min(deepest, gaps(world.params, world.sim.state)[0, 0])
    assert deepest > -2e-3


def test_walls_are_obstacles_that_come_last():
    params = make_params(water={"walls": 2.0}, obstacles=[Circle((1.0, 1.0), 0.1)])
    state = World(params, bodies((), *[(x, -1) for x in (-0.6, -0.2, 0.2, 0.6)])).sim.state
    assert grouping(params).groups.tolist() == [0, 1, 2, 3, 4, 5]
    assert grouping(params).walls == 4
    np.testing.assert_allclose(state.obstacle[0, 0], [1, 1, 1, 1, 0.1])


# ------------------------------------------------------------------ exact worlds


def played(simulation, ticks, seed=0):
    rng, seen = np.random.default_rng(seed), []
    for _ in range(ticks):
        step = simulation.step(rng.uniform(-0.3, 1.0, simulation.state.thrust.shape))
        state = simulation.state
        seen.append(state.motion.tobytes() + state.aground.tobytes() + step.reward.tobytes())
        seen.append(step.observation.tobytes())
        over = step.ending.terminated | step.ending.truncated
        if over.any():
            simulation.reset(over)
    return seen


@pytest.mark.parametrize("layout", LAYOUTS)
def test_worlds_with_obstacles_are_exact(layout):
    """Resets, batches, threads, snapshots and pickles change nothing."""
    params = make_params("push", obstacles=layout, water={"walls": 3.0}, time_limit=30.0)
    fresh, used = Simulation(params, 3), Simulation(params, 3, num_threads=2)
    used.reset(seeds=[7, 8, 9])
    played(used, 40, seed=1)
    for simulation in (fresh, used):
        simulation.reset(seeds=[1, 2, 3])
    expected = played(fresh, 60)
    assert played(used, 60) == expected
    snapshot, twin = used.snapshot(), pickle.loads(pickle.dumps(used))
    later = played(used, 60, seed=2)
    used.restore(snapshot)
    assert played(used, 60, seed=2) == later
    assert played(twin, 60, seed=2) == later
    alone = Simulation(params)
    alone.reset(seeds=[2])
    alone.step(actions(alone, 0.5))
    fresh.reset(seeds=[1, 2, 3])
    fresh.step(actions(fresh, 0.5))
    np.testing.assert_array_equal(alone.state.motion[0], fresh.state.motion[1])


# ------------------------------------------------------------------ starts and goals


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("task", ["push", "transport"])
def test_starts_and_goals_are_free(layout, task):
    params = make_params(task, obstacles=layout)
    simulation = Simulation(params, 16)
    simulation.reset(seeds=range(16))
    state = simulation.state
    assert gaps(params, state).min() > 0
    there = replace(state, motion=state.motion.copy())
    there.motion[:, 0, :3] = state.goal
    assert gaps(params, there)[:, 0].min() > 0
    assert len({rows.tobytes() for rows in state.obstacle}) == 16


@settings(max_examples=25)
@given(seed=st.integers(0, 2**32), side=st.sampled_from(["+n", "-n", "goal"]))
def test_goal_lies_in_a_dock_that_is_open_to_the_team(seed, side):
    params = make_params("push", obstacles="dock", side=side)
    simulation = Simulation(params)
    simulation.reset(seeds=[seed])
    state = simulation.state
    rows, goal = state.obstacle[0], state.goal[0]
    ends = np.concatenate([rows[:, :2], rows[:, 2:4]]) @ [1, 1j]
    seen = (ends - complex(*goal[:2])) * np.exp(-1j * goal[2]) * state.side[0]
    quay, pier, other = seen[[0, 3]], seen[[1, 4]], seen[[2, 5]]
    assert (quay.imag < -params.vessel.width / 2).all()
    assert min(abs(pier.real).min(), abs(other.real).min()) > params.vessel.length / 2
    assert (pier.real * other.real < 0).all()
    assert max(pier.imag) > 0


WALL = [Segment((-9.0, -0.3), (9.0, -0.3), 0.02)]
REFUSED = [
    ({"obstacles": [Circle((0.1, 0.0), 0.1)]}, "begin in an obstacle"),
    ({"obstacles": [Circle((0.5, 0.5), 0.2)], "goal": (0.5, 0.5, 0.0)}, "at its goal"),
    ({"obstacles": WALL, "goal": (0.0, -1.0, 0.0)}, "no way from the start to the goal"),
    ({"obstacles": {"name": "pillars", "count": 90, "spread": 1.0}}, "in each of 20 samples"),
    ({"obstacles": [Polygon([(-9, -9), (9, -9), (9, 9), (-9, 9)])]}, "begin in an obstacle"),
    ({"obstacles": "pilars"}, "Did you mean 'pillars'"),
    ({"obstacles": {"name": "dock", "lenght": 1.0}}, "Did you mean 'length'"),
    ({"obstacles": {"name": "dock", "gap": -1.0}}, "Dock.gap = -1.0"),
    ({"obstacles": {"name": "pillars", "count": 2.5}}, "Pillars.count = 2.5"),
    ({"obstacles": [{"centre": (1, 1), "radios": 0.1}]}, "Did you mean 'radius'"),
    ({"obstacles": [{"centre": (1, 1)}]}, "radius"),
    ({"obstacles": [(1, 2, 3)]}, "give a Circle"),
    ({"obstacles": 7}, "obstacles = 7"),
    ({"obstacles": [Circle((1e4, 0.0), 1.0)]}, "times vessel.length"),
    ({"obstacles": lambda *_: [(1, 2)]}, "give a Circle"),
    ({"obstacles": lambda *_: 1 / 0}, "ZeroDivisionError"),
    ({"obstacles": [Circle((1.0, 0.0), 0.1)] * 1001}, "more than 1000"),
]


@pytest.mark.parametrize(("options", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_impossible_obstacles_are_refused_when_the_environment_is_made(
    options, message, monkeypatch
):
    monkeypatch.setattr(starts, "LAYOUTS", 20)
    with pytest.raises(ValueError, match=message):
        make_params("push", **options)


@pytest.mark.parametrize(("kind", "values"), [
    (Circle, ((0, 0), 0.0)), (Circle, ((0, np.nan), 1.0)), (Circle, ((0,), 1.0)),
    (Segment, ((0, 0), (1, 1), -0.1)), (Polygon, ([(0, 0), (1, 1)],)),
    (Polygon, ([(0, 0), (1, 1), (2, 2)],)), (Polygon, ("abc",)),
    (Polygon, ([(0, 0), (1, 1), (1, 0), (0, 1)],)),
])  # fmt: skip
def test_shapes_that_are_none_are_refused(kind, values):
    with pytest.raises(ValueError, match=kind.__name__):
        kind(*values)


def test_goal_in_an_obstacle_is_refused_at_reset():
    simulation = Simulation(make_params("push", obstacles=[Circle((1.0, 0.0), 0.3)]))
    with pytest.raises(ValueError, match="at its goal"):
        simulation.reset(seeds=[0], goal=(1.0, 0.1, 0.0))


def test_layout_that_changes_its_number_of_shapes_is_refused():
    def growing(params, rng, goal, side):
        count[0] += 1
        return [Circle((9.0, 9.0 + k), 0.1) for k in range(count[0])]

    count = [0]
    with pytest.raises(ValueError, match="as many of the same kinds in every episode"):
        make_params("push", obstacles=growing)


def test_obstacles_of_a_scenario_grow_with_the_scale_and_given_ones_do_not():
    shapes = [Circle((1.0, 1.0), 0.1), Segment((1, 1), (2, 1), 0.1), Polygon(BLOCK)]
    grown = make_params("push", scenario={"obstacles": shapes}, scale=2.0).obstacles
    assert grown[0] == Circle((2.0, 2.0), 0.2)
    assert grown[1] == Segment((2.0, 2.0), (4.0, 2.0), 0.2)
    assert grown[2].corners[0] == (2.0, -2.0)
    assert make_params("push", obstacles=shapes, scale=2.0).obstacles == tuple(shapes)
    params = make_params("push", obstacles=shapes)
    assert params.rescaled(2.0).obstacles == grown
    assert params.rescaled(2.0).rescaled(0.5).obstacles == params.obstacles


def test_obstacles_are_given_as_mappings_too():
    given_as = [{"centre": [1, 1], "radius": 0.1}, {"corners": BLOCK}]
    params = make_params("push", obstacles=given_as)
    assert params.obstacles == (Circle((1.0, 1.0), 0.1), Polygon(BLOCK))
    assert hash(params) == hash(make_params("push", obstacles=params.obstacles))


def test_initial_states_may_place_obstacles_of_their_own():
    params = make_params("push", obstacles=[Circle((1.0, 1.0), 0.1)])
    simulation = Simulation(params)
    rows = np.array([[-1.0, 0.0, -1.0, 0.0, 0.3]])
    start = bodies((), *[(x, 0.14, DOWN) for x in (-0.23, -0.07, 0.07, 0.23)])
    begin_at(simulation, [start], obstacle=rows)
    np.testing.assert_array_equal(simulation.state.obstacle[0], rows)
    with pytest.raises(ValueError, match="obstacle"):
        begin_at(simulation, [start], obstacle=-rows)
    begin_at(simulation, [start], obstacle=None)
    np.testing.assert_array_equal(simulation.state.obstacle[0, 0], [1, 1, 1, 1, 0.1])


# ------------------------------------------------------------------ observation


def seen_at(params, motion):
    """Columns of the first boat by name, in SI units, of a world that begins with a motion."""
    simulation = Simulation(params)
    begin_at(simulation, [motion])
    return dict(zip(NAMES, table(simulation.sensed, params)[0, 0], strict=True)), simulation


def test_nearest_points_are_observed_in_the_frames_of_boat_and_vessel():
    shapes = [Circle((2.0, 0.0), 0.5), Segment((-1.0, 1.0), (1.0, 1.0), 0.1), Polygon(BLOCK_BELOW)]
    params = open_water(obstacles=shapes)
    motion = bodies((0.5, 0.0, np.pi / 2), (0, 0, np.pi), (-3, 3))
    seen, simulation = seen_at(params, motion)
    expected = [(0.0, -0.9), (-1.5, 0.0), (0.0, 2.0)]  # ahead is -x, left is -y
    found = [(seen[f"obstacle_{k}_x"], seen[f"obstacle_{k}_y"]) for k in (1, 2, 3)]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    of_vessel = [(0.9, 0.0), (0.0, -1.0), (-2.0, 0.0)]  # ahead is +y, left is -x
    found = [(seen[f"vessel_obstacle_{k}_x"], seen[f"vessel_obstacle_{k}_y"]) for k in (1, 2, 3)]
    np.testing.assert_allclose(found, of_vessel, atol=1e-12)
    assert all(seen[f"{kind}_{k}_present"] == 1 for kind in KINDS for k in (1, 2, 3))
    state = global_state(simulation.state, params)[0]
    arena = params.task.arena
    assert np.isclose(state, 0.9 / arena, rtol=1e-5).any()
    assert state.shape == global_state(*empty_water()).shape[1:]


TINY_HULL = np.array([[0, 0], [1e-9, 0], [0, 1e-9]])
BLOCK_BELOW = [(-1.0, -2.0), (1.0, -2.0), (1.0, -3.0), (-1.0, -3.0)]
KINDS = ("obstacle", "vessel_obstacle")


def empty_water():
    params = open_water()
    simulation = Simulation(params)
    simulation.reset(seeds=[0])
    return simulation.state, params


def test_there_are_no_nearest_points_in_open_water_and_walls_count():
    motion = bodies((0.0, 0.0, 0.0), (-0.5, 0, 0.0), (0.5, 0))
    seen, _ = seen_at(open_water(), motion)
    assert not any(value for name, value in seen.items() if "obstacle" in name)
    seen, _ = seen_at(open_water(water={"walls": 80.0}, goal=(70.0, 70.0, 0.0)), motion)
    assert seen["obstacle_1_x"] == pytest.approx(-79.5)
    seen, _ = seen_at(open_water(obstacles=[Circle((2.0, 0.0), 0.5)]), motion)
    assert seen["obstacle_1_x"] == pytest.approx(2.0)
    assert seen["obstacle_1_present"] == 1
    assert seen["obstacle_2_present"] == 0


@settings(max_examples=20)
@given(seed=st.integers(0, 1000))
def test_nearest_point_of_a_boat_is_on_the_nearest_obstacle(seed):
    params = make_params(obstacles="channel", water={"walls": 2.9})
    simulation = Simulation(params)
    simulation.reset(seeds=[seed])
    state, (groups, _) = simulation.state, grouping(params)
    columns = dict(zip(NAMES, np.moveaxis(table(simulation.sensed, params)[0], -1, 0), strict=True))
    x, y = columns["obstacle_1_x"], columns["obstacle_1_y"]
    point = np.ascontiguousarray(state.motion[0, 1:, :2])
    for boat, place in enumerate(point):
        near = clearance(state.obstacle[0], groups, place + TINY_HULL)
        assert np.hypot(x[boat], y[boat]) == pytest.approx(near, abs=1e-6)
