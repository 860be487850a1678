"""Writing to what a simulation hands out changes nothing; what it is given stays the caller's."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from asv_env import Simulation, Task, make_params
from asv_env.sensing.observation import FEATURES, Feature
from asv_env.tasks import PUSH, Metric, Term
from asv_env.tasks.formation import Relations
from asv_env.types import Ending, Sensed, State

RECORDS = {"state": State, "relations": Relations, "ending": Ending}


def begun(scenario="noisy", worlds=2, **options):
    simulation = Simulation(make_params("push", scenario=scenario, **options), worlds)
    simulation.reset(seeds=range(worlds))
    simulation.step(np.full((worlds, 4, 2), 0.5))
    return simulation


ARRAYS = [(name, each.name) for name, kind in RECORDS.items() for each in dataclasses.fields(kind)]


@pytest.mark.parametrize(("record", "field"), ARRAYS)
def test_no_array_of_a_record_can_be_written_to(record, field):
    simulation = begun()
    array = getattr(getattr(simulation, record), field)
    with pytest.raises(ValueError, match="read-only"):
        array[...] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(getattr(simulation, record), field, array)


@pytest.mark.parametrize("name", RECORDS)
def test_no_record_can_be_replaced(name):
    simulation = begun()
    with pytest.raises(AttributeError):
        setattr(simulation, name, getattr(simulation, name))


@pytest.mark.parametrize("scenario", ["nominal", "noisy"])
@pytest.mark.parametrize("field", [f.name for f in dataclasses.fields(Sensed)])
def test_what_is_sensed_is_a_copy(scenario, field):
    touched, plain = begun(scenario), begun(scenario)
    array = getattr(touched.sensed, field)
    array[...] = ~array if array.dtype == bool else array + 1
    action = np.zeros((2, 4, 2))
    np.testing.assert_array_equal(touched.step(action).observation, plain.step(action).observation)
    for each in dataclasses.fields(State):
        here, there = getattr(touched.state, each.name), getattr(plain.state, each.name)
        np.testing.assert_array_equal(here, there)


def test_records_stay_as_they_were_when_the_worlds_go_on():
    simulation = begun("harsh")
    kept = {name: getattr(simulation, name) for name in RECORDS}
    values = {name: {k: v.copy() for k, v in vars(record).items()} for name, record in kept.items()}
    for _ in range(80):
        simulation.step(np.full((2, 4, 2), 0.7))
    simulation.reset()
    for name, record in kept.items():
        for field, value in values[name].items():
            np.testing.assert_array_equal(getattr(record, field), value)


def test_what_a_step_returns_is_the_callers_own():
    touched, plain = begun(), begun()
    for _ in range(3):
        step, same = touched.step(np.zeros((2, 4, 2))), plain.step(np.zeros((2, 4, 2)))
        np.testing.assert_array_equal(step.observation, same.observation)
        np.testing.assert_array_equal(step.reward, same.reward)
        step.observation[...] = step.reward[...] = np.nan
        for values in touched.summary().values():
            values[...] = 0
    for name, value in plain.summary().items():
        np.testing.assert_array_equal(touched.summary()[name], value)


def test_the_goal_and_the_action_that_were_given_are_copied():
    goal, action = np.array([0.2, -0.8, 0.1]), np.full((1, 4, 2), 0.5)
    simulation = Simulation(make_params("push"))
    simulation.reset(seeds=[0], goal=goal)
    goal[:] = 0.0
    np.testing.assert_allclose(simulation.state.goal[0], [0.2, -0.8, 0.1])
    first = simulation.step(action).observation
    action[:] = -1.0
    twin = Simulation(make_params("push"))
    twin.reset(seeds=[0], goal=[0.2, -0.8, 0.1])
    np.testing.assert_array_equal(twin.step(np.full((1, 4, 2), 0.5)).observation, first)


def spoil(now):
    now.relations.goal_error[...] = 0.0
    return now.relations.goal_error


def spoil_state(state, relations, params):
    state.tick[...] = 0
    return state.tick


def spoil_view(view):
    view.sensed.estimate[...] = 0.0
    return view.slots_occupied[:, None]


def spoil_success(relations, state, water, params):
    state.working[...] = True
    return state.closed


WRITERS = {
    "reward": {"reward": (*PUSH.reward, Term("spoil", spoil))},
    "success": {"success": spoil_success},
}


@pytest.mark.parametrize("part", WRITERS)
def test_functions_of_a_task_cannot_write_either(part):
    task = dataclasses.replace(PUSH, name="spoilt", **WRITERS[part])
    assert isinstance(task, Task)
    simulation = Simulation(make_params(task))
    simulation.reset(seeds=[0])
    with pytest.raises(ValueError, match="read-only"):
        simulation.step(np.zeros((1, 4, 2)))


def test_metrics_and_features_cannot_write_either():
    task = dataclasses.replace(PUSH, name="spoilt", metrics=(Metric("spoil", spoil_state),))
    simulation = Simulation(make_params(task))
    simulation.reset(seeds=[0])
    with pytest.raises(ValueError, match="read-only"):
        simulation.summary()
    feature = Feature("spoil", spoil_view, (1.0,), (1.0,))
    simulation = Simulation(make_params("push", observation=["slot", feature]))
    simulation.reset(seeds=[0])
    with pytest.raises(ValueError, match="read-only"):
        simulation.step(np.zeros((1, 4, 2)))


def test_initial_states_are_given_a_goal_of_their_own():
    def writes(params, rng, goal):
        start = PUSH.initial_states(params, rng, goal.copy())
        goal[...] = 0.0
        return start

    simulation = Simulation(make_params("push"), 2, initial_states=writes)
    simulation.reset(seeds=[0, 1], goal=(0.3, -0.7, 0.0))
    np.testing.assert_allclose(simulation.state.goal, [[0.3, -0.7, 0.0]] * 2)


@given(names=st.permutations(list(FEATURES)[:5]))
def test_a_list_of_features_stays_the_callers(names):
    given_names = list(names)
    params = make_params("push", observation=given_names)
    given_names.clear()
    assert params.observation == tuple(names)


@pytest.mark.parametrize("state", [{"all": "raise"}, {"under": "raise", "over": "raise"}])
def test_floating_point_settings_of_the_user_change_nothing(state):
    def played():
        simulation = begun("harsh")
        simulation.reset()
        return simulation.step(np.ones((2, 4, 2))).observation, simulation.summary()

    (observation, summary) = played()
    with np.errstate(**state):
        (same, metrics) = played()
    np.testing.assert_array_equal(same, observation)
    assert metrics.keys() == summary.keys()


def test_metrics_of_the_last_episode_do_not_show_in_the_next():
    params = make_params("push", goal=(0.0, -0.01, 0.0), delivery_time=0.1)
    simulation = Simulation(params, 2)
    simulation.reset(seeds=[0, 1])
    assert simulation.step(np.zeros((2, 4, 2))).ending.reached.all()
    assert simulation.summary()["is_success"].all()
    simulation.reset(np.array([True, False]))
    assert simulation.summary()["is_success"].tolist() == [False, True]
    assert np.isinf(simulation.summary()["time_to_goal"]).tolist() == [True, False]
    assert simulation.ending.terminated.tolist() == [False, True]
