"""Every option of a world alone in every adapter, and all pairs of them in the simulation."""

from functools import cache
from itertools import combinations

import gymnasium
import numpy as np
import pytest

import asv_env
from asv_env.presets import make_params
from asv_env.render.viewer import Viewer
from asv_env.simulation import Simulation
from baselines.distributed import distributed
from baselines.rollout.loop import rollout
from baselines.scripted.scripted_policy import ScriptedPolicy

OPTIONS = {
    "L": {"vessel": "L"},
    "disc": {"vessel": "disc"},
    "own outline": {"vessel": {"outline": [(-0.2, -0.05), (0.25, -0.08), (0.1, 0.12)]}},
    "pillars": {"obstacles": "pillars"},
    "channel": {"obstacles": "channel"},
    "dock": {"obstacles": "dock"},
    "given obstacle": {"obstacles": [{"centre": (1.0, 1.0), "radius": 0.1}]},
    "own sensing": {
        "sensors": {
            "shared": False,
            "range": 1.0,
            "delay": 0.2,
            "dropout": 0.1,
            "position_noise": 0.01,
        }
    },
    "gusts": {"water": {"gust_speed": 0.01}},
    "shelter": {"water": {"shelter": 0.3, "current": "gyre", "current_speed": 0.01}},
    "unlike boats": {"variation": {"boat_size": 0.15, "thrust": 0.2, "load": (1.0, 2.0)}},
    "late failure": {
        "variation": {"failures": 1, "failure_clock": "closure", "actuation_delay": 0.1}
    },
    "easy": {"difficulty": "easy"},
    "holding": {"delivery_time": 10.0, "side": "goal"},
}
SEEDS = [10**8, 10**8 + 1]


def together(one, other):
    """Two sets of options as one; sections that both have are joined."""
    joined = dict(one)
    for name, value in other.items():
        if name in joined and isinstance(value, dict) and "outline" not in value:
            value = {**joined[name], **value}
        joined[name] = value
    return joined


PAIRS = {
    f"{a} and {b}": together(OPTIONS[a], OPTIONS[b])
    for a, b in combinations(OPTIONS, 2)
    if not ({"vessel", "obstacles"} & OPTIONS[a].keys() & OPTIONS[b].keys())
}


def run(params, ticks):
    """Motions (ticks, W, B, 6) of the scripted policy from seeds, and the state at the end."""
    simulation = Simulation(params, len(SEEDS))
    policy = distributed(ScriptedPolicy(params), params)
    motions = [
        simulation.state.motion.copy() for _ in rollout(simulation, policy.act, SEEDS, ticks)
    ]
    return np.array(motions), simulation.state


@pytest.mark.parametrize("option", OPTIONS)
def test_options_are_seeded_to_the_bit(option):
    params = make_params("transport", **OPTIONS[option])
    np.testing.assert_array_equal(run(params, 4)[0], run(params, 4)[0])


@pytest.mark.parametrize("pair", PAIRS)
def test_pairs_run_with_the_scripted_policy_and_are_drawn(pair):
    task = "push" if len(pair) % 2 else "transport"
    params = make_params(task, **PAIRS[pair])
    motions, state = run(params, 3)
    assert np.isfinite(motions).all()
    frame = Viewer(params, size=(240, 240)).draw(state)
    assert len(np.unique(frame.reshape(-1, 3), axis=0)) > 20


@cache
def first_observations(option):
    """Observations (2, A, K) of the first episodes, and after a step at half speed."""
    simulation = Simulation(make_params("push", **OPTIONS[option]), len(SEEDS))
    begun = simulation.reset(seeds=SEEDS)
    stepped = simulation.step(np.full((2, 4, 2), 0.5)).observation
    return begun, stepped


@pytest.mark.parametrize("option", OPTIONS)
def test_every_adapter_takes_every_option_and_gives_the_same_observations(option):
    options = OPTIONS[option]
    begun, stepped = first_observations(option)
    half = np.full((4, 2), 0.5, dtype=np.float32)

    joint = gymnasium.make("asv_env/Push-v0", disable_env_checker=True, **options)
    np.testing.assert_array_equal(joint.reset(seed=SEEDS[0])[0], begun[0])
    np.testing.assert_array_equal(joint.step(half)[0], stepped[0])

    parallel = asv_env.parallel_env("push", **options)
    seen, _ = parallel.reset(seed=SEEDS[1])
    np.testing.assert_array_equal(np.stack(list(seen.values())), begun[1])
    seen = parallel.step(dict(zip(parallel.agents, half, strict=True)))[0]
    np.testing.assert_array_equal(np.stack(list(seen.values())), stepped[1])

    vector = asv_env.AsvVectorEnv(2, "push", **options)
    np.testing.assert_array_equal(vector.reset(seed=SEEDS)[0], begun)
    np.testing.assert_array_equal(vector.step(np.stack([half, half]))[0], stepped)

    rows = asv_env.BoatVecEnv("push", num_envs=2, **options)
    rows.seed(SEEDS[0])
    np.testing.assert_array_equal(rows.reset().reshape(begun.shape)[0], begun[0])
    rows.step_async(np.full((8, 2), 0.5))
    np.testing.assert_array_equal(rows.step_wait()[0].reshape(stepped.shape)[0], stepped[0])
