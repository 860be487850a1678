"""TorchRLEnv keeps TorchRL's contracts and agrees with the other adapters."""

import copy
import os
import pickle
import warnings

import numpy as np
import pytest
import torch

if "ENGINES_MUST_RUN" not in os.environ:
    pytest.importorskip("torchrl", reason="TorchRL is not installed, see docs/engines.md")

from torchrl.envs import PettingZooWrapper
from torchrl.envs.utils import check_env_specs

import asv_env
from asv_env.envs.common import ClosedError, ResetNeededError
from asv_env.envs.infos import metrics_of, reward_terms
from asv_env.params import DISCRETE_ACTIONS

OBSERVATION, ACTION, REWARD = (("asv", name) for name in ("observation", "action", "reward"))


@pytest.fixture(scope="module", autouse=True)
def _one_thread():
    torch.set_num_threads(1)


def actions(env, steps, seed=0):
    """Random actions, one tensor for each step."""
    generator = torch.Generator().manual_seed(seed)
    shape = env.full_action_spec[env.action_key].shape
    return [2 * torch.rand(shape, generator=generator) - 1 for _ in range(steps)]


def stepped(env, given, tensors=None):
    """Tensors of each step under given actions, worlds that end beginning their next episode."""
    tensors = env.reset() if tensors is None else tensors
    found = []
    for action in given:
        step, tensors = env.step_and_maybe_reset(tensors.set(env.action_key, action))
        found.append(step)
    return torch.stack(found)


def equal(one, other):
    """Whether all tensors of two TensorDicts are the same to the bit."""
    assert set(one.keys(True, True)) == set(other.keys(True, True))
    return all(one[name].equal(other[name]) for name in one.keys(True, True))


@pytest.mark.parametrize("task", asv_env.TASKS)
@pytest.mark.parametrize(
    "options", [{}, {"info": (), "with_state": False}, {"scenario": "harsh", "time_limit": 0.2}]
)
def test_the_specs_are_those_of_the_tensors(task, options):
    check_env_specs(asv_env.TorchRLEnv(task, 3, 2, **options), seed=10**8)


@pytest.mark.parametrize(("task", "scenario"), [("transport", "harsh"), ("push", "nominal")])
def test_it_is_a_batch_of_wrapped_parallel_environments_to_the_bit(task, scenario):
    """Through ends of episodes, each world beginning its next one by itself."""
    options = {"num_boats": 3, "scenario": scenario, "time_limit": 0.5}
    probe = asv_env.Simulation(asv_env.make_params(task))
    names = (*reward_terms(probe), *metrics_of(probe))
    env = asv_env.TorchRLEnv(task, 2, seed=7, info=names, **options)
    given = actions(env, 13)
    ours = stepped(env, given)
    for world in range(2):
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="PettingZoo in TorchRL")
            single = PettingZooWrapper(asv_env.parallel_env(task, **options), return_state=True)
        begun = single.reset(seed=7 + world)
        theirs = stepped(single, [action[world] for action in given], begun)
        assert equal(ours[:, world], theirs)
        assert theirs["next", "truncated"].sum() == 2
        assert single.group_map == env.group_map
        assert single.action_spec[ACTION] == env.action_spec[ACTION][world]


@pytest.mark.parametrize("flat", [False, True])
def test_discrete_actions_are_numbers_of_tracking_actions(flat):
    options = {"seed": 3, "scenario": "harsh", "flat": flat}
    discrete = asv_env.TorchRLEnv("push", 2, 3, action_mode="discrete", **options)
    check_env_specs(discrete)
    tracking = asv_env.TorchRLEnv("push", 2, 3, **options)
    numbers = torch.tensor([[[0, 1, 2], [3, 4, 5]], [[6, 7, 8], [9, 10, 11]]])
    commands = torch.tensor(DISCRETE_ACTIONS)[numbers].reshape(
        2, *tracking.full_action_spec[tracking.action_key].shape
    )
    for env in (discrete, tracking):
        env.set_seed(3)
    key = discrete.action_key
    one, other = stepped(discrete, numbers).exclude(key), stepped(tracking, commands).exclude(key)
    assert equal(one, other)
    with pytest.raises(ValueError, match=r"action 12 of boat 0 in world 0.*from 0 to 11"):
        discrete.step(discrete.reset().set(key, numbers[0] + 12))


