"""Infos have the same keys and types at every reset and step, and nothing in them is NaN."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from helpers import same

import asv_env
from asv_env.tasks import Metric

TASKS = pytest.mark.parametrize("task", asv_env.TASKS)
OPTIONS: dict[str, Any] = {"num_boats": 3, "scenario": "harsh", "time_limit": 0.6}


def infos_of(env: Any, steps: int = 20) -> Iterator[dict[str, Any]]:
    """Infos of an environment whose every info is that of one agent, from reset to reset."""
    rng = np.random.default_rng(0)
    yield env.reset(seed=0)[1]
    for _ in range(steps):
        _, _, terminated, truncated, info = env.step(rng.uniform(-1.0, 1.0, env.action_space.shape))
        yield info
        if terminated or truncated:
            yield env.reset()[1]


def structure(info: dict[str, Any]) -> dict[str, Any]:
    return {name: type(value) for name, value in info.items()}


@TASKS
def test_every_info_of_one_agent_has_the_same_structure(task: str) -> None:
    infos = list(infos_of(asv_env.JointEnv(task, **OPTIONS)))
    names = {f"reward_{term.name}" for term in asv_env.TASKS[task].reward}
    assert names | {"is_success", "time_to_closure", "episode_return"} <= infos[0].keys()
    assert not any(infos[0][name] for name in names), "no step has been rewarded yet"
    for info in infos:
        assert structure(info) == structure(infos[0])
        assert set(structure(info).values()) == {bool, int, float}
        assert not any(np.isnan(value) for value in info.values())
    repeated = list(infos_of(asv_env.JointEnv(task, **OPTIONS)))
    assert data_equivalence(infos, repeated, exact=True)


@TASKS
def test_every_agent_has_its_own_terms_and_the_metrics_of_all(task: str) -> None:
    env, joint = asv_env.parallel_env(task, **OPTIONS), asv_env.JointEnv(task, **OPTIONS)
    _, infos = env.reset(seed=0)
    _, expected = joint.reset(seed=0)
    action = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 2))
    while True:
        assert infos.keys() == set(env.possible_agents)
        for name, value in expected.items():
            mean = np.mean([info[name] for info in infos.values()])
            assert mean == pytest.approx(float(value)), name
        assert {tuple(structure(info).items()) for info in infos.values()} == {
            tuple(structure(expected).items())
        }
        if not env.agents:
            break
        _, rewards, *_, infos = env.step(dict(zip(env.agents, action, strict=True)))
        *_, expected = joint.step(action)
        for agent, info in infos.items():
            terms = [value for name, value in info.items() if name.startswith("reward_")]
            assert sum(terms) == pytest.approx(rewards[agent])
    assert len({info["reward_effort"] for info in infos.values()}) == 3


def test_metrics_of_an_episode_are_those_so_far_and_begin_again() -> None:
    env = asv_env.JointEnv("push", 2, time_limit=0.5, goal=(0.0, 0.0, 0.0), delivery_time=0.1)
    _, info = env.reset(seed=0)
    assert (info["is_success"], info["time_to_goal"], info["effort"]) == (False, np.inf, 0.0)
    *_, info = env.step(np.zeros((2, 2)))
    assert (info["is_success"], info["time_to_goal"]) == (True, 0.1)
    assert info["episode_return"] > 1.0
    _, again = env.reset(seed=0)
    assert (again["is_success"], again["time_to_goal"], again["episode_return"]) == (
        False,
        np.inf,
        0.0,
    )


@pytest.mark.parametrize("dtype", [np.float32, np.int8, np.uint16, np.bool_, np.float64])
@pytest.mark.parametrize("mode", AutoresetMode)
def test_metrics_of_any_type_are_as_in_a_sync_vector_env(dtype: Any, mode: AutoresetMode) -> None:
    def count(state: Any, relations: Any, params: Any) -> np.ndarray:
        return (state.tick > 2).astype(dtype)

    task = asv_env.TASKS["push"]
    own = type(task)(**{**vars(task), "metrics": (Metric("own", count),)})
    options: dict[str, Any] = {"task": own, "num_boats": 2, "max_episode_steps": 4}
    ours = asv_env.AsvVectorEnv(2, autoreset_mode=mode, **options)
    theirs = SyncVectorEnv([lambda: asv_env.JointEnv(**options)] * 2, autoreset_mode=mode)
    assert same(ours.reset(seed=1), theirs.reset(seed=1))
    for _ in range(4 if mode is AutoresetMode.DISABLED else 9):
        action = np.full(ours.action_space.shape, 0.5)
        one, other = ours.step(action), theirs.step(action)
        assert same(one, other)
    assert one[4]["own"].dtype == {"b": np.bool_, "i": np.int64, "u": np.int64}.get(
        np.dtype(dtype).kind, np.float64
    )
