"""The environments keep the contracts of Gymnasium, PettingZoo and stable-baselines3."""

from __future__ import annotations

import importlib
import warnings
from typing import Any

import gymnasium
import numpy as np
import pettingzoo
import pytest
import torch
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from helpers import same
from pettingzoo.test import (
    api_test,
    parallel_api_test,
    parallel_seed_test,
    render_test,
    seed_test,
    state_test,
)
from pettingzoo.utils.conversions import parallel_to_aec
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy

import asv_env
from asv_env.envs.sb3 import BoatVecEnv
from asv_env.sensing.global_state import global_state, global_state_bound

TASKS = asv_env.TASKS
TEAMS = (2, 4, 10)
tasks = pytest.mark.parametrize("task", TASKS)
teams = pytest.mark.parametrize("num_boats", TEAMS)


@pytest.fixture(autouse=True)
def _no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.fixture(scope="module", autouse=True)
def _one_thread() -> None:
    torch.set_num_threads(1)


# PettingZoo has a registry from 1.27 on.
registry = pytest.mark.skipif(not hasattr(pettingzoo, "make"), reason="PettingZoo is too old")


def gym_id(task: str) -> str:
    return f"asv_env/{task.capitalize()}-v0"


# ------------------------------------------------------------------ Gymnasium


@tasks
@teams
def test_check_env_finds_nothing(task: str, num_boats: int) -> None:
    env = gymnasium.make(gym_id(task), num_boats=num_boats)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=num_boats != 4)


@tasks
@teams
def test_make_gives_one_agent_that_drives_all_boats(task: str, num_boats: int) -> None:
    env = gymnasium.make(gym_id(task), num_boats=num_boats)
    assert env.observation_space.shape == (num_boats, len(asv_env.sensing.observation.BOUND))
    assert env.action_space.shape == (num_boats, 2)
    assert env.spec is not None
    assert env.spec.max_episode_steps == env.unwrapped.params.time_limit_ticks
    observation, info = env.reset(seed=0)
    assert observation in env.observation_space
    names = info.keys()
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert observation in env.observation_space
    assert [type(value) for value in (reward, terminated, truncated)] == [float, bool, bool]
    assert info.keys() == names
    terms = [value for name, value in info.items() if name.startswith("reward_")]
    assert reward == pytest.approx(sum(terms))
    assert not env.unwrapped.close()


