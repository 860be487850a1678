"""Adapters refuse bad options, calls out of order, bad actions, seeds and goals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

import asv_env
from asv_env.envs.sb3 import BoatVecEnv

IDLE = np.array([0.0, 0.0])

MAKERS: dict[str, Callable[..., Any]] = {
    "joint": asv_env.JointEnv,
    "parallel": asv_env.parallel_env,
    "vector": lambda *args, **options: asv_env.AsvVectorEnv(2, *args, **options),
    "boats": lambda *args, **options: BoatVecEnv(*args, **{"num_envs": 2, **options}),
}
makers = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS.keys())


def step(env: Any, action: Any) -> Any:
    """A step with the same action (2,) for every boat, in the shape that the adapter takes."""
    if isinstance(env, asv_env.AsvParallelEnv):
        return env.step(dict.fromkeys(env.possible_agents, action))
    if isinstance(env, BoatVecEnv):
        return env.step(np.array([action] * env.num_envs))
    if isinstance(env, asv_env.AsvVectorEnv):
        return env.step(np.array([[action] * 4] * env.num_envs))
    return env.step(np.array([action] * 4))


def reset(env: Any, **arguments: Any) -> Any:
    """A reset, through ``_seeds`` and ``set_options`` where it takes no arguments."""
    if not isinstance(env, BoatVecEnv):
        return env.reset(**arguments)
    if "seed" in arguments:
        env._seeds = [arguments["seed"]] * env.num_envs
    env.set_options(arguments.get("options"))
    return env.reset()


@makers
@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"task": "puhs"}, r"task 'puhs'.*'push'"),
        ({"scenario": "nosy"}, r"scenario 'nosy'.*'noisy'"),
        ({"preset": "tnak"}, r"preset 'tnak'.*'tank'"),
        ({"action_mode": "thruster"}, r"'thruster'.*'thrusters'"),
        ({"render_mode": "rgb"}, r"render_mode 'rgb'.*'rgb_array'"),
        ({"time_limt": 3.0}, r"argument 'time_limt'.*'time_limit'"),
        ({"boat": {"lenght": 0.1}}, r"'lenght'.*'length'"),
        ({"num_boats": 1}, r"num_boats = 1\b.*from 2 to 100"),
        ({"num_boats": 2.5}, r"num_boats = 2\.5"),
        ({"num_boats": 20, "vessel": {"length": 0.4}}, r"20 boats.*0\.4 m"),
        ({"goal": (9.0, 0.0, 0.0)}, r"9\.0.*outside the arena"),
        ({"goal": (np.nan, 0.0, 0.0)}, "finite"),
        ({"time_limit": -1.0}, r"-1\.0"),
        ({"boat": 3}, "mapping"),
    ],
)
def test_bad_options_are_named(make: Any, options: dict[str, Any], named: str) -> None:
    with pytest.raises((ValueError, TypeError), match=f"(?s){named}"):
        make(**options)


@pytest.mark.parametrize("num_envs", [0, -1, 1.5, True])
def test_a_batch_has_at_least_one_world(num_envs: Any) -> None:
    for make in (asv_env.AsvVectorEnv, lambda n: BoatVecEnv(num_envs=n)):
        with pytest.raises((ValueError, TypeError)):
            make(num_envs)


def test_an_unknown_autoreset_mode_is_named() -> None:
    with pytest.raises(ValueError, match=r"'Samestep'.*'SameStep'"):
        asv_env.AsvVectorEnv(2, autoreset_mode="Samestep")


@makers
@pytest.mark.parametrize(
    ("action", "named"),
    [
        ([0.0, np.nan], "nan.*finite"),
        ([np.inf, 0.0], "inf.*finite"),
        ([0.0, 0.0, 0.0], "shape"),
        ([0.0], "shape"),
        (0.0, "shape"),
        (["full", "ahead"], "numbers"),
    ],
)
def test_bad_actions_are_refused(make: Any, action: Any, named: str) -> None:
    env = make("push")
    reset(env)
    with pytest.raises((ValueError, TypeError), match=named):
        step(env, action)
    assert step(env, IDLE), "the environment is none the worse"


@makers
def test_nothing_goes_before_a_reset(make: Any) -> None:
    env = make("push", render_mode="rgb_array")
    with pytest.raises(ValueError, match=r"step.*call reset first") as caught:
        step(env, IDLE)
    assert isinstance(caught.value, gymnasium.error.ResetNeeded | RuntimeError)
    with pytest.raises(ValueError, match=r"render.*call reset first"):
        env.render()


@makers
def test_nothing_goes_after_close(make: Any) -> None:
    env = make("push", render_mode="rgb_array")
    reset(env)
    env.close()
    for ask in (lambda: step(env, IDLE), lambda: reset(env), env.render):
        with pytest.raises(ValueError, match="closed; make a new one"):
            ask()
    env.close()


@pytest.mark.parametrize("make", [asv_env.JointEnv, asv_env.parallel_env])
def test_no_step_goes_beyond_the_end(make: Any) -> None:
    env = make("push", time_limit=0.1)
    for _ in range(2):
        env.reset(seed=0)
        step(env, IDLE)
        with pytest.raises(ValueError, match="episode is over; call reset first"):
            step(env, IDLE)


@makers
@pytest.mark.parametrize("seed", [-1, 1.5, "a", True])
def test_bad_seeds_are_refused(make: Any, seed: Any) -> None:
    with pytest.raises((ValueError, TypeError), match=f"seed = {seed!r}"):
        reset(make("push"), seed=seed)


@makers
@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"goal": [9.0, 0.0, 0.0]}, "outside the arena"),
        ({"goal": [0.0, 0.0]}, "three numbers, all finite"),
        ({"goal": [0.0, 0.0, np.inf]}, "finite"),
        ({"goal": "home"}, "three numbers, all finite"),
        ({"goal": {"x": 0.1}}, "three numbers, all finite"),
        ({"goal": np.zeros((1, 3))}, "three numbers, all finite"),
    ],
)
def test_bad_goals_are_refused(make: Any, options: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueError, match=named):
        reset(make("push"), options=options)


def test_a_bad_goal_for_one_world_begins_no_episode_in_another() -> None:
    env = BoatVecEnv("push", 2, 2)
    env.reset()
    env.step(np.zeros((4, 2)))
    for goal, error in (
        ([9.0, 0.0, 0.0], "outside the arena"),
        (np.zeros((2, 2)), "three numbers"),
    ):
        env.set_options([{"goal": [0.3, 0.0, 0.0]}] * 2 + [{"goal": goal}] * 2)
        with pytest.raises(ValueError, match=error):
            env.reset()
        assert env.simulation.state.tick.tolist() == [1, 1]


@makers
def test_unknown_reset_options_warn_with_the_nearest(make: Any) -> None:
    with pytest.warns(UserWarning, match="'gaol' is unknown and ignored. Did you mean 'goal'"):
        reset(make("push"), options={"gaol": [0.0, 0.0, 0.0]})


@pytest.mark.parametrize("make", [MAKERS[name] for name in ("joint", "parallel", "vector")])
def test_reset_options_have_to_be_a_mapping(make: Any) -> None:
    with pytest.raises(TypeError, match="give a mapping"):
        make("push").reset(options=[1, 2])


def test_a_list_of_seeds_has_one_for_each_world() -> None:
    env = asv_env.AsvVectorEnv(3, "push")
    with pytest.raises(ValueError, match="2 seeds for 3 worlds"):
        env.reset(seed=[1, 2])
    assert np.array_equal(env.reset(seed=np.array(3))[0], env.reset(seed=3)[0])
    with pytest.raises(ValueError, match="reset_mask"):
        env.reset(options={"reset_mask": np.zeros(3, dtype=bool)})


@pytest.mark.parametrize(
    ("actions", "error", "named"),
    [
        ({"asv_0": IDLE}, ValueError, r"missing agents \['asv_1'\]"),
        ({"asv_0": IDLE, "asv_1": IDLE, "asv1": IDLE}, ValueError, r"\['asv1'\].*mean 'asv_1'"),
        ({}, ValueError, r"missing agents \['asv_0', 'asv_1'\]"),
        ({"asv_0": IDLE, "asv_1": [0.0]}, ValueError, r"action of asv_1 of shape \(1,\)"),
        (np.zeros((2, 2)), TypeError, "dict by agent"),
    ],
)
def test_the_actions_name_every_agent(actions: Any, error: type[Exception], named: str) -> None:
    env = asv_env.parallel_env("push", 2)
    env.reset()
    with pytest.raises(error, match=named):
        env.step(actions)
    for spaces in (env.action_space, env.observation_space):
        with pytest.raises(ValueError, match=r"'asv_7'.*'asv_0' to 'asv_1'"):
            spaces("asv_7")
