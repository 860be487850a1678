"""Where a vessel comes to rest when the team lets go, against the physics."""

import numpy as np
import pytest
from helpers import begin_at, bodies, open_water

from asv_env import Simulation
from asv_env.tasks.formation import relate
from baselines.scripted import PathGains, PushGains
from baselines.scripted.settling import Settling

FAR = [(5.0, 5.0), (-5.0, -5.0)]
"""Where two boats leave the vessel alone."""
SHARE = 0.02
"""Largest error of the pose of rest, fraction of how far the vessel coasts and turns."""
WORLDS = 40


def seen_from(motion, goal):
    """The relations of vessels of these motions (W, B, 6) to the goals (W, 3)."""
    worlds, bodies = motion.shape[:2]
    return relate(motion, goal, np.zeros((worlds, bodies - 1), complex), np.ones(worlds))


@pytest.mark.parametrize(
    ("scales", "stream"),
    [
        ([0.003, 0.01, 0.02], 0.0),
        ([0.01, 0.03, 0.1], 0.0),
        ([0.01, 0.04, 0.3], 0.0),
        ([0.01, 0.03, 0.1], 0.01),
    ],
    ids=["slow", "fast", "turning", "current"],
)
def test_the_vessel_rests_where_it_is_expected_to(scales, stream):
    """The goal is where it begins, so that it coasts away from it; water carries both alike."""
    params = open_water(2, control=10, water={"current": "uniform", "current_speed": stream})
    settling = Settling(params, PushGains(), PathGains().still_water)
    rng, motion = np.random.default_rng(0), np.array([bodies((), *FAR)] * WORLDS)
    heading = rng.uniform(-np.pi, np.pi, WORLDS)
    u, v, yaw_rate = (rng.uniform(-1, 1, (WORLDS, 3)) * scales).T
    velocity = (u + 1j * v) * np.exp(1j * heading) + stream
    motion[:, 0, 2:] = np.stack([heading, velocity.real, velocity.imag, yaw_rate], axis=-1)
    goal, drift = motion[:, 0, :3].copy(), np.full(WORLDS, stream + 0j)
    expected, turned = settling.rest(seen_from(motion, goal), drift)

    simulation = Simulation(params, WORLDS)
    begin_at(simulation, list(motion))
    seconds = 100
    for _ in range(seconds * params.clock.control):
        simulation.step(np.zeros_like(simulation.state.thrust))
    goal[:, 0] += stream * seconds
    rests = seen_from(simulation.state.motion, goal)
    assert (np.abs(expected - rests.goal) < SHARE * rests.goal_error).all()
    assert (np.abs(turned - rests.heading_error) < SHARE * np.abs(rests.heading_error)).all()