@tasks
@teams
def test_make_vec_gives_the_batched_simulation(task: str, num_boats: int) -> None:
    env = gymnasium.make_vec(gym_id(task), num_envs=5, num_boats=num_boats)
    assert isinstance(env, asv_env.AsvVectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    observation, _ = env.reset(seed=0)
    assert observation in env.observation_space
    assert observation.shape == (5, num_boats, len(asv_env.sensing.observation.BOUND))
    observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
    assert observation in env.observation_space
    assert reward.shape == terminated.shape == truncated.shape == (5,)
    env.close()


@tasks
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize(
    ("scenario", "num_boats", "time_limit"),
    [("nominal", 4, 0.5), ("harsh", 9, 1.2), ("harsh", 2, 6.3)],
)
def test_the_vector_env_is_a_sync_vector_env_to_the_bit(
    task: str, mode: AutoresetMode, scenario: str, num_boats: int, time_limit: float
) -> None:
    # 6.3 s are 63 noisy measurements after the first: with 64 a block of noise is used up.
    options = {"num_boats": num_boats, "scenario": scenario, "time_limit": time_limit}
    ours: VectorEnv = gymnasium.make_vec(gym_id(task), num_envs=3, autoreset_mode=mode, **options)
    theirs = SyncVectorEnv(
        [lambda: asv_env.JointEnv(task, **options) for _ in range(3)], autoreset_mode=mode
    )
    ends = 0
    for seed in (7, [3, 1, 4]):
        assert same(ours.reset(seed=seed), theirs.reset(seed=seed))
        theirs.action_space.seed(5)
        for step in range(round(12 * time_limit)):
            action = theirs.action_space.sample()
            left, right = ours.step(action), theirs.step(action)
            for name, one, other in zip(
                ("observation", "reward", "terminated", "truncated", "info"),
                left,
                right,
                strict=True,
            ):
                assert same(one, other), f"{name} differs at step {step}"
            ends += int(left[3].sum())
    assert ends >= 6


@pytest.mark.parametrize("flat", [False, True])
def test_without_autoreset_it_is_a_sync_vector_env_too(flat: bool) -> None:
    options: dict[str, Any] = {"num_boats": 2, "scenario": "harsh", "time_limit": 0.5, "flat": flat}
    mode = AutoresetMode.DISABLED
    ours = gymnasium.make_vec(gym_id("push"), num_envs=3, autoreset_mode=mode, **options)
    theirs = SyncVectorEnv(
        [lambda: asv_env.JointEnv("push", **options) for _ in range(3)], autoreset_mode=mode
    )
    theirs.action_space.seed(5)
    mask = np.array([True, True, False])
    assert same(ours.reset(seed=3), theirs.reset(seed=3))
    for step in range(1, 16):
        action = theirs.action_space.sample()
        assert same(ours.step(action), theirs.step(action)), step
        if step == 2:
            one, other = ({"reset_mask": mask.copy()} for _ in range(2))
            assert same(ours.reset(options=one), theirs.reset(options=other))
        if step in (5, 7, 10, 12):  # world 2 ends first, and the others two steps later
            over = mask if step in (7, 12) else ~mask
            one, other = ({"reset_mask": over.copy()} for _ in range(2))
            assert same(ours.reset(options=one), theirs.reset(options=other))


def test_without_autoreset_a_mask_resets_worlds() -> None:
    env = asv_env.AsvVectorEnv(3, "push", autoreset_mode="Disabled", time_limit=0.5)
    first, _ = env.reset(seed=0)
    for _ in range(5):
        last, _, _, truncated, _ = env.step(np.zeros(env.action_space.shape))
    assert truncated.all()
    with pytest.raises(ValueError, match="reset_mask"):
        env.step(np.zeros(env.action_space.shape))
    mask = np.array([False, True, False])
    again, _ = env.reset(seed=[None, 1, None], options={"reset_mask": mask})
    assert np.array_equal(again[1], first[1])
    assert np.array_equal(again[~mask], last[~mask])


# ------------------------------------------------------------------ PettingZoo


@tasks
@teams
def test_parallel_api(task: str, num_boats: int) -> None:
    env = asv_env.parallel_env(task, num_boats)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="reset option 'options' is unknown")
        parallel_api_test(env, num_cycles=100)


@registry
@tasks
def test_pettingzoo_makes_what_is_registered(task: str) -> None:
    env = pettingzoo.make("parallel", f"asv_env/{task}-v0", num_boats=3, max_cycles=7)
    assert isinstance(env, asv_env.AsvParallelEnv)
    assert (env.params.task.name, env.params.num_boats) == (task, 3)
    assert env.params.time_limit_ticks == 7
    env = pettingzoo.make("parallel", f"asv_env/{task}-v0", max_cycles=-1)
    assert env.params.time_limit_ticks > 1000


@tasks
def test_the_turn_based_api_of_the_converted_env(task: str) -> None:
    api_test(parallel_to_aec(asv_env.parallel_env(task, 2)), num_cycles=50)


@tasks
@teams
def test_parallel_seeds(task: str, num_boats: int) -> None:
    parallel_seed_test(lambda: asv_env.parallel_env(task, num_boats), num_cycles=20)


def test_the_generator_for_wrappers_follows_the_seed() -> None:
    env = asv_env.parallel_env("push", 2)
    drawn = []
    for seed in (3, None, 3):
        env.reset(seed=seed)
        drawn.append(env.np_random.integers(10**9))
    assert drawn[0] == drawn[2] != drawn[1]


@tasks
def test_seeds_of_the_converted_env_over_many_steps(task: str) -> None:
    seed_test(lambda: parallel_to_aec(asv_env.parallel_env(task, 4)), num_cycles=100)


@tasks
@teams
def test_state(task: str, num_boats: int) -> None:
    env = asv_env.parallel_env(task, num_boats)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        state_test(parallel_to_aec(asv_env.parallel_env(task, num_boats)), env, num_cycles=20)
    assert env.state_space.shape == (len(global_state_bound(num_boats)),)
    assert env.state().dtype == np.float32