def test_flat_is_the_flat_vector_env_to_the_bit():
    env = asv_env.TorchRLEnv("push", 3, 2, flat=True, scenario="noisy", seed=3)
    check_env_specs(env)
    vector = asv_env.AsvVectorEnv(3, "push", 2, scenario="noisy", flat=True)
    env.set_seed(3)
    vector.reset(seed=3)
    given = actions(env, 3)
    for step, action in zip(stepped(env, given)["next"], given, strict=True):
        seen, reward, _, _, infos = vector.step(action.numpy())
        assert step["observation"].numpy().tobytes() == seen.tobytes()
        assert step["reward"][:, 0].numpy().tobytes() == reward.astype(np.float32).tobytes()
        error = step["info", "position_error"].numpy()
        assert error.tobytes() == infos["position_error"].astype(np.float32).tobytes()
    with pytest.raises(ValueError, match=r"shape \(3, 2, 2\): must be \(3, 4\)"):
        env.step(env.reset().set("action", torch.zeros(3, 2, 2)))


def test_it_is_the_vector_env_to_the_bit():
    env = asv_env.TorchRLEnv("push", 3, 2, scenario="noisy", seed=3)
    vector = asv_env.AsvVectorEnv(3, "push", 2, scenario="noisy")
    seen, _ = vector.reset(seed=3)
    given = actions(env, 4)
    steps = stepped(env, given)
    assert steps[OBSERVATION][0].numpy().tobytes() == seen.tobytes()
    for step, action in zip(steps["next"], given, strict=True):
        seen, reward, _, _, infos = vector.step(action.numpy())
        assert step[OBSERVATION].numpy().tobytes() == seen.tobytes()
        assert step[REWARD].mean((1, 2)).numpy() == pytest.approx(reward, rel=1e-6)
        error = step["asv", "info", "position_error"]
        assert error.numpy() == pytest.approx(np.repeat(infos["position_error"][:, None], 2, 1))


def test_some_worlds_are_reset_and_the_others_stay():
    env = asv_env.TorchRLEnv("push", 3, 2)
    env.set_seed(5)
    first = env.reset()
    last = stepped(env, actions(env, 3), first.clone())[-1]["next"]
    env.set_seed(5)
    mask = torch.tensor([[False], [True], [False]])
    again = env.reset(last.clone().set("_reset", mask))
    assert again[OBSERVATION][1].equal(first[OBSERVATION][1])
    for world in (0, 2):
        assert again["state"][world].equal(last["state"][world])
    assert env.simulation.state.tick.tolist() == [3, 0, 3]
    assert env.reset()[OBSERVATION][0].equal(first[OBSERVATION][0]), "its seed waited for it"


def test_time_limits_truncate_and_deliveries_terminate():
    env = asv_env.TorchRLEnv("push", 2, 2, seed=0, goal=(0, 0, 0), delivery_time=0.3)
    steps = env.rollout(50, policy=lambda td: td.set(ACTION, torch.zeros(2, 2, 2)))["next"]
    assert steps.shape[1] == 3
    assert steps["terminated"][:, -1].all()
    assert not steps["truncated"].any()
    assert steps["asv", "info", "is_success"][:, -1].eq(1).all()
    env = asv_env.TorchRLEnv("push", 2, 2, seed=0, max_episode_steps=4)
    steps = env.rollout(50)["next"]
    assert steps.shape[1] == 4
    assert steps["asv", "truncated"][:, -1].all()
    assert not steps["terminated"].any()


def test_a_world_whose_episode_is_over_waits_for_the_others():
    """As ``rollout`` asks for when it runs until every world is done."""
    env = asv_env.TorchRLEnv("push", 2, 2, seed=0, max_episode_steps=6)
    tensors = stepped(env, actions(env, 2))[-1]["next"]
    env.reset(tensors.set("_reset", torch.tensor([[False], [True]])))
    over = []
    tensors = tensors.exclude("_reset", REWARD)
    for action in actions(env, 6):
        moving = ~torch.tensor([[any(row)] for row in zip(*over, strict=True)] or [[False]] * 2)
        step = env.step(tensors.set(ACTION, action).set("_step", moving))
        over.append(step["next", "done"].flatten().tolist())
    assert over == [[False, False]] * 3 + [[True, False]] * 2 + [[True, True]]
    whole = env.rollout(20, break_when_any_done=False, break_when_all_done=True)
    assert whole.shape == (2, 6)


