"""Options that Gymnasium and PettingZoo pass everywhere, and the spec that they make again."""

from __future__ import annotations

import json
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.play import play

import asv_env
from asv_env.envs.sb3 import BoatVecEnv

PUSH = "asv_env/Push-v0"
FAR: dict[str, Any] = {"goal": (1.0, 0.0, 0.0), "num_boats": 2}
MAKERS: dict[str, Any] = {
    "make": lambda **options: gymnasium.make(PUSH, **options),
    "joint": lambda **options: asv_env.JointEnv("push", **options),
    "make_vec": lambda **options: gymnasium.make_vec(PUSH, num_envs=2, **options),
    "sync": lambda **options: gymnasium.make_vec(
        PUSH, num_envs=2, vectorization_mode="sync", **options
    ),
    "parallel": lambda **options: asv_env.parallel_env("push", **options),
    "boats": lambda **options: BoatVecEnv("push", num_envs=2, **options),
}
makers = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS.keys())


def first_end(env: Any) -> tuple[int, dict[str, Any]]:
    """Number of steps of an episode that is truncated, and the last info of its first world."""
    env.reset()
    for step in range(1, 2000):
        if isinstance(env, asv_env.AsvParallelEnv):
            _, _, _, truncated, infos = env.step(dict.fromkeys(env.agents, np.zeros(2)))
            truncated, info = truncated["asv_0"], infos["asv_0"]
        elif isinstance(env, BoatVecEnv):
            _, _, truncated, infos = env.step(np.zeros((env.num_envs, 2)))
            truncated, info = truncated[0], infos[0]
        else:
            _, _, _, truncated, infos = env.step(np.zeros(env.action_space.shape, np.float32))
            truncated = np.ravel(truncated)[0]
            info = {name: np.ravel(value)[0] for name, value in infos.items()}
        if truncated:
            return step, info
    raise AssertionError("no end")


@makers
@pytest.mark.parametrize("steps", [1, 7, 1250])  # the default is 1200
def test_max_episode_steps_is_the_length_of_an_episode(make: Any, steps: int) -> None:
    env = make(max_episode_steps=steps, **FAR)
    assert first_end(env)[0] == steps
    assert first_end(env)[1]["position_error"] == pytest.approx(1.0, abs=0.1)


@makers
@pytest.mark.parametrize("steps", [None, -1, 1200])
def test_none_leaves_the_time_limit_as_it_is(make: Any, steps: Any) -> None:
    env = make(max_episode_steps=steps)
    params = env.get_attr("params")[0] if hasattr(env, "get_attr") else env.unwrapped.params
    assert params.time_limit_ticks == 1200


@makers
@pytest.mark.parametrize("steps", [0, -2, 1.5, True, "seven", 10**400])
def test_what_is_no_number_of_steps_is_refused(make: Any, steps: Any) -> None:
    with pytest.raises(ValueError, match=r"max_episode_steps = .*whole number"):
        make(max_episode_steps=steps)


@makers
@pytest.mark.parametrize(
    "limit", [{"time_limit": 30.0}, {"task_params": {"time_limit": 30.0}}, {"time_limit": 0.65}]
)
def test_two_different_limits_are_refused(make: Any, limit: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"max_episode_steps = 7 and time_limit = .*one of"):
        make(max_episode_steps=7, **limit)
    assert make(max_episode_steps=7, time_limit=0.7), "but two that agree are not"


def test_max_cycles_is_pettingzoos_name_of_it() -> None:
    assert first_end(asv_env.parallel_env("push", max_cycles=5))[0] == 5
    assert first_end(asv_env.parallel_env("push", max_cycles=5, max_episode_steps=5))[0] == 5
    with pytest.raises(ValueError, match="max_cycles = 5 and max_episode_steps = 6"):
        asv_env.parallel_env("push", max_cycles=5, max_episode_steps=6)
    with pytest.raises(ValueError, match="max_cycles = 5 and time_limit = 3 s"):
        asv_env.parallel_env("push", max_cycles=5, time_limit=3.0)
    with pytest.raises(ValueError, match="max_cycles = 0"):
        asv_env.parallel_env("push", max_cycles=0)


