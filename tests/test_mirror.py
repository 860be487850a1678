"""A team that pushes from the side away from the goal sees the mirror image of the world."""

import numpy as np
import pytest
from helpers import SEEN

from asv_env import Simulation, make_params
from asv_env.tasks import starts
from baselines.learned.network import Metadata, NetworkPolicy
from baselines.mirror import at_scale, mirror_image, view
from baselines.scripted.scripted_policy import ScriptedPolicy

MIRROR = np.array([1.0, -1.0, -1.0])


def mirrored_start(params, rng, goal=None):
    start = starts.sample(params, rng, goal)
    start.goal *= MIRROR
    start.motion[:, :3] *= MIRROR
    return start


class Driven:
    """Worlds in which the scripted policy acts on what the side away from the goal sees."""

    def __init__(self, params, seeds, **options):
        self.sim = Simulation(params, len(seeds), **options)
        self.sim.reset(seeds=seeds)
        self.params, self.scripted = params, ScriptedPolicy(params)
        self.push_side = self.memory = None
        self.fresh = np.ones(len(seeds), dtype=bool)

    def step(self):
        seen, self.push_side = view(self.params, self.sim.sensed, self.push_side, self.fresh)
        action, self.memory = self.scripted.act(seen, None, self.memory, self.fresh)
        action[..., 1] *= self.push_side.side[:, None]
        over = self.sim.step(action).ending
        self.fresh = over.terminated | over.truncated
        if self.fresh.any():
            self.sim.reset(self.fresh)
        return seen


def test_obstacles_are_mirrored_and_scaled_with_the_world():
    simulation = Simulation(make_params("push", obstacles="channel"), 2)
    simulation.reset(seeds=[0, 1])
    sensed, side = simulation.sensed, np.array([1.0, -1.0])
    seen = mirror_image(sensed, side)
    np.testing.assert_array_equal(seen.obstacle[0], sensed.obstacle[0])
    np.testing.assert_array_equal(seen.obstacle[1], sensed.obstacle[1] * [1, -1, 1, -1, 1])
    np.testing.assert_array_equal(at_scale(sensed, 2.0).obstacle, 2.0 * sensed.obstacle)


def test_the_goal_is_ahead_when_an_episode_begins():
    seen = Driven(make_params("transport"), range(50)).step()
    assert (seen.goal[:, 1] <= 0).all()
    assert (seen.side == 1).all()


@pytest.mark.parametrize("scenario", ["nominal", "failure"])
def test_slots_and_closure_follow_the_same_rules_on_both_sides(scenario):
    own, other = (
        Driven(
            make_params("transport", scenario=scenario, side=side, goal=(0.2, 0.6, 0.5)), range(4)
        )
        for side in ("-n", "+n")
    )
    closed = 0
    for _ in range(400):
        one, two = own.step(), other.step()
        np.testing.assert_allclose(one.slot[one.working], two.slot[two.working], atol=1e-9)
        assert np.array_equal(one.closed, two.closed)
        closed += one.closed.sum()
    assert closed > 200  # of 1,600 worlds and ticks


def test_actions_in_the_mirror_are_mirrored():
    """By weights under which no hulls touch: where they do depends on which of them comes first."""
    params, rng = make_params("transport"), np.random.default_rng(11)
    layers = [
        (rng.normal(size=(SEEN, 16)) / 5, np.zeros(16)),
        (rng.normal(size=(16, 2)), np.zeros(2)),
    ]
    policies = [NetworkPolicy(layers, Metadata(mirrors=True), params) for _ in range(2)]
    sims = [Simulation(params, 8), Simulation(params, 8, initial_states=mirrored_start)]
    seen = [sim.reset(seeds=range(8)) for sim in sims]
    memories, fresh = [None, None], np.ones(8, dtype=bool)
    for _ in range(60):
        decided = [
            policy.act(sim.sensed, observed, memory, fresh)
            for policy, sim, observed, memory in zip(policies, sims, seen, memories, strict=True)
        ]
        actions, memories = zip(*decided, strict=True)
        assert not sims[0].sensed.touching.any()
        np.testing.assert_allclose(actions[0] * [1, -1], actions[1], atol=1e-6)
        seen = [sim.step(action).observation for sim, action in zip(sims, actions, strict=True)]
        fresh = np.zeros(8, dtype=bool)
    one, other = (sim.state.motion for sim in sims)
    np.testing.assert_allclose(one[..., :3] * MIRROR, other[..., :3], atol=1e-9)
    assert np.abs(one[:, 1:, 3:5]).max() > 0.05


def test_without_a_mirror_the_observation_is_the_environments():
    params, rng = make_params("push"), np.random.default_rng(0)
    layers = [(rng.normal(size=(SEEN, 2)), np.zeros(2))]
    sim = Simulation(params, 4)
    seen, fresh = sim.reset(seeds=range(4)), np.ones(4, dtype=bool)
    policy = NetworkPolicy(layers, Metadata(), params)
    action, _ = policy.act(sim.sensed, seen, None, fresh)
    assert np.array_equal(action, policy.forward(seen))
