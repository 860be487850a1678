"""A simulation refuses what it cannot use, and its worlds stay as they were."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import Simulation, make_params
from asv_env.physics import kernel
from asv_env.tasks import PUSH

PARAMS = make_params("push")
FRIENDS = {"scenario": "noisy"}
JUNK = st.one_of(
    st.none(), st.booleans(), st.integers(-3, 3), st.floats(), st.text(max_size=3),
    st.lists(st.integers(-2, 2), max_size=3), st.complex_numbers(), st.binary(max_size=3),
    st.dictionaries(st.text(max_size=1), st.none(), max_size=1), st.just(object()),
)  # fmt: skip


@given(action=JUNK)
def test_an_action_is_taken_or_refused_by_name(action):
    simulation = Simulation(PARAMS)
    simulation.reset(seeds=[0])
    before = simulation.state.motion
    with pytest.raises((TypeError, ValueError), match="action"):
        simulation.step(action)
    np.testing.assert_array_equal(simulation.state.motion, before)


@pytest.mark.parametrize(
    "action",
    [
        np.zeros((1, 4, 2), dtype=complex),
        np.full((1, 4, 2), "0.5"),
        np.zeros((1, 4, 2), dtype="m8[s]"),
        np.full((1, 4, 2), None),
        np.full((1, 4, 2), np.inf),
        [[[10**400, 0]] * 4],
    ],
    ids=["complex", "text", "time", "nothing", "infinite", "huge"],
)
def test_an_action_of_the_right_shape_must_be_real_numbers(action):
    simulation = Simulation(PARAMS)
    simulation.reset(seeds=[0])
    with pytest.raises((TypeError, ValueError), match="action"):
        simulation.step(action)


@given(seeds=JUNK.filter(lambda seeds: seeds is not None and seeds != {}))
def test_seeds_are_refused_by_name_and_nothing_begins(seeds):
    simulation = Simulation(PARAMS, 7)
    with pytest.raises(ValueError, match="seed"):
        simulation.reset(seeds=seeds)


@pytest.mark.parametrize("bad", [{"seeds": [5, -1]}, {"seeds": [5, 6], "goal": (9.0, 0.0, 0.0)}])
def test_a_reset_that_is_refused_changes_nothing(bad):
    touched, plain = (Simulation(make_params("push", **FRIENDS), 2) for _ in range(2))
    for simulation in (touched, plain):
        simulation.reset(seeds=[1, 2])
        simulation.step(np.ones((2, 4, 2)))
    with pytest.raises(ValueError, match=r"seed|goal"):
        touched.reset(**bad)
    for _ in range(3):
        here, there = (simulation.step(np.ones((2, 4, 2))) for simulation in (touched, plain))
        np.testing.assert_array_equal(here.observation, there.observation)
    np.testing.assert_array_equal(touched.reset(), plain.reset())


def test_worlds_go_on_where_the_initial_state_of_a_later_one_cannot_be_sampled():
    calls = []

    def fails(params, rng, goal):
        calls.append(1)
        if len(calls) == 4:
            raise RuntimeError("no such place")
        return PUSH.initial_states(params, rng, goal)

    touched = Simulation(PARAMS, 2, initial_states=fails)
    plain = Simulation(PARAMS, 2)
    for simulation in (touched, plain):
        simulation.reset(seeds=[1, 2])
        simulation.step(np.ones((2, 4, 2)))
    with pytest.raises(ValueError, match="no such place"):
        touched.reset(seeds=[3, 4])
    here, there = (simulation.step(np.ones((2, 4, 2))) for simulation in (touched, plain))
    np.testing.assert_array_equal(here.observation, there.observation)


START = {
    "motion": [np.zeros((4, 6)), np.full((5, 6), np.nan), np.full((5, 6), 1e30), [["x"] * 6] * 5],
    "goal": [np.zeros(2), (np.inf, 0, 0), None],
    "side": [0.0, 2.0, None, "left"],
    "thrust_gain": [np.ones(4), np.full((4, 2), np.nan)],
    "lag": [0.0, -1.0, np.inf],
    "drag_gain": [-np.ones(5), np.ones(4)],
    "mass_gain": [np.zeros(5), np.full(5, 1e300)],
    "friction": [-0.1, np.nan],
    "failure_tick": [np.zeros(3, int), np.full(4, np.nan)],
}


@pytest.mark.parametrize(
    ("field", "value"), [(name, value) for name, values in START.items() for value in values]
)
def test_initial_states_that_no_world_can_have_are_refused(field, value):
    def bad(params, rng, goal):
        return dataclasses.replace(PUSH.initial_states(params, rng, goal), **{field: value})

    with pytest.raises(ValueError, match=f"initial states: {field}"):
        Simulation(PARAMS, initial_states=bad).reset(seeds=[0])


def test_what_is_no_initial_state_is_refused():
    simulation = Simulation(PARAMS, initial_states=lambda params, rng, goal: None)
    with pytest.raises(TypeError, match="InitialState"):
        simulation.reset(seeds=[0])


@pytest.mark.parametrize("count", [0, -1, True, 2.0, "2", np.float64(1)])
@pytest.mark.parametrize("name", ["num_worlds", "num_threads"])
def test_numbers_of_worlds_and_threads_are_refused_by_name(name, count):
    with pytest.raises(ValueError, match=name):
        Simulation(PARAMS, **{name: count})


def test_actions_of_any_layout_need_no_code_of_their_own():
    """To compile the loop takes seconds."""
    simulation, action = Simulation(PARAMS, 3), np.zeros((3, 4, 2))
    simulation.reset(seeds=range(3))
    simulation.step(action)
    known = list(kernel.advance.signatures)
    for other in (np.asfortranarray(action), action.astype(np.float32), np.zeros((2, 4, 3)).T):
        simulation.step(other)
    assert kernel.advance.signatures == known
