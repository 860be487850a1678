"""What the adapters report to a learner: ends, last observations, values of time limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.vector import AutoresetMode
from stable_baselines3 import PPO
from stable_baselines3.common.utils import obs_as_tensor

import asv_env
from asv_env.envs.sb3 import BoatVecEnv

IDLE, AHEAD = np.array([0.0, 0.0]), np.array([1.0, 0.0])


@pytest.fixture(scope="module", autouse=True)
def _one_thread() -> None:
    torch.set_num_threads(1)


@dataclass
class End:
    """Report of an adapter on the end of the first episode of its first world."""

    terminated: bool
    truncated: bool
    info: dict[str, Any]
    observation: np.ndarray
    steps: int


def joint(task: str, action: np.ndarray, **options: Any) -> End:
    env = asv_env.JointEnv(task, **options)
    env.reset(seed=0)
    for step in range(1, 1000):
        observation, _, terminated, truncated, info = env.step(np.tile(action, (4, 1)))
        if terminated or truncated:
            return End(terminated, truncated, info, observation, step)
    raise AssertionError("no end")


def parallel(task: str, action: np.ndarray, **options: Any) -> End:
    env = asv_env.parallel_env(task, **options)
    env.reset(seed=0)
    for step in range(1, 1000):
        agents = env.agents
        observation, _, terminated, truncated, infos = env.step(dict.fromkeys(agents, action))
        if not env.agents:
            assert len(set(terminated.values())) == len(set(truncated.values())) == 1
            seen = np.stack([observation[agent] for agent in agents])
            return End(terminated["asv_2"], truncated["asv_2"], infos["asv_2"], seen, step)
    raise AssertionError("no end")


def vector(mode: AutoresetMode) -> Callable[..., End]:
    def run(task: str, action: np.ndarray, **options: Any) -> End:
        env = asv_env.AsvVectorEnv(3, task, autoreset_mode=mode, **options)
        env.reset(seed=0)
        for step in range(1, 1000):
            observation, _, terminated, truncated, infos = env.step(np.tile(action, (3, 4, 1)))
            if terminated[0] or truncated[0]:
                last = observation[0]
                if mode is AutoresetMode.SAME_STEP:
                    last, infos = infos["final_obs"][0], infos["final_info"]
                info = {k: v[0] for k, v in infos.items() if isinstance(v, np.ndarray)}
                return End(bool(terminated[0]), bool(truncated[0]), info, last, step)
        raise AssertionError("no end")

    return run


def boats(task: str, action: np.ndarray, **options: Any) -> End:
    env = BoatVecEnv(task, num_envs=3, **options)
    env.seed(0)
    env.reset()
    for step in range(1, 1000):
        _, _, dones, infos = env.step(np.tile(action, (12, 1)))
        if dones[0]:
            assert dones[:4].all()
            truncated = [info["TimeLimit.truncated"] for info in infos[:4]]
            assert len(set(truncated)) == 1
            last = np.stack([info["terminal_observation"] for info in infos[:4]])
            return End(not truncated[0], truncated[0], infos[2], last, step)
        assert not any("terminal_observation" in info for info in infos[:4])
    raise AssertionError("no end")


ADAPTERS = {
    "joint": joint,
    "parallel": parallel,
    "vector, next step": vector(AutoresetMode.NEXT_STEP),
    "vector, same step": vector(AutoresetMode.SAME_STEP),
    "boats": boats,
}
adapters = pytest.mark.parametrize("run", ADAPTERS.values(), ids=ADAPTERS.keys())

# The vessel lies on its goal; a boat leaves the arena; time is up; success as time is up.
DELIVERED = ("push", IDLE, {"goal": (0.0, 0.0, 0.0), "delivery_time": 0.3})
STRAYED = ("approach", AHEAD, {"arena": 1.52})
TIMED_OUT = ("push", AHEAD, {"time_limit": 0.7, "goal": (1.0, 0.0, 0.0)})
DELIVERED_AT_LAST = ("push", IDLE, {**DELIVERED[2], "time_limit": 0.3})


@adapters
@pytest.mark.parametrize(
    ("case", "success"), [(DELIVERED, True), (DELIVERED_AT_LAST, True), (STRAYED, False)]
)
def test_success_and_straying_terminate(run: Callable[..., End], case: Any, success: bool) -> None:
    task, action, options = case
    end = run(task, action, **options)
    assert (end.terminated, end.truncated) == (True, False)
    assert bool(end.info["is_success"]) is success
    assert bool(end.info["strayed"]) is not success


@adapters
def test_the_time_limit_truncates(run: Callable[..., End]) -> None:
    task, action, options = TIMED_OUT
    end = run(task, action, **options)
    assert (end.terminated, end.truncated) == (False, True)
    assert end.steps == 7
    assert not end.info["is_success"]
    assert end.info["position_error"] == pytest.approx(1.0, abs=0.05)


@adapters
@pytest.mark.parametrize("case", [STRAYED, TIMED_OUT])
def test_the_last_observation_is_what_the_world_showed_at_its_end(
    run: Callable[..., End], case: Any
) -> None:
    task, action, options = case
    simulation = asv_env.Simulation(asv_env.make_params(task, **options))
    simulation.reset(seeds=[0])
    while True:
        step = simulation.step(np.tile(action, (1, 4, 1)))
        if step.ending.terminated[0] or step.ending.truncated[0]:
            break
    end = run(task, action, **options)
    assert end.observation.tobytes() == step.observation[0].tobytes()


@adapters
def test_the_last_info_holds_the_metrics_as_scalars(run: Callable[..., End]) -> None:
    task, action, options = TIMED_OUT
    info = run(task, action, **options).info
    simulation = asv_env.Simulation(asv_env.make_params(task, **options))
    simulation.reset(seeds=[0])
    names = simulation.summary().keys()
    assert names <= info.keys()
    assert {"is_success", "position_error", "heading_error", "episode_return"} <= names
    assert all(np.ndim(info[name]) == 0 for name in names)
    assert np.isinf(info["time_to_goal"])


def test_single_worlds_give_python_scalars_and_every_reward_term() -> None:
    env = asv_env.parallel_env("push", 2)
    env.reset(seed=0)
    _, rewards, _, _, infos = env.step(dict.fromkeys(env.agents, AHEAD))
    for agent, reward in rewards.items():
        terms = [value for name, value in infos[agent].items() if name.startswith("reward_")]
        assert {type(value) for value in terms} == {float}
        assert sum(terms) == pytest.approx(reward)
    assert infos["asv_0"] is not infos["asv_1"]
    end = parallel(TIMED_OUT[0], TIMED_OUT[1], **TIMED_OUT[2])
    assert {type(value) for value in end.info.values()} == {bool, int, float}


# ------------------------------------------------------------------ the value of a time limit


class OneEachStep(BoatVecEnv):
    """Reward 1 each step, and never an end but the time limit of ten steps."""

    def __init__(self) -> None:
        super().__init__("push", 8, 2, time_limit=1.0, goal=(1.0, 0.0, 0.0))

    def step_wait(self) -> Any:
        observation, reward, dones, infos = super().step_wait()
        return observation, np.ones_like(reward), dones, infos


class WithoutTruncation(OneEachStep):
    """A wrong adapter, which reports the time limit as a termination."""

    def step_wait(self) -> Any:
        observation, reward, dones, infos = super().step_wait()
        for info in infos:
            info.pop("TimeLimit.truncated", None)
        return observation, reward, dones, infos


def learned_value(env: BoatVecEnv) -> float:
    """Mean over an episode of the value that PPO learns with gamma 0.9."""
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=20,
        batch_size=320,
        n_epochs=10,
        gamma=0.9,
        learning_rate=1e-2,
        max_grad_norm=10.0,
        policy_kwargs={"net_arch": {"pi": [4], "vf": [32]}},
        seed=0,
        device="cpu",
    )
    model.learn(30 * 20 * env.num_envs)
    seen = [env.reset()]
    while not (step := env.step(np.stack([env.action_space.sample()] * env.num_envs)))[2].any():
        seen.append(step[0])
    with torch.no_grad():
        values = model.policy.predict_values(obs_as_tensor(np.concatenate(seen), model.device))
    return values.mean().item()


def test_a_constant_reward_is_worth_ten_whatever_the_time_limit() -> None:
    assert learned_value(OneEachStep()) == pytest.approx(10.0, abs=0.5)


def test_a_time_limit_that_passes_for_a_termination_is_noticed() -> None:
    assert learned_value(WithoutTruncation()) < 5.0


# ------------------------------------------------------------------ the stable-baselines3 adapter


def test_the_boats_of_a_world_share_the_seed_and_options_of_its_first_row() -> None:
    env = BoatVecEnv("transport", 3, 2)
    goals = [[1.0, 0.5, 0.0], [-1.0, 0.0, 1.0], None]
    env.seed(11)
    env.set_options([{"goal": goal} for goal in goals for _ in range(2)])
    rows = env.reset()
    for world, goal in enumerate(goals):
        single = asv_env.JointEnv("transport", 2)
        options = {"goal": goal} if goal else None
        expected, _ = single.reset(seed=11 + 2 * world, options=options)
        assert rows[2 * world : 2 * world + 2].tobytes() == expected.tobytes()
    assert env._seeds == [None] * 6, "seeds are used once"
    assert len(env.reset_infos) == 6
    env.reset()
    assert not np.array_equal(env.simulation.state.goal[0], goals[0]), "options are used once"


def test_rows_of_ended_worlds_begin_the_next_episode_and_report_the_last() -> None:
    env = BoatVecEnv("push", 2, 2, time_limit=0.3, goal=(1.0, 0.0, 0.0))
    env.seed(0)
    first = env.reset()
    total = np.zeros(4)
    for _ in range(3):
        observation, reward, dones, infos = env.step(np.ones((4, 2)))
        total += reward
    assert dones.all()
    assert observation.tobytes() == first.tobytes(), "Push with a fixed goal has but one start"
    for info, expected in zip(infos, total, strict=True):
        assert info["episode"]["l"] == 3
        assert info["episode"]["r"] == pytest.approx(expected, rel=1e-5)
        assert info["episode"]["t"] >= 0
        assert not np.array_equal(info["terminal_observation"], observation[0])
    env.step(np.ones((4, 2)))
    assert env.simulation.state.tick.tolist() == [1, 1]


def test_staggered_worlds_truncate_one_after_the_other_and_then_run_full_length() -> None:
    env = BoatVecEnv("push", 5, 2, stagger=True, time_limit=1.0, goal=(1.0, 0.0, 0.0))
    for _ in range(2):
        env.reset()
        ends = [np.flatnonzero(env.step(np.zeros((10, 2)))[2][::2]).tolist() for _ in range(20)]
        first, second = ends[:10], ends[10:]
        assert [worlds for worlds in first if worlds] == [[0], [1], [2], [3], [4]]
        assert [step for step, worlds in enumerate(first, 1) if worlds] == [2, 4, 6, 8, 10]
        assert [step for step, worlds in enumerate(second, 11) if worlds] == [12, 14, 16, 18, 20]


def test_the_attributes_of_rows_are_those_of_the_environment() -> None:
    env = BoatVecEnv("push", 2, 2)
    assert env.get_attr("num_worlds") == [2] * 4
    assert env.get_attr("num_worlds", indices=[0, 3]) == [2, 2]
    assert env.has_attr("params")
    assert not env.has_attr("nonsense")
    env.set_attr("label", "x")
    assert env.env_method("get_attr", "label", indices=1) == [["x"] * 4]
    assert env.env_is_wrapped(gymnasium.wrappers.TimeLimit) == [False] * 4


# ------------------------------------------------------------------ what is returned, what is taken


def test_returned_arrays_are_never_written_again() -> None:
    action = np.ones((2, 2, 2))
    vec = asv_env.AsvVectorEnv(2, "push", 2, autoreset_mode="SameStep", time_limit=0.3)
    sb3 = BoatVecEnv("push", 2, 2, time_limit=0.3)
    kept = [vec.reset(seed=0)[0], sb3.reset()]
    for _ in range(5):
        observation, reward, terminated, truncated, _ = vec.step(action)
        kept += [observation, reward, terminated, truncated]
        kept += sb3.step(action.reshape(4, 2))[:3]
    copies = [array.copy() for array in kept]
    for _ in range(5):
        vec.step(-action)
        sb3.step(-action.reshape(4, 2))
    assert all(np.array_equal(one, other) for one, other in zip(kept, copies, strict=True))
    kept[-3][...] = 7.0
    kept[-7][...] = 7.0
    assert not (vec.step(action)[0] == 7.0).any()


def test_actions_outside_the_bounds_are_clipped() -> None:
    ends = [joint("push", action, time_limit=1.0) for action in (AHEAD, 5.0 * AHEAD)]
    assert ends[0].observation.tobytes() == ends[1].observation.tobytes()


def test_a_goal_given_to_reset_holds_for_that_episode() -> None:
    env = asv_env.parallel_env("push", goal=(0.5, 0.0, 0.0))
    env.reset(seed=0, options={"goal": [0.55, -0.95, 0.1]})
    assert env.simulation.state.goal[0] == pytest.approx([0.55, -0.95, 0.1])
    env.reset()
    assert env.simulation.state.goal[0] == pytest.approx([0.5, 0.0, 0.0])
