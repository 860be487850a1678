"""Copies and pickles of every adapter continue like the original, at any stage, in any order."""

from __future__ import annotations

import copy
import os
import pickle
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from helpers import same
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule, run_state_machine_as_test
from pettingzoo.utils import BaseParallelWrapper

import asv_env
from asv_env.envs.sb3 import BoatVecEnv

HARSH: dict[str, Any] = {"scenario": "harsh", "num_boats": 2}
SHORT: dict[str, Any] = {**HARSH, "time_limit": 0.6, "render_mode": "rgb_array"}
GOAL = {"goal": (0.4, -0.3, 0.2)}


@pytest.fixture(autouse=True)
def _no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def copied(env: Any) -> Any:
    return copy.deepcopy(env)


def pickled(env: Any) -> Any:
    return pickle.loads(pickle.dumps(env))


class Driver:
    """Calls of a Gymnasium environment; a ``single`` one needs a reset after its end."""

    def __init__(self, make: Callable[..., Any], single: bool = False) -> None:
        self.make, self.single = make, single

    def spaces(self, env: Any) -> list[Any]:
        return [env.action_space, env.observation_space]

    def action(self, env: Any, seed: int) -> Any:
        rng = np.random.default_rng(seed)
        return rng.uniform(-1.0, 1.0, env.action_space.shape).astype(np.float32)

    def reset(self, env: Any, seed: int | None, options: Any) -> Any:
        return env.reset(seed=seed, options=options)

    def step(self, env: Any, seed: int) -> Any:
        return env.step(self.action(env, seed))

    def drawn(self, env: Any) -> Any:
        return [space.sample() for space in self.spaces(env)], env.unwrapped.np_random.random()


class BoatDriver(Driver):
    """Calls of a PettingZoo environment."""

    def spaces(self, env: Any) -> list[Any]:
        return [env.action_space(agent) for agent in env.possible_agents]

    def action(self, env: Any, seed: int) -> Any:
        rng = np.random.default_rng(seed)
        return {agent: rng.uniform(-1.0, 1.0, 2) for agent in env.possible_agents}

    def drawn(self, env: Any) -> Any:
        drawn = [space.sample() for space in self.spaces(env)]
        return drawn, list(env.agents), env.unwrapped.np_random.random()


class RowDriver(Driver):
    """Calls of a stable-baselines3 environment."""

    def action(self, env: Any, seed: int) -> Any:
        return np.random.default_rng(seed).uniform(-1.0, 1.0, (env.num_envs, 2))

    def reset(self, env: Any, seed: int | None, options: Any) -> Any:
        if seed is not None:
            env.seed(seed)
        env.set_options(options)
        return env.reset()

    def step(self, env: Any, seed: int) -> Any:
        env.step_async(self.action(env, seed))
        return self.wait(env)

    def wait(self, env: Any) -> Any:
        *step, infos = env.step_wait()
        for info in infos:
            info.get("episode", {}).pop("t", None)  # a time of the wall clock
        return *step, infos

    def drawn(self, env: Any) -> Any:
        return [space.sample() for space in self.spaces(env)]


def boats(**options: Any) -> Any:
    return BoatVecEnv("push", num_envs=2, stagger=True, with_state=True, **options)


def vector(mode: str) -> Callable[..., Any]:
    def make(**options: Any) -> Any:
        return gymnasium.make_vec("asv_env/Push-v0", num_envs=2, autoreset_mode=mode, **options)

    return make


def wrapped_boats(**options: Any) -> Any:
    return BaseParallelWrapper(asv_env.parallel_env("transport", **options))


def joint(**options: Any) -> Any:
    return gymnasium.make("asv_env/Transport-v0", flat=True, **options)


DRIVERS = {
    "joint": Driver(joint, single=True),
    "parallel": BoatDriver(wrapped_boats, single=True),
    "vector, next step": Driver(vector("NextStep")),
    "vector, same step": Driver(vector("SameStep")),
    "vector, no autoreset": Driver(vector("Disabled"), single=True),
    "boats": RowDriver(boats),
}
drivers = pytest.mark.parametrize("driver", DRIVERS.values(), ids=DRIVERS.keys())
ways = pytest.mark.parametrize("way", [copied, pickled])


def outcome(call: Callable[..., Any], *arguments: Any) -> Any:
    """What a call returns or raises."""
    try:
        return call(*arguments)
    except Exception as error:
        return type(error).__name__, str(error)


