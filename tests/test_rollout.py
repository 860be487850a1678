"""The loop of all rollouts: observe, act, step, reset."""

from itertools import pairwise

import numpy as np
import pytest

from asv_env import Simulation, make_params
from baselines.policy import Idle, Random, checked_action
from baselines.rollout.guard import Guard, PolicyError
from baselines.rollout.loop import IDLE, rollout

TICKS = 5
"""Length of an episode."""


@pytest.fixture
def params():
    return make_params("push", time_limit=TICKS / 10)


def test_worlds_take_the_seeds_in_turn_and_end_with_the_last(params):
    ticks = list(rollout(Simulation(params, 2), Idle(params).act, [5, 6, 7]))
    assert len(ticks) == 2 * TICKS
    assert ticks[0].episode.tolist() == [0, 1]
    assert ticks[TICKS].episode.tolist() == [2, IDLE]
    assert [tick.over.all() for tick in ticks] == 2 * ([False] * (TICKS - 1) + [True])


def test_an_episode_is_that_of_its_seed(params):
    def actions_of(worlds, seeds):
        ticks = list(rollout(Simulation(params, worlds), Random(params).act, seeds))
        return {
            seed: np.array([tick.action[tick.episode == number] for tick in ticks
                            if number in tick.episode])[:, 0]
            for number, seed in enumerate(seeds)
        }  # fmt: skip

    alone, paired = actions_of(1, [5, 6, 7]), actions_of(2, [7, 5, 6])
    for seed in (5, 6, 7):
        np.testing.assert_array_equal(alone[seed], paired[seed])


def test_with_a_number_of_ticks_worlds_continue(params):
    ticks = list(rollout(Simulation(params, 2), Idle(params).act, range(2), 3 * TICKS + 1))
    assert len(ticks) == 3 * TICKS + 1
    goals = [ticks[k].state.goal for k in (0, TICKS, 2 * TICKS)]
    assert len({goal.tobytes() for goal in goals}) == 3


def test_a_tick_is_what_was_before_the_step_and_what_came_of_it(params):
    simulation = Simulation(params, 1)
    ticks = []
    for tick in rollout(simulation, Random(params).act, [3]):
        assert simulation.state.tick[0] == tick.state.tick[0] + 1
        ticks.append(tick)
    for before, after in pairwise(ticks):
        np.testing.assert_array_equal(before.step.observation, after.observation)
        assert (before.state.motion != after.state.motion).any()
    assert [tick.state.tick[0] for tick in ticks] == list(range(TICKS))
    assert simulation.state.tick[0] == TICKS  # that of the last step


def test_memory_and_new_episodes_are_passed_on(params):
    def act(sensed, observation, memory, fresh):
        memory = np.where(fresh, 0, 0 if memory is None else memory + 1)
        return np.zeros((2, 4, 2), dtype=np.float32), memory

    for number, tick in enumerate(rollout(Simulation(params, 2), act, range(4))):
        assert (tick.memory == number % TICKS).all()


def test_an_episode_can_be_ended_from_outside(params):
    episodes = []
    for tick in rollout(Simulation(params, 1), Idle(params).act, range(3)):
        tick.over[0] |= not episodes
        episodes.append(int(tick.episode[0]))
    assert episodes == [0, *[1] * TICKS, *[2] * TICKS]


def test_a_policy_that_raises_is_named_where_it_is_alone():
    def act(sensed, observation, memory, fresh):
        raise ArithmeticError("tired\nof it")

    policy = type("Policy", (), {"act": staticmethod(act)})
    for worlds in (1, 2):
        simulation = Simulation(make_params("push"), worlds)
        guard = Guard(lambda _: policy, simulation.params)
        arguments = (simulation.sensed, simulation.reset(), None, np.ones(worlds, dtype=np.bool_))
        if worlds > 1:
            with pytest.raises(PolicyError):
                guard.act(*arguments)
        else:
            action, memory = guard.act(*arguments)
            assert (action == 0).all()
            assert memory is None
            assert guard.errors == {0: "ArithmeticError: tired of it"}


@pytest.mark.parametrize(
    ("action", "message"), [("fast", "of type str"), (np.zeros((4, 2)), "must be")]
)
def test_an_action_that_is_none_is_refused(action, message):
    with pytest.raises((TypeError, ValueError), match=message):
        checked_action(action, (1, 4, 2))
