"""The same seed gives the same bytes: in every process, through every adapter, in any batch.

Boats ram the vessel and each other: their actions are recorded once, from a rule that aims at
the vessel, and then replayed in open loop.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import asv_env
from asv_env.envs.sb3 import BoatVecEnv

STEPS, TEAM, BATCH, SEED = 260, 4, 64, 42
CASES = [(task, scenario) for task in ("push", "transport") for scenario in ("nominal", "harsh")]
OPTIONS = {"time_limit": 18.0}
cases = pytest.mark.parametrize(("task", "scenario"), CASES)

Record = tuple[bytes, bytes, bool, bool]
"""Observation (A, K), reward float32 (A,) or team mean, terminated, truncated."""


def make(task: str, scenario: str, worlds: int = 1) -> asv_env.Simulation:
    return asv_env.Simulation(asv_env.make_params(task, TEAM, scenario, **OPTIONS), worlds)


def ram(simulation: asv_env.Simulation) -> np.ndarray:
    """Actions (W, A, 2) at full speed, by turns at the vessel and at the middle of the team."""
    state = simulation.state
    at_team = (state.tick // 40 % 2 == 1)[:, None, None]
    boats = state.motion[:, 1:]
    aim = np.where(at_team, boats.mean(axis=1, keepdims=True), state.motion[:, :1])
    gap = (aim - boats)[..., :2]
    bearing = np.arctan2(gap[..., 1], gap[..., 0]) - boats[..., 2]
    turn = np.arctan2(np.sin(bearing), np.cos(bearing))
    return np.clip(np.stack([np.cos(turn), 2.0 * turn], axis=-1), -1.0, 1.0)


def record(observation: np.ndarray, reward: Any, terminated: Any, truncated: Any) -> Record:
    rewards = np.asarray(reward, dtype=np.float32)
    return observation.tobytes(), rewards.tobytes(), bool(terminated), bool(truncated)


def steps(
    simulation: asv_env.Simulation, actions: np.ndarray, worlds: list[int]
) -> list[list[Record]]:
    """Histories of some worlds; every world that ends begins its next episode at once."""
    histories: list[list[Record]] = [[] for _ in worlds]
    for action in actions:
        step = simulation.step(action)
        terminated, truncated = step.ending.terminated, step.ending.truncated
        for world, history in zip(worlds, histories, strict=True):
            ending = terminated[world], truncated[world]
            history.append(record(step.observation[world], step.reward[world], *ending))
        if (terminated | truncated).any():
            simulation.reset(terminated | truncated)
    return histories


def history(simulation: asv_env.Simulation, actions: np.ndarray, seed: int = SEED) -> list[Record]:
    """History of world 0."""
    simulation.reset(seeds=[seed + world for world in range(simulation.num_worlds)])
    return steps(simulation, actions, [0])[0]


@cache
def recorded(task: str, scenario: str) -> tuple[np.ndarray, list[Record], np.ndarray]:
    """Actions (STEPS, BATCH, A, 2), the history of world 0, the steps (2,) it is in contact."""
    simulation = make(task, scenario, BATCH)
    simulation.reset(seeds=range(SEED, SEED + BATCH))
    actions, records, contact = [], [], np.zeros(2)
    for _ in range(STEPS):
        actions.append(ram(simulation))
        records += steps(simulation, actions[-1:], [0])[0]
        contact += simulation.state.touching[0].any(axis=0)
    return np.array(actions), records, contact


def first_difference(one: list[Record], other: list[Record]) -> str:
    """Where two histories differ first, in words; empty if nowhere."""
    names = ("observation", "reward", "terminated", "truncated")
    for step, (left, right) in enumerate(zip(one, other, strict=True), 1):
        for name, a, b in zip(names, left, right, strict=True):
            if a != b:
                return f"{name} differs first at step {step}"
    return ""


def without_rewards(records: list[Record]) -> list[Record]:
    return [(step[0], b"", *step[2:]) for step in records]


def digest(records: list[Record]) -> str:
    return hashlib.sha256(repr(records).encode()).hexdigest()


# the recorded cases


@cases
def test_the_hulls_are_in_contact_and_episodes_end_on_the_way(task: str, scenario: str) -> None:
    _, records, contact = recorded(task, scenario)
    assert contact[0] > 0.4 * STEPS, "boats touch the vessel"
    assert contact[1] > 0.05 * STEPS, "boats touch each other"
    assert any(terminated or truncated for *_, terminated, truncated in records)


@cases
def test_another_seed_differs(task: str, scenario: str) -> None:
    actions, records, _ = recorded(task, scenario)
    assert first_difference(
        history(make(task, scenario), actions[:100, :1], SEED + 1), records[:100]
    )


# ------------------------------------------------------------------ processes


def digests(file: str) -> list[str]:
    """Digests of all the cases, from the actions in a file."""
    with np.load(file) as actions:
        return [digest(history(make(*case), actions["_".join(case)])) for case in CASES]


def test_the_same_seed_gives_the_same_bytes_in_another_process(tmp_path: Path) -> None:
    file = str(tmp_path / "actions.npz")
    np.savez(file, **{"_".join(case): recorded(*case)[0][:, :1] for case in CASES})
    child = subprocess.run(
        [sys.executable, __file__, file],
        env={**os.environ, "PYTHONHASHSEED": "1"},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert child.stdout.split() == [digest(recorded(*case)[1]) for case in CASES]


# ------------------------------------------------------------------ adapters


def by_joint(task: str, scenario: str, actions: np.ndarray) -> Iterator[Record]:
    env = asv_env.JointEnv(task, TEAM, scenario, **OPTIONS)
    env.reset(seed=SEED)
    for action in actions[:, 0]:
        observation, reward, terminated, truncated, _ = env.step(action)
        yield record(observation, reward, terminated, truncated)
        if terminated or truncated:
            env.reset()


def by_vector(task: str, scenario: str, actions: np.ndarray) -> Iterator[Record]:
    env = asv_env.AsvVectorEnv(
        actions.shape[1], task, TEAM, scenario, autoreset_mode="SameStep", **OPTIONS
    )
    env.reset(seed=SEED)
    for action in actions:
        observation, reward, terminated, truncated, infos = env.step(action)
        over = terminated[0] or truncated[0]
        last = infos["final_obs"][0] if over else observation[0]
        yield record(last, reward[0], terminated[0], truncated[0])


def by_parallel(task: str, scenario: str, actions: np.ndarray) -> Iterator[Record]:
    env = asv_env.parallel_env(task, TEAM, scenario=scenario, **OPTIONS)
    env.reset(seed=SEED)
    for action in actions[:, 0]:
        agents = env.agents
        seen, rewards, terminated, truncated, _ = env.step(dict(zip(agents, action, strict=True)))
        observation = np.stack([seen[agent] for agent in agents])
        reward = [rewards[agent] for agent in agents]
        yield record(observation, reward, terminated["asv_0"], truncated["asv_0"])
        if not env.agents:
            env.reset()


def by_boats(task: str, scenario: str, actions: np.ndarray) -> Iterator[Record]:
    env = BoatVecEnv(task, actions.shape[1], TEAM, scenario, **OPTIONS)
    # SB3 counts seeds in rows; in the other adapters they count in worlds.
    env._seeds = [SEED + row // TEAM for row in range(env.num_envs)]
    env.reset()
    for action in actions:
        observation, reward, dones, infos = env.step(action.reshape(-1, 2))
        truncated = dones[0] and infos[0]["TimeLimit.truncated"]
        if dones[0]:
            observation = np.stack([info["terminal_observation"] for info in infos[:TEAM]])
        yield record(observation[:TEAM], reward[:TEAM], dones[0] and not truncated, truncated)


@cases
@pytest.mark.parametrize("adapter", [by_parallel, by_boats])
def test_boats_as_agents_see_what_world_0_of_a_batch_sees(
    task: str, scenario: str, adapter: Callable[..., Iterator[Record]]
) -> None:
    actions, records, _ = recorded(task, scenario)
    assert not first_difference(list(adapter(task, scenario, actions[:, :1])), records)


@cases
@pytest.mark.parametrize("adapter", [by_joint, by_vector])
def test_one_agent_for_all_sees_what_world_0_of_a_batch_sees(
    task: str, scenario: str, adapter: Callable[..., Iterator[Record]]
) -> None:
    actions, records, _ = recorded(task, scenario)
    single = list(adapter(task, scenario, actions[:, :1]))
    team_means = [np.frombuffer(step[1], np.float32).mean() for step in records]
    rewards = [np.frombuffer(step[1], np.float32)[0] for step in single]
    assert rewards == pytest.approx(team_means, abs=1e-6)
    assert not first_difference(*map(without_rewards, (single, records)))


@cases
def test_world_0_is_the_same_alone_and_in_a_batch_of_64(task: str, scenario: str) -> None:
    actions, records, _ = recorded(task, scenario)
    assert not first_difference(history(make(task, scenario), actions[:, :1]), records)


def test_adapters_of_64_worlds_show_the_same_world_0() -> None:
    case = ("push", "harsh")
    actions, records, _ = recorded(*case)
    assert not first_difference(list(by_boats(*case, actions)), records)
    assert not first_difference(list(by_vector(*case, actions)), list(by_joint(*case, actions)))


# ------------------------------------------------------------------ other worlds, earlier episodes


@cases
def test_what_other_worlds_do_and_their_resets_change_nothing(task: str, scenario: str) -> None:
    worlds, compared = 8, [0, 5]
    actions = recorded(task, scenario)[0][:, :worlds].copy()
    seeds = range(SEED, SEED + worlds)
    simulation = make(task, scenario, worlds)
    simulation.reset(seeds=seeds)
    expected = steps(simulation, actions, compared)

    rng = np.random.default_rng(0)
    others = np.array([world not in compared for world in range(worlds)])
    actions[:, others] = rng.uniform((-0.3, -1.0), 1.0, actions[:, others].shape)
    simulation = make(task, scenario, worlds)
    simulation.reset(seeds=seeds)
    histories: list[list[Record]] = [[], []]
    for action in actions:
        for records, new in zip(histories, steps(simulation, action[None], compared), strict=True):
            records += new
        mask = others & (rng.random(worlds) < 0.02)
        if mask.any():
            simulation.reset(mask)
    assert not any(map(first_difference, histories, expected))


@cases
@pytest.mark.parametrize("before", [1, 200])
def test_a_reset_world_equals_a_fresh_one(task: str, scenario: str, before: int) -> None:
    actions, records, _ = recorded(task, scenario)
    simulation = make(task, scenario)
    history(simulation, actions[:before, :1], seed=7)
    assert not first_difference(history(simulation, actions[:, :1]), records)


@cases
def test_a_world_reset_in_contact_equals_a_fresh_one(task: str, scenario: str) -> None:
    worlds, compared = 8, [0, 3]
    actions = recorded(task, scenario)[0][:, :worlds]
    simulation = make(task, scenario, worlds)
    simulation.reset(seeds=range(SEED, SEED + worlds))
    expected = steps(simulation, actions[:200], compared)

    simulation = make(task, scenario, worlds)
    simulation.reset(seeds=range(7, 7 + worlds))
    pressed = np.zeros(worlds, dtype=np.bool_)
    for _ in range(300):
        steps(simulation, ram(simulation)[None], compared)
        pressed = simulation.state.touching.any(axis=(1, 2))
        if pressed[compared].all() and (simulation.state.tick[compared] > 20).all():
            break
    assert pressed[compared].all()
    simulation.reset(seeds=range(SEED, SEED + worlds))
    again = steps(simulation, actions[:200], compared)
    assert not any(map(first_difference, again, expected))


if __name__ == "__main__":
    print(*digests(sys.argv[1]))
