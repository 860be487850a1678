"""The engine sb3: worlds, learner, buffer and curriculum of a training."""

from collections import deque

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.logger import configure
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.utils import set_random_seed
from train_helpers import tiny, train

from asv_env import Simulation, make_params
from asv_env.sensing import observation
from baselines.learned import policy_file
from train import actors
from train.run import Run
from train.sb3 import policies
from train.sb3.ppo import Learner, TorchRolloutBuffer
from train.sb3.training import Callback
from train.sb3.vec_env import ResidualVecEnv, TrainingVecEnv


def test_a_central_critic_changes_what_the_critic_sees_alone(tmp_path):
    train(tmp_path / "run", "--critic", "central", "--total-timesteps", "512")
    learner = Learner.load(tmp_path / "run/checkpoint.zip", device="cpu")
    widths = [layer.in_features for layer in actors.linear_layers(policies.actor(learner.policy))]
    state = learner.observation_space["state"].shape[0]
    assert widths[0] == len(observation.NAMES)
    assert learner.policy.mlp_extractor.value_net[0].in_features == widths[0] + state
    assert policy_file.load(tmp_path / "run/best.npz", make_params("push"))


def test_minibatches_are_those_of_the_library():
    seen, does = Box(-1, 1, (3,)), Box(-1, 1, (2,))
    kinds = (RolloutBuffer, TorchRolloutBuffer)
    made = [kind(8, seen, does, device="cpu", n_envs=5) for kind in kinds]
    for buffer in made:
        rng, begins = np.random.default_rng(0), np.zeros(5)
        while not buffer.full:
            one, two = (torch.as_tensor(rng.random(5), dtype=torch.float32) for _ in range(2))
            buffer.add(rng.random((5, 3)), rng.random((5, 2)), rng.random(5), begins, one, two)
        buffer.compute_returns_and_advantage(one, begins)
    batches = []
    for buffer in made:
        set_random_seed(0)
        batches.append(list(buffer.get(16)))
    assert len(batches[0]) == 3
    for theirs, ours in zip(*batches, strict=True):
        for name in theirs._fields:
            assert torch.equal(getattr(theirs, name), getattr(ours, name)), name


def test_the_noise_of_the_actions_is_bounded_from_below():
    config = tiny(
        network={"log_std_init": -3.0, "log_std_min": -1.0},
        ppo={"critic_updates": 0, "adapt_kl": None},
    )
    learner = Learner.create(config, TrainingVecEnv(config))
    learner.set_logger(configure(None, []))
    learner.learn(512)
    assert learner.policy.log_std.min() >= -1.0


@pytest.mark.parametrize(
    ("succeed", "progress"), [([1, 1, 1, 0, 1], 0.5), ([1, 1, 0], 0.2), ([], 0.2)]
)
def test_the_curriculum_advances_where_most_episodes_succeed(succeed, progress, tmp_path):
    config = tiny(curriculum={"step": 0.3}, out=tmp_path)
    worlds = TrainingVecEnv(config)
    learner = Learner.create(config, worlds)
    learner.set_logger(configure(None, []))
    learner.ep_success_buffer = deque(succeed)
    callback = Callback(Run(config), worlds, None, None, None)
    callback.init_callback(learner)
    callback.advance_curriculum()
    assert learner.progress == pytest.approx(progress)
    assert not learner.ep_success_buffer
    learner.save(tmp_path / "kept.zip")
    assert Learner.load(tmp_path / "kept.zip", device="cpu").progress == learner.progress
    for _ in range(9):
        learner.ep_success_buffer = deque([1])
        callback.advance_curriculum()
    assert learner.progress == 1.0


def test_worlds_are_the_same_after_the_same_restart():
    config = tiny(worlds={"teams": (4, 6), "scenarios": ("noisy", "mismatch")})
    worlds = TrainingVecEnv(config)
    action = np.full((worlds.num_envs, 2), 0.5, dtype=np.float32)
    assert worlds.num_envs == 2 * (2 * 4 + 2 * 6)

    weighted = tiny(worlds={"teams": (4, 6, 6), "num_envs": 7})
    assert weighted.worlds.groups(7) == {(4, "noisy"): 3, (6, "noisy"): 4}
    assert TrainingVecEnv(weighted).num_envs == 3 * 4 + 4 * 6

    def begun(progress, seed):
        seen = [worlds.restart(progress, seed)]
        for _ in range(5):
            seen.append(worlds.step(action)[0])
        return np.array(seen)

    first = begun(0.5, 10**9)
    assert not np.array_equal(first, begun(0.5, 10**9 + 100))
    assert np.array_equal(first, begun(0.5, 10**9))


def test_corrections_are_made_in_training_as_in_the_policy_file(tmp_path):
    residual = ["--residual", "0.3", "--decision-rate", "10", "--imitation.rounds", "0"]
    train(tmp_path / "run", *residual, "--total-timesteps", "512", "--scenarios", "nominal")
    policy = policy_file.load(tmp_path / "run/policy.npz", make_params("push"))
    boats = ResidualVecEnv("push", num_envs=3, scale=0.3)
    boats.seed(10**9)
    seen = boats.reset()
    simulation, memory = Simulation(make_params("push"), 3), None
    observed, fresh = simulation.reset(seeds=[10**9, 10**9 + 4, 10**9 + 8]), np.ones(3, bool)
    for _ in range(30):
        assert np.array_equal(seen.reshape(observed.shape), observed)
        correction = policy.forward(observed)
        action, memory = policy.act(simulation.sensed, observed, memory, fresh)
        observed, fresh = simulation.step(action).observation, np.zeros(3, bool)
        seen = boats.step(correction.reshape(-1, 2))[0]
    assert np.abs(correction).max() > 0


def test_the_state_for_a_central_critic_is_that_of_the_rows_own_world():
    worlds = TrainingVecEnv(tiny(network={"critic": "central"}))
    seen = worlds.restart(0.0, 10**9)
    states = seen["state"].reshape(8, 4, -1)
    assert (states == states[:, :1]).all()
    assert len(np.unique(states[:, 0], axis=0)) == 8


def test_the_worlds_of_a_training_answer_for_every_row():
    worlds = TrainingVecEnv(tiny(worlds={"teams": (4, 6), "num_envs": 4}))
    rows = 2 * 4 + 2 * 6
    assert worlds.env_is_wrapped(Monitor) == [True] * rows
    first, last = worlds.env_method("env_is_wrapped", Monitor, indices=[0, rows - 1])
    assert (first, last) == ([True] * 8, [True] * 12)
    worlds.set_attr("mark", 7)
    assert worlds.get_attr("mark", [0, rows - 1]) == [7, 7]
    with pytest.raises(NotImplementedError, match="options"):
        worlds.set_options({})
