"""What adapters hand out is the user's to write to; what the user passes in stays the user's."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from helpers import same
from test_copies import DRIVERS, BoatDriver, Driver, RowDriver

import asv_env
from asv_env.envs.sb3 import BoatVecEnv

OPTIONS: dict[str, Any] = {"num_boats": 3, "time_limit": 0.4, "scenario": "harsh"}
drivers = pytest.mark.parametrize("driver", DRIVERS.values(), ids=DRIVERS.keys())


def scribble(value: Any) -> None:
    """Writes over everything in what was handed out."""
    if isinstance(value, dict | list | tuple):
        for one in value.values() if isinstance(value, dict) else value:
            scribble(one)
    if isinstance(value, np.ndarray):
        if value.dtype == object:
            scribble(list(value))
        value[...] = None if value.dtype == object else 99
    elif isinstance(value, dict | list):
        value.clear()


def history(driver: Driver, spoil: Callable[[Any], object]) -> list[Any]:
    """Copies of what an environment returns, which is then spoiled as what it was given is."""
    env, kept = driver.make(**OPTIONS), []
    for number in range(12):
        if number == 0 or (number % 4 == 0 and driver.single):
            returned = driver.reset(env, None if number else 1, None)
        else:
            action = driver.action(env, number)
            if isinstance(driver, RowDriver):
                env.step_async(action)
                spoil(action)
                returned = driver.wait(env)
            else:
                returned = env.step(action)
                spoil(action)
        kept.append(copy.deepcopy(returned))
        spoil(returned)
    return kept


@drivers
def test_writing_to_what_is_returned_or_was_passed_changes_nothing(driver: Driver) -> None:
    assert same(history(driver, scribble), history(driver, lambda value: None))


@pytest.mark.filterwarnings("ignore:.*not within the observation space")
@drivers
def test_writing_to_spaces_and_metadata_changes_no_other_environment(driver: Driver) -> None:
    first, other = driver.make(**OPTIONS), driver.make(**OPTIONS)
    expected = copy.deepcopy((driver.spaces(other), other.metadata, other.unwrapped.params))
    for space in driver.spaces(first):
        for part in getattr(space, "spaces", {"": space}).values():
            scribble([part.low, part.high])
    for agent in getattr(first, "possible_agents", []):
        scribble([first.observation_space(agent).high, first.state_space.high])
    scribble([first.metadata["render_modes"]])
    for env in (other, driver.make(**OPTIONS)):
        assert (driver.spaces(env), env.metadata, env.unwrapped.params) == expected
    driver.reset(other, 0, None)
    assert same(driver.step(other, 0), driver.step(seeded(driver), 0))
    driver.reset(first, 0, None)
    assert driver.step(first, 0), "the environment itself is none the worse"


def seeded(driver: Driver) -> Any:
    env = driver.make(**OPTIONS)
    driver.reset(env, 0, None)
    return env


def swap(env: Any) -> None:
    for names in (env.agents, env.possible_agents):
        names.reverse()


def empty(env: Any) -> None:
    for names in (env.agents, env.possible_agents, env.action_spaces, env.observation_spaces):
        names.clear()


def exchange(env: Any) -> None:
    spaces = env.action_spaces
    spaces["asv_0"], spaces["asv_1"] = spaces["asv_1"], spaces["asv_0"]
    env.agents = ["asv_1", "asv_0", "guest"]


@pytest.mark.parametrize("change", [swap, empty, exchange])
def test_names_mean_boats_whatever_is_written_to_the_lists(change: Any) -> None:
    driver = BoatDriver(lambda **options: asv_env.parallel_env("push", **options))
    env, other = seeded(driver), seeded(driver)
    space = env.action_space("asv_0")
    actions = {f"asv_{boat}": np.array([0.3 * boat, 0.1]) for boat in range(3)}
    for _ in range(2):
        change(env)
        assert same(env.step(actions), other.step(actions))
        assert env.action_space("asv_0") is space
        with pytest.raises(ValueError, match=r"missing agents \['asv_2'\]"):
            env.step({name: actions[name] for name in ("asv_0", "asv_1")})
        assert same(driver.reset(env, None, None), driver.reset(other, None, None))
        assert env.agents == ["asv_0", "asv_1", "asv_2"]


def test_seeds_goals_and_options_stay_the_users() -> None:
    seeds, goal = [3, 4], [0.4, 0.1, 0.0]
    options = {"goal": goal, "reset_mask": np.array([True, True])}
    env = asv_env.AsvVectorEnv(2, "push", **OPTIONS)
    env.reset(seed=seeds, options=options)
    assert (seeds, goal, list(options)) == ([3, 4], [0.4, 0.1, 0.0], ["goal", "reset_mask"])
    goal[0], options["reset_mask"][0] = 0.9, False
    assert env.simulation.state.goal[:, 0].tolist() == [0.4, 0.4]

    goal = [0.4, 0.1, 0.0]
    boats = BoatVecEnv("push", num_envs=2, goal=goal, **OPTIONS)
    boats.set_options({"goal": goal})
    goal[0] = 0.9
    boats.reset()
    boats.reset()
    assert boats.simulation.state.goal[:, 0].tolist() == [0.4, 0.4]


def test_agents_share_no_info() -> None:
    env = asv_env.parallel_env("push", **OPTIONS)
    for infos in (env.reset(seed=0)[1], env.step(dict.fromkeys(env.agents, np.zeros(2)))[4]):
        expected = copy.deepcopy(infos["asv_1"])
        infos["asv_0"].clear()
        assert infos["asv_1"] == expected


def test_a_reset_of_some_worlds_shows_the_others_as_they_were() -> None:
    env = asv_env.AsvVectorEnv(2, "push", autoreset_mode="Disabled", **OPTIONS)
    options = {"reset_mask": np.array([True, False])}
    returned = env.reset(seed=0)[0], env.step(np.ones((2, 3, 2)))[0]
    for observation in returned:
        observation[...] = 99.0
    again, _ = env.reset(options=options)
    assert (again[1] < 99.0).all()
    twin = asv_env.AsvVectorEnv(2, "push", autoreset_mode="Disabled", **OPTIONS)
    first, _ = twin.reset(seed=0)
    expected = first.copy()
    first[...] = 99.0
    assert np.array_equal(twin.reset(options=options)[0][1], expected[1])