SPECIAL: list[dict[str, Any]] = [
    {},
    {"max_episode_steps": 9},
    {"max_episode_steps": 5000},
    {"time_limit": 30.0},
    {"goal": np.array([0.4, 0.0, 0.1]), "num_boats": np.int64(3), "flat": True},
    {"vessel": {"length": np.float32(0.5)}, "observation": ("ahead_speed",), "render_mode": None},
    {"boat": asv_env.make_params().boat, "reward": {"time": np.float64(0.1)}},
]
SPECIAL[5]["observation"] = tuple(asv_env.FEATURES)[:2]


@pytest.mark.parametrize("options", SPECIAL)
def test_a_spec_makes_the_same_environment_again(options: dict[str, Any]) -> None:
    for make in (gymnasium.make, gymnasium.make_vec):
        env = make(PUSH, **options)
        steps = env.unwrapped.params.time_limit_ticks
        assert env.spec.max_episode_steps == steps
        text = env.spec.to_json()
        assert json.loads(text)["max_episode_steps"] == steps
        for spec in (env.spec, EnvSpec.from_json(text)):
            again = make(spec)
            assert again.unwrapped.params == env.unwrapped.params
            assert again.spec.max_episode_steps == steps
            assert again.observation_space == env.observation_space
        assert make(env.spec).spec == env.spec


def test_a_spec_is_not_the_users_goal() -> None:
    goal = [0.4, 0.0, 0.0]
    env = gymnasium.make(PUSH, goal=goal)
    goal[0] = 9.0
    assert gymnasium.make(env.spec).unwrapped.params.task.goal == (0.4, 0.0, 0.0)


def test_options_of_make_vec_work_in_every_mode() -> None:
    for mode in ("sync", "vector_entry_point"):
        env = gymnasium.make_vec(
            PUSH, num_envs=2, vectorization_mode=mode, disable_env_checker=True, render_mode=None
        )
        env.reset(seed=0)
        env.step(env.action_space.sample())
        env.close()
    env = gymnasium.make_vec(
        PUSH,
        num_envs=2,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": "SameStep"},
        wrappers=[gymnasium.wrappers.TimeAwareObservation, gymnasium.wrappers.FlattenObservation],
        max_episode_steps=3,
    )
    first, _ = env.reset(seed=0)
    assert first.shape[1] == np.prod(asv_env.JointEnv("push").observation_space.shape) + 1
    truncated = [env.step(env.action_space.sample())[3].all() for _ in range(3)]
    assert truncated == [False, False, True]


# ------------------------------------------------------------------ flat spaces


def test_flat_spaces_hold_the_same_in_one_axis() -> None:
    flat, plain = (asv_env.JointEnv("push", 3, "harsh", flat=one) for one in (True, False))
    assert flat.action_space.shape == (6,)
    assert np.array_equal(flat.observation_space.high, plain.observation_space.high.reshape(-1))
    action = np.linspace(-1.0, 1.0, 6, dtype=np.float32)
    for one, other in (
        (flat.reset(seed=1)[0], plain.reset(seed=1)[0]),
        (flat.step(action)[0], plain.step(action.reshape(3, 2))[0]),
    ):
        assert one in flat.observation_space
        assert one.tobytes() == other.tobytes()
    with pytest.raises(ValueError, match=r"shape \(3, 2\): must be \(6,\)"):
        flat.step(action.reshape(3, 2))


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_flat_vector_environments_too(mode: str) -> None:
    options = {"num_boats": 2, "time_limit": 0.3, "autoreset_mode": mode}
    flat, plain = (asv_env.AsvVectorEnv(3, "push", flat=one, **options) for one in (True, False))
    assert np.array_equal(flat.reset(seed=0)[0], plain.reset(seed=0)[0].reshape(3, -1))
    for step in range(8):
        action = np.full((3, 4), 0.1 * step, dtype=np.float32)
        one, other = flat.step(action), plain.step(action.reshape(3, 2, 2))
        assert one[0] in flat.observation_space
        assert np.array_equal(one[0], other[0].reshape(3, -1))
        if "final_obs" in one[4]:
            assert np.array_equal(one[4]["final_obs"][1], other[4]["final_obs"][1].reshape(-1))


# ------------------------------------------------------------------ keys


