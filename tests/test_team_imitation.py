"""Imitation by the network of sets: its labels, its expert and its resumed runs."""

from copy import deepcopy

import numpy as np
import pytest

from asv_env import Simulation, make_params
from baselines.allocation import AllocationPolicy
from baselines.learned.team_view import TeamView
from baselines.rollout.loop import rollout

torch = pytest.importorskip("torch")
from train.team.team_imitation import (  # noqa: E402
    LEADS,
    Imitation,
    Kind,
    Rounds,
    batch_loss,
    kinds,
    take_over,
)

TINY = Rounds(rounds=2, kinds=2, boats=8, time=3.0, steps=5, batch=32)


@pytest.mark.parametrize("vessel", ["plank", "L"])
def test_what_the_expert_wants_is_what_it_does(vessel):
    """A learner that has learned the labels acts as the expert does."""
    params = make_params("transport", 4, "noisy", vessel=vessel)
    simulation, expert, view = Simulation(params, 3), AllocationPolicy(params), TeamView(params)
    sight, compared = None, []

    def act(sensed, observation, memory, fresh):
        nonlocal sight
        action, memory = expert.act(sensed, observation, memory, fresh)
        _, sight = view.observe(sensed, sight, fresh)
        learned = view.command(view.label(memory.wanted, sight), sight)
        compared.append((learned[..., 0], action[..., 0]))
        compared.append((np.abs(learned[..., 1]), np.abs(action[..., 1])))  # Or half a turn.
        return action, memory

    for _ in rollout(simulation, act, range(3), 200):
        pass
    learned, wanted = map(np.array, zip(*compared, strict=True))
    np.testing.assert_allclose(learned, wanted, rtol=0, atol=1e-5)


def test_an_expert_that_takes_over_leads_by_little():
    params = make_params("push", 4)
    simulation, expert, view = Simulation(params, 2), AllocationPolicy(params), TeamView(params)
    *_, last = rollout(simulation, expert.act, range(2), 300)
    memory, sensed = last.memory, simulation.sensed
    _, sight = view.observe(sensed, None, np.ones(2, dtype=bool))
    memory.course.speed[:], memory.course.yaw_rate[:] = 0.5, -0.5
    memory.reference[:] = 0.1
    take_over(memory, sight, sensed)
    np.testing.assert_array_equal(memory.reference, sight.reference)
    motion, course = memory.vessel.motion, memory.course
    axis = np.exp(1j * motion[:, 2]) * course.axis
    speed = ((motion[:, 3] + 1j * motion[:, 4]) * axis.conj()).real
    np.testing.assert_allclose(course.speed, speed + LEADS[0] * np.sign(course.speed - speed))
    np.testing.assert_allclose(course.yaw_rate, motion[:, 5] - LEADS[1])


def test_the_expert_has_formations_in_all_kinds_of_worlds():
    options = Rounds(kinds=12)
    first, found = (kinds(np.random.default_rng(0), options, number) for number in (0, 31))
    assert {(kind.num_boats, kind.scenario, kind.vessel) for kind in first} == {
        (4, "noisy", "plank")
    }
    assert len(set(found)) > 6
    assert all(kind.spans and options.has(kind) for kind in found)
    assert not Kind(num_boats=2).spans
    assert not Kind(vessel="disc").spans
    assert not Kind(num_boats=3, scenario="failure").spans
    with pytest.raises(ValueError, match="take larger teams, or other hulls"):
        kinds(np.random.default_rng(0), Rounds(teams=(2,)), 0)
    with pytest.raises(ValueError, match="Did you mean 'square'"):
        Rounds(hulls=("sqare",))


@pytest.fixture(scope="module")
def whole():
    """A run of two rounds, and what it was after the first one."""
    whole = Imitation(TINY, 10**9)
    whole.advance()
    first = deepcopy(whole.state()), list(whole.blocks)
    whole.advance()
    return whole, first


def test_a_resumed_run_ends_with_the_same_weights(whole):
    whole, first = whole
    resumed = Imitation(TINY, 10**9)
    resumed.restore(*first)
    resumed.advance()
    for one, other in ((whole.actor, resumed.actor), (whole.averaged, resumed.averaged)):
        for name, weight in one.weights().items():
            np.testing.assert_array_equal(other.weights()[name], weight)


def test_training_fits_what_was_seen(whole):
    learner = Imitation(TINY, 10**9)
    block = whole[0].blocks[0]
    boats = torch.arange(len(block.wanted))
    before = batch_loss(learner.actor, block, boats).item()
    learner.blocks = [block]
    for _ in range(8):
        learner._fit(np.random.default_rng(0))
    assert batch_loss(learner.actor, block, boats).item() < 0.7 * before
