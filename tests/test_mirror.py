"""A team that pushes from the side away from the goal sees the mirror image of the world."""

import numpy as np
import pytest

from asv_env import Simulation, make_params
from asv_env.geometry import plane
from baselines.mirror import at_scale, mirror_image, view_from
from baselines.scripted.scripted_policy import ScriptedPolicy


class Driven:
    """Worlds in which the scripted policy acts on what the side away from the goal sees."""

    def __init__(self, params, seeds, **options):
        self.sim = Simulation(params, len(seeds), **options)
        self.sim.reset(seeds=seeds)
        self.params, self.scripted = params, ScriptedPolicy(params)
        self.push_side = self.memory = None
        self.fresh = np.ones(len(seeds), dtype=bool)

    def step(self):
        sensed = self.sim.sensed
        vessel = sensed.estimate[:, 0]
        goal = (plane(sensed.goal) - plane(vessel)) * np.exp(-1j * vessel[:, 2])
        away = np.where(goal.imag > 0, -1.0, 1.0)
        seen, self.push_side = view_from(self.params, sensed, self.push_side, self.fresh, away)
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