@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize("mode", ["tracking", "thrusters", "discrete"])
def test_keys_steer_all_boats(flat: bool, mode: str) -> None:
    env = asv_env.JointEnv("transport", 2, flat=flat, action_mode=mode)
    actions = env.get_keys_to_action()
    assert all(action in env.action_space for action in actions.values())
    env.reset(seed=0)
    start = env.simulation.state.motion[0, 1:]
    for keys in (("w",), ("a",)):
        env.reset(seed=0)
        for _ in range(10):
            env.step(actions[keys])
        motion = env.simulation.state.motion[0, 1:]
        heading = start[:, 2]
        ahead = ((motion - start)[:, :2] * np.stack([np.cos(heading), np.sin(heading)], -1)).sum(-1)
        assert (ahead > 0.02).all() if keys == ("w",) else (motion[:, 5] > 0.1).all()


def test_play_needs_no_mapping(monkeypatch: pytest.MonkeyPatch) -> None:
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    sent: list[Any] = []

    def watch(before: Any, after: Any, action: Any, *rest: Any) -> None:
        sent.append(action)
        if len(sent) == 2:
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_w))
        if len(sent) == 4:
            pygame.event.post(pygame.event.Event(pygame.QUIT))

    env = gymnasium.make(PUSH, num_boats=2, render_mode="rgb_array")
    play(env, callback=watch, fps=1000)
    assert np.array_equal(sent[-1], [[1.0, 0.0], [1.0, 0.0]])
    assert env.render().std() > 0, "although play has quit pygame"


# ------------------------------------------------------------------ attributes by row


def test_attributes_of_a_vector_environment_are_those_of_a_sync_vector_env() -> None:
    ours, theirs = MAKERS["make_vec"](num_boats=3), MAKERS["sync"](num_boats=3)
    for env in (ours, theirs):
        env.reset(seed=0)
        env.set_attr("label", [1, 2])
        env.set_attr("remark", "x")
        env.set_attr("times", [lambda number: number, lambda number: 2 * number])
        assert env.call("times", 3) == (3, 6)
    for name in ("label", "remark", "render_mode", "observation_space", "action_space"):
        assert ours.get_attr(name) == theirs.get_attr(name)
    with pytest.warns(UserWarning, match="render"):
        assert ours.call("render") == theirs.call("render") == (None, None)
    for env in (ours, theirs):
        with pytest.raises(ValueError, match=r"values for 2|equal to the number"):
            env.set_attr("label", [1, 2, 3])
        with pytest.raises(AttributeError, match="nonsense"):
            env.get_attr("nonsense")
    with pytest.raises(ValueError, match="all rows share it"):
        ours.set_attr("render_mode", [None, "human"])
    for name in ("reset", "step", "close"):
        with pytest.raises(ValueError, match=f"use env.{name}"):
            ours.call(name)


def test_rows_of_boats_have_attributes_of_their_own() -> None:
    env = BoatVecEnv("push", num_envs=2, num_boats=2)
    env.set_attr("label", "x", indices=[0, -1])
    assert env.get_attr("label", indices=[3, 0]) == ["x", "x"]
    assert not env.has_attr("label")
    with pytest.raises(AttributeError, match=r"rows \[1, 2\] have no attribute 'label'"):
        env.get_attr("label")
    with pytest.raises(ValueError, match="all rows share it"):
        env.set_attr("render_mode", "human", indices=0)
    for wrong in (4, -5, [0, 9]):
        with pytest.raises(IndexError, match="there are 4, from 0 to 3"):
            env.get_attr("params", indices=wrong)
        with pytest.raises(IndexError):
            env.env_method("has_attr", "params", indices=wrong)


@pytest.mark.parametrize("num_envs", [0, -1, 1.5, True, "3", None])
def test_the_number_of_worlds_is_reported_as_it_was_given(num_envs: Any) -> None:
    for make in (asv_env.AsvVectorEnv, lambda number: BoatVecEnv("push", num_envs=number)):
        with pytest.raises(ValueError, match=r"^num_envs = .*whole number of at least 1"):
            make(num_envs)
    assert asv_env.AsvVectorEnv(np.int64(2)).num_envs == 2
