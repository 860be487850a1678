"""The options of a training in the terms of RLlib, its learner, and a connection to Ray."""

import logging
import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from operator import attrgetter
from typing import Any

import ray
import torch
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.algorithms.ppo.torch.ppo_torch_learner import PPOTorchLearner

from train.config import SEEDS_PER_RUN, Config
from train.rllib.env import SEED_LIMIT, Boats, num_processes, num_worlds, worlds_per_process
from train.sections import LEAST_RATE

BOAT = "boat"  #: name of the policy that all boats share
ONLY_SB3 = (
    *("network.critic", "network.residual", "network.log_std_min"),
    *("curriculum.step", "curriculum.rollout_starts"),
)
"""Options that only the engine sb3 has."""
LONGEST_PATH = 36  #: letters in the name of a temporary folder that leave Ray's sockets room


class Learner(PPOTorchLearner):
    """PPO whose actor and critic have optimizers and learning rates of their own."""

    def configure_optimizers_for_module(self, module_id: str, config: Any = None) -> None:
        """Makes the optimizers; RLlib calls it."""
        module = self.module[module_id]
        networks = {
            "actor": (module.encoder.actor_encoder, module.pi),
            "critic": (module.encoder.critic_encoder, module.vf),
        }
        for name, parts in networks.items():
            weights = [parameter for part in parts for parameter in self.get_parameters(part)]
            self.register_optimizer(
                module_id=module_id,
                optimizer_name=name,
                optimizer=torch.optim.Adam(weights, eps=1e-5),
                params=weights,
                lr_or_lr_schedule=config.learner_config_dict[name],
            )


def rollout_size(config: Config) -> int:
    """Returns the timesteps between two updates, about: RLlib adds the rest of its last step."""
    return config.ppo.num_steps * num_worlds(config) * config.worlds.teams[0]


def rate_schedule(config: Config, rate: float, waits: int = 0) -> list[list[float]]:
    """Returns the course of a learning rate as pairs (steps of worlds, learning rate).

    It is 0 in the first ``waits`` updates.
    """
    team, total = config.worlds.teams[0], config.ppo.total_timesteps
    begins = max(2, round((waits - 0.5) * rollout_size(config) / team)) if waits else 0
    ends = max(begins + 1, round((1 - LEAST_RATE) * total / team))
    least = LEAST_RATE if config.ppo.anneal_lr else 1.0
    left = max(least, 1 - begins * team / total)
    falls = [[begins, rate * left], [ends, rate * least]]
    return [[0, 0.0], [begins - 1, 0.0], *falls] if waits else falls


def settings(config: Config, done: int) -> PPOConfig:
    """Returns the settings of RLlib for a training that has come to ``done`` timesteps.

    Steps are those of single boats. Each world's part of a batch has one row more than steps, the
    state after the last of them, of which the minibatches have their share.
    """
    options, size = config.ppo, rollout_size(config)
    seed = config.first_seed + done % (SEEDS_PER_RUN - num_worlds(config))
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
    for name in ONLY_SB3:
        value, default = map(attrgetter(name), (config, Config()))
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
    address = config.compute.ray_address or "local"
    options: dict[str, Any] = {}
    with ExitStack() as stack:
        if address == "local":
            os.environ.setdefault("RAY_AUTH_MODE", "disabled")  # else it writes a token at home
            options = {"num_cpus": num_processes(config), "include_dashboard": False}
            if "RAY_TMPDIR" not in os.environ and len(tempfile.gettempdir()) > LONGEST_PATH:
                folder = tempfile.TemporaryDirectory("", "ray-", "/tmp", ignore_cleanup_errors=True)
                options["_temp_dir"] = stack.enter_context(folder)
        stack.callback(ray.shutdown)
        ray.init(address, logging_level=logging.ERROR, **options)
        yield
