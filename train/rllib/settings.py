"""The options of a training in the terms of RLlib, and a connection to Ray."""

import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

import ray
from ray.rllib.algorithms.ppo import PPOConfig

from train.config import SEEDS_PER_RUN, Config
from train.rllib.env import SEED_LIMIT, Boats, num_processes, worlds_per_process
from train.rllib.learner import BOAT, Learner
from train.sections import LEAST_RATE

LONGEST_PATH = 36
"""Number of letters in the name of a temporary folder that leaves Ray's sockets room."""


def rollout_size(config: Config) -> int:
    """Returns the timesteps between two updates, about: RLlib adds the rest of its last step."""
    worlds = worlds_per_process(config) * num_processes(config)
    return config.ppo.num_steps * worlds * config.worlds.teams[0]


def rate_schedule(config: Config, rate: float, waits: int = 0) -> list[list[float]]:
    """Returns the course of a learning rate as pairs (steps of worlds, learning rate).

    Args:
        config: of the run.
        rate: to begin with.
        waits: number of first updates, in which it is 0.
    """
    team, total = config.worlds.teams[0], config.ppo.total_timesteps
    begins = max(2, round((waits - 0.5) * rollout_size(config) / team)) if waits else 0
    ends = max(begins + 1, round((1 - LEAST_RATE) * total / team))
    least = LEAST_RATE if config.ppo.anneal_lr else 1.0
    left = max(least, 1 - begins * team / total)
    falls = [[begins, rate * left], [ends, rate * least]]
    return [[0, 0.0], [begins - 1, 0.0], *falls] if waits else falls


def settings(config: Config, done: int) -> PPOConfig:
    """Returns the settings of RLlib.

    Steps are those of single boats. Each world's part of a batch has one row more than steps, the
    state after the last of them, of which the minibatches have their share.

    Args:
        config: of the run.
        done: timesteps of the training so far.
    """
    worlds, options = worlds_per_process(config) * num_processes(config), config.ppo
    seed = config.first_seed + done % (SEEDS_PER_RUN - worlds)
    size = rollout_size(config)
    rows = size * (options.num_steps + 1) // options.num_steps
    ppo = PPOConfig()
    ppo.environment(Boats, env_config={"config": config, "seed": seed}, disable_env_checking=True)
    ppo.env_runners(
        num_env_runners=config.compute.num_env_runners,
        num_envs_per_env_runner=worlds_per_process(config),
    )
    ppo.learners(
        learner_class=Learner,
        learner_config_dict={
            "actor": rate_schedule(config, options.actor_learning_rate, options.critic_updates),
            "critic": rate_schedule(config, options.learning_rate),
        },
    )
    ppo.multi_agent(
        policies={BOAT},
        policy_mapping_fn=lambda agent, episode, **_: BOAT,
        count_steps_by="agent_steps",
    )
    ppo.rl_module(
        model_config={
            "fcnet_hiddens": list(config.network.hidden),
            "fcnet_activation": config.network.activation,
            "vf_share_layers": False,
            "free_log_std": True,
        }
    )
    ppo.training(
        gamma=options.gamma,
        lambda_=options.gae_lambda,
        train_batch_size_per_learner=size,
        minibatch_size=min(size, -(-rows // options.num_minibatches)),
        num_epochs=options.update_epochs,
        clip_param=options.clip_coef,
        entropy_coeff=options.ent_coef,
        vf_loss_coeff=options.vf_coef,
        vf_clip_param=float("inf"),  # else large errors of the value teach nothing
        grad_clip=options.max_grad_norm,
        use_kl_loss=False,
    )
    ppo.debugging(seed=seed % SEED_LIMIT)
    ppo.fault_tolerance(restart_failed_env_runners=config.compute.ray_address is not None)
    return ppo


def check(config: Config) -> None:
    """Refuses options that only the engine sb3 has.

    Raises:
        ValueError: there is such an option.
    """
    if len(set(config.worlds.teams)) > 1:
        _refuse("teams", config.worlds.teams, "it trains one team size; choose one")
    for section, name in (
        (config.network, "critic"),
        (config.network, "residual"),
        (config.network, "log_std_min"),
        (config.curriculum, "step"),
        (config.curriculum, "rollout_starts"),
    ):
        value, default = getattr(section, name), getattr(type(section), name)
        if value != default:
            _refuse(name, value, f"only sb3 knows that; use {name} = {default!r}")


def _refuse(name: str, value: object, why: str) -> None:
    raise ValueError(f"{name} = {value!r} with engine = 'rllib': {why}, or use engine = 'sb3'")


@contextmanager
def connected(config: Config) -> Iterator[None]:
    """Connects to Ray while the block runs: the cluster that is asked for, or this machine alone.

    Raises:
        ConnectionError: there is no such cluster.
    """
    logging.getLogger("ray.rllib").setLevel(logging.ERROR)
    folder = None
    if config.compute.ray_address is not None:
        ray.init(config.compute.ray_address, logging_level=logging.ERROR)
    else:
        os.environ.setdefault("RAY_AUTH_MODE", "disabled")  # else it writes a token at home
        if "RAY_TMPDIR" not in os.environ and len(tempfile.gettempdir()) > LONGEST_PATH:
            folder = tempfile.mkdtemp(prefix="ray-", dir="/tmp")
        ray.init(
            "local",
            logging_level=logging.ERROR,
            num_cpus=num_processes(config),
            include_dashboard=False,
            _temp_dir=folder,
        )
    try:
        yield
    finally:
        ray.shutdown()
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