@pytest.mark.parametrize("scenario", ["nominal", "harsh"])
def test_the_state_stays_within_its_bounds(scenario: str) -> None:
    params = asv_env.make_params("transport", 10, scenario)
    simulation = asv_env.Simulation(params, 8)
    simulation.reset(seeds=range(8))
    rng = np.random.default_rng(0)
    for _ in range(50):
        step = simulation.step(rng.uniform(-1, 1, (8, 10, 2)))
        view = global_state(simulation.state, params)
        assert (np.abs(view) <= global_state_bound(10)).all()
        over = step.ending.terminated | step.ending.truncated
        if over.any():
            simulation.reset(over)
    assert view.std(axis=0).any()


@tasks
def test_render(task: str) -> None:
    def make(**options: Any) -> Any:
        return parallel_to_aec(asv_env.parallel_env(task, 2, **options))

    render_test(make)


def test_every_agent_keeps_its_own_spaces() -> None:
    env = asv_env.parallel_env(num_boats=3)
    spaces = [env.action_space(agent) for agent in env.possible_agents]
    assert [id(env.action_space(agent)) for agent in env.possible_agents] == list(map(id, spaces))
    assert len(set(map(id, spaces))) == 3, "seeding one agent's space leaves the others alone"


def test_max_cycles_set_from_outside_changes_nothing() -> None:
    env = asv_env.parallel_env("push", time_limit=0.5)
    env.max_cycles = 2
    env.reset(seed=0)
    steps = 0
    while env.agents:
        env.step({agent: np.zeros(2, np.float32) for agent in env.agents})
        steps += 1
    assert steps == 5


@pytest.mark.parametrize("make", ["joint", "parallel", "vector", "boats"])
def test_every_adapter_draws(make: str) -> None:
    adapters: dict[str, Any] = {
        "joint": lambda: asv_env.JointEnv("push", 2, render_mode="rgb_array"),
        "parallel": lambda: asv_env.parallel_env("push", 2, render_mode="rgb_array"),
        "vector": lambda: asv_env.AsvVectorEnv(2, "push", 2, render_mode="rgb_array"),
        "boats": lambda: BoatVecEnv("push", 2, 2, render_mode="rgb_array"),
    }
    env = adapters[make]()
    env.reset()
    frames = env.render()
    for frame in frames if make == "vector" else [frames]:
        assert frame.dtype == np.uint8
        assert frame.ndim == 3
        assert frame.std() > 0
    assert env.metadata["render_fps"] == 10
    env.close()
    env.close()


def test_importing_again_registers_nothing_twice() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        importlib.reload(asv_env)
    assert {gym_id(task) for task in TASKS} <= gymnasium.registry.keys()
    zoo = getattr(pettingzoo, "parallel_registry", dict.fromkeys(f"asv_env/{t}-v0" for t in TASKS))
    assert {f"asv_env/{task}-v0" for task in TASKS} <= zoo.keys()
    assert callable(asv_env.parallel_env)


# ------------------------------------------------------------------ stable-baselines3


@tasks
@pytest.mark.parametrize("num_boats", [2, 4, 10])
def test_ppo_trains_is_saved_loaded_and_used(task: str, num_boats: int, tmp_path: Any) -> None:
    env = BoatVecEnv(task, num_envs=8, num_boats=num_boats, time_limit=2.0, stagger=True)
    rows = 8 * num_boats
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=256, n_epochs=2, seed=3, device="cpu")
    model.learn(4000)
    assert len(model.ep_info_buffer) > 0, "episodes are logged without a Monitor"
    assert len(model.ep_success_buffer) > 0
    model.save(tmp_path / "model")

    loaded = PPO.load(tmp_path / "model", env=env, device="cpu")
    env.seed(5)
    observation = env.reset()
    action, _ = loaded.predict(observation, deterministic=True)
    assert np.array_equal(action, model.predict(observation, deterministic=True)[0])
    observation, reward, done, infos = env.step(action)
    assert observation.shape == (rows, *env.observation_space.shape)
    assert reward.dtype == np.float32
    assert (len(infos), done.shape) == (rows, (rows,))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mean, _ = evaluate_policy(loaded, env, n_eval_episodes=rows)
    assert np.isfinite(mean)