def test_collectors_gather_whole_episodes():
    from torchrl.collectors import Collector

    env = asv_env.TorchRLEnv("push", 4, 2, seed=1, max_episode_steps=5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        collector = Collector(env, frames_per_batch=40, total_frames=80)
        first, second = (batch.clone() for batch in collector)
    assert first.shape == (4, 10)
    assert first["next", "done"].flatten(1).sum(1).tolist() == [2] * 4
    collector.shutdown()
    both = torch.cat([first, second], dim=1)
    continues = ~both["next", "done"][:, :-1, 0]
    for name in (OBSERVATION, "state"):
        after, seen = both["next"].get(name)[:, :-1], both.get(name)[:, 1:]
        assert after[continues].equal(seen[continues])
        assert not after[~continues].equal(seen[~continues]), "the next episode has begun"
    other = asv_env.TorchRLEnv("push", 4, 2, seed=1, max_episode_steps=5)
    again = stepped(other, both[ACTION].unbind(1))
    assert again["next", *REWARD].equal(both["next", *REWARD].transpose(0, 1))


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_continues_to_the_bit(copied):
    env = asv_env.TorchRLEnv("transport", 2, 3, scenario="harsh", seed=2, time_limit=0.6)
    last = stepped(env, actions(env, 3))[-1]["next"]
    other, given = copied(env), actions(env, 6, seed=1)
    start = last.exclude(REWARD)
    assert equal(stepped(env, given, start.clone()), stepped(other, given, start.clone()))


def test_tensors_are_the_callers_to_write_to():
    env, other = (asv_env.TorchRLEnv("push", 2, 2, seed=0, max_episode_steps=2) for _ in range(2))
    written, kept = env.reset(), other.reset()
    for action in actions(env, 2):
        for name in written.keys(True, True):
            written[name].fill_(1)
        written = env.step(written.set(ACTION, action))["next"]
        kept = other.step(kept.set(ACTION, action))["next"]
        assert equal(written, kept)
    written["done"].fill_(False)
    with pytest.raises(ResetNeededError, match=r"worlds \[0, 1\] are over"):
        env.step(written.set(ACTION, action))


def test_goals_are_options_of_a_reset():
    env = asv_env.TorchRLEnv("push", 2, 2, device=None)
    assert env.device == torch.device("cpu")
    env.reset(options={"goal": [0.1, 0.2, 0.3]})
    assert env.simulation.state.goal.tolist() == [[0.1, 0.2, 0.3]] * 2


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"task": "puhs"}, r"task 'puhs'.*'push'"),
        ({"num_envs": 0}, "num_envs = 0"),
        ({"seed": -1}, "seed = -1"),
        ({"info": ["is_sucess"]}, r"info 'is_sucess'.*'is_success'"),
        ({"time_limt": 3.0}, r"'time_limt'.*'time_limit'"),
        ({"render_mode": "rgb"}, r"'rgb'.*'rgb_array'"),
    ],
)
def test_bad_options_are_named(options, named):
    with pytest.raises((ValueError, TypeError), match=named):
        asv_env.TorchRLEnv(**{"num_envs": 2, **options})


def test_calls_out_of_order_are_refused():
    env = asv_env.TorchRLEnv("push", 2, 2, max_episode_steps=1)
    still = torch.zeros(2, 2, 2)
    tensors = env.reset()
    with pytest.raises(ValueError, match=r"nan.*finite"):
        env.step(tensors.clone().set(ACTION, still / 0))
    one_stays = tensors.clone().set(ACTION, still).set("_step", torch.tensor([[True], [False]]))
    with pytest.raises(ValueError, match=r"leaves out worlds \[1\]"):
        env.step(one_stays)
    env.step(tensors.set(ACTION, still))
    with pytest.raises(ResetNeededError, match=r"worlds \[0, 1\] are over"):
        env.step(tensors)
    env.close()
    with pytest.raises(ClosedError, match="make a new one"):
        env.reset()