class Calls(RuleBasedStateMachine):
    """An environment that is replaced by copies of itself, and its twin that never is."""

    driver: Driver
    env: Any = None

    @initialize()
    def make(self) -> None:
        self.env, self.twin = (self.driver.make(**SHORT) for _ in range(2))
        self.seeded = self.closed = False
        self.seed_spaces(0)

    def both(self, call: Callable[..., Any], *arguments: Any) -> Any:
        one, other = (outcome(call, env, *arguments) for env in (self.env, self.twin))
        assert same(one, other)

    @rule(seed=st.integers(0, 9), again=st.booleans(), options=st.sampled_from([None, GOAL]))
    def reset(self, seed: int, again: bool, options: Any) -> None:
        self.both(self.driver.reset, None if again and self.seeded else seed, options)
        self.seeded |= not self.closed

    @rule(seed=st.integers(0, 99), steps=st.integers(1, 4))
    def step(self, seed: int, steps: int) -> None:
        for number in range(steps):
            self.both(self.driver.step, seed + number)

    @rule(seed=st.integers(0, 99))
    def step_async(self, seed: int) -> None:
        if isinstance(self.driver, RowDriver):
            self.both(lambda env: env.step_async(self.driver.action(env, seed)))

    @rule()
    def step_wait(self) -> None:
        if isinstance(self.driver, RowDriver):
            self.both(self.driver.wait)

    @rule(world=st.integers(0, 1), seed=st.integers(0, 9))
    def reset_world(self, world: int, seed: int) -> None:
        if hasattr(self.env, "single_action_space") and self.seeded:
            options = {"reset_mask": np.arange(2) == world}
            self.both(self.driver.reset, [seed] * 2, options)

    @rule(seed=st.integers(0, 9))
    def seed_spaces(self, seed: int) -> None:
        for env in (self.env, self.twin):
            for space in self.driver.spaces(env):
                space.seed(seed)

    @rule()
    def draw(self) -> None:
        if self.seeded:
            self.both(self.driver.drawn)

    @rule()
    def render(self) -> None:
        # The trail of a copy begins where it was copied, so that only the kind is compared.
        self.both(lambda env: np.shape(env.render()))

    @rule(now=st.integers(0, 3))
    def close(self, now: int) -> None:
        if now == 3:
            self.both(lambda env: env.close())
            self.closed = True

    @rule(way=st.sampled_from([copied, pickled]), seed=st.integers(0, 99))
    def replace(self, way: Callable[[Any], Any], seed: int) -> None:
        original, self.env = self.env, way(self.env)
        # What happens to the original afterwards is nothing to the copy.
        for call in (self.driver.step, self.driver.reset):
            outcome(call, original, *(seed, None)[: 1 + (call == self.driver.reset)])
        for space in self.driver.spaces(original):
            space.seed(77)
        original.close()

    def teardown(self) -> None:
        if self.env is not None:
            self.env.close()
            self.twin.close()


@drivers
def test_copies_are_like_the_original_whatever_the_order_of_calls(driver: Driver) -> None:
    machine = type("Machine", (Calls,), {"driver": driver})
    run_state_machine_as_test(machine, settings=settings(max_examples=6, stateful_step_count=20))


@drivers
def test_copies_continue_to_the_bit(driver: Driver) -> None:
    env = driver.make(**HARSH, time_limit=13.0)
    driver.reset(env, 5, None)
    for seed in range(40):
        driver.step(env, seed)
    twins = copied(env), pickled(env)
    for seed in range(250):
        expected = outcome(driver.step, env, seed)
        assert all(same(outcome(driver.step, twin, seed), expected) for twin in twins), seed
        if seed % 125 == 124:
            expected = driver.reset(env, None, None)
            assert all(same(driver.reset(twin, None, None), expected) for twin in twins)


@drivers
@ways
def test_a_copy_of_a_window_has_none(driver: Driver, way: Callable[[Any], Any]) -> None:
    import pygame

    env = driver.make(**{**SHORT, "render_mode": "human"})
    driver.reset(env, 0, None)
    twin = way(env)
    assert twin.unwrapped.render_mode is None if hasattr(twin, "unwrapped") else True
    driver.step(twin, 0)
    twin.close()
    assert pygame.display.get_init(), "the original's window is still open"
    env.close()
    assert os.environ["SDL_VIDEODRIVER"] == "dummy"
