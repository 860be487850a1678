"""Policies of several networks: which of them acts when."""

import numpy as np
import pytest
from helpers import SEEN

from asv_env import Simulation, make_params
from baselines.learned.network import Metadata
from baselines.learned.phases import Phase, PhasedPolicy
from baselines.scripted.scripted_policy import ScriptedPolicy


def constant(speed, patience=None, team_size=None):
    """A network whose action is always the same."""
    layers = [(np.zeros((SEEN, 2)), np.array([speed, 0.0]))]
    return Phase(layers, Metadata(), patience, team_size)


def who_acts(policy, params, ticks, worlds=3, fresh_at=None):
    """Returns the forward commands (T, W) while the vessel lies in closure, and nobody moves."""
    sim = Simulation(params, worlds)
    sim.reset(seeds=range(worlds))
    memory, acted = None, []
    for tick in range(ticks):
        fresh = np.full(worlds, tick == 0)
        if fresh_at is not None and tick == fresh_at[0]:
            fresh[fresh_at[1]] = True
        action, memory = policy.act(sim.sensed, None, memory, fresh)
        acted.append(action[:, 0, 0].astype(float).round(2).tolist())
    return np.array(acted)


def test_the_first_network_acts_until_the_vessel_is_in_closure():
    """Driven by the scripted policy, each team's action changes once, when closure is formed."""
    params = make_params("transport", goal=(0.2, -0.9, 0.1))
    policy, expert = PhasedPolicy([constant(0.1), constant(0.2)], params), ScriptedPolicy(params)
    sim, memory, drives = Simulation(params, 8), None, None
    observation, fresh = sim.reset(seeds=range(8)), np.ones(8, dtype=bool)
    was_closed = np.zeros(8, dtype=bool)
    for _ in range(400):
        was_closed |= sim.sensed.closed
        action, memory = policy.act(sim.sensed, observation, memory, fresh)
        wanted = np.where(was_closed, 0.2, 0.1)[:, None]
        np.testing.assert_allclose(action[..., 0], np.broadcast_to(wanted, (8, 4)), rtol=1e-6)
        action, drives = expert.act(sim.sensed, observation, drives, fresh)
        observation, fresh = sim.step(action).observation, np.zeros(8, dtype=bool)
    assert was_closed.all()


def test_networks_take_turns_where_attempts_fail():
    """In closure a new attempt goes straight on to the next network; the last one stays."""
    params = make_params("push", goal=(0.2, -0.9, 0.1))
    policy = PhasedPolicy([constant(0.1), constant(0.2, 1.0), constant(0.3, 2.0)], params)
    acted = who_acts(policy, params, 45, fresh_at=(25, 1))
    assert acted[:, 0].tolist() == [0.2] * 10 + [0.3] * 35
    assert acted[:, 1].tolist() == [0.2] * 10 + [0.3] * 15 + [0.2] * 10 + [0.3] * 10
    assert np.array_equal(acted[:, 0], acted[:, 2])


def test_a_team_on_the_side_of_the_goal_goes_round_first():
    params = make_params("push", goal=(0.2, 0.9, 0.1))
    assert (who_acts(PhasedPolicy([constant(0.1), constant(0.2)], params), params, 5) == 0.1).all()


def test_a_larger_vessel_takes_longer():
    params = make_params("push", num_boats=8, goal=(0.2, -0.9, 0.1))
    length = params.vessel.length
    policy = PhasedPolicy([constant(0.1), constant(0.2, 1.0), constant(0.3)], params)
    acted = who_acts(policy, params, 40)
    assert (acted[:, 0] == 0.2).sum() == np.ceil(10 * length / 0.4)


@pytest.mark.parametrize(("team", "acted"), [(3, 0.2), (4, 0.4), (6, 0.2)])
def test_a_team_that_has_networks_of_its_own_is_served_by_these(team, acted):
    params = make_params("push", num_boats=team, goal=(0.2, -0.9, 0.1))
    nets = [constant(0.1), constant(0.2), constant(0.3, team_size=4), constant(0.4, team_size=4)]
    assert (who_acts(PhasedPolicy(nets, params), params, 5) == acted).all()


def test_worlds_do_not_depend_on_one_another():
    params, rng = make_params("transport"), np.random.default_rng(0)
    nets = [
        Phase([(rng.normal(size=(SEEN, 2)), np.zeros(2))], Metadata(action_repeat=2), 1.0)
        for _ in range(3)
    ]
    runs = []
    for seeds in ([0, 1, 2], [1]):
        policy, sim = PhasedPolicy(nets, params), Simulation(params, len(seeds))
        observation, memory = sim.reset(seeds=seeds), None
        fresh, actions = np.ones(len(seeds), dtype=bool), []
        for _ in range(60):
            action, memory = policy.act(sim.sensed, observation, memory, fresh)
            observation, fresh = sim.step(action).observation, np.zeros(len(seeds), dtype=bool)
            actions.append(action)
        runs.append(np.array(actions))
    assert np.array_equal(runs[0][:, 1], runs[1][:, 0])
