"""The learner of RLlib, its actor, and what it hands to policy files and to other processes."""

from typing import Any

import numpy as np
import torch
from ray.rllib.algorithms.ppo import PPO
from ray.rllib.algorithms.ppo.torch.ppo_torch_learner import PPOTorchLearner
from ray.rllib.core.columns import Columns
from torch import nn

from baselines.learned.network import Layers, NetworkPolicy
from train import actors
from train.run import Run

BOAT = "boat"
"""Name of the policy that all boats share."""
TOLERANCE = 1e-5
"""Largest difference between the actions of a policy file and those of the network."""
COMPARED = 256
"""Number of observations on which they are compared."""


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


def module_of(algorithm: PPO) -> Any:
    """Returns actor and critic of the learner."""
    (found,) = algorithm.learner_group.foreach_learner(lambda learner: learner.module[BOAT])
    return found.get()


def actor(module: Any) -> nn.Sequential:
    """Returns the network from observations to mean actions; it shares the module's weights."""
    return nn.Sequential(module.encoder.actor_encoder.net, module.pi.net)


def checked_layers(module: Any, run: Run) -> Layers:
    """Returns the actor's layers for a policy file.

    Args:
        module: of RLlib.
        run: for whose task the policy is.

    Raises:
        RuntimeError: the policy file would not act as the module does.
    """
    layers = actors.get_layers(actor(module))
    policy = NetworkPolicy(layers, run.metadata, run.config.params())
    size = (COMPARED, len(layers[0][0]))
    seen = np.random.default_rng(0).standard_normal(size, dtype=np.float32)
    outputs = module.forward_inference({Columns.OBS: torch.from_numpy(seen)})
    distribution = module.get_inference_action_dist_cls().from_logits(
        outputs[Columns.ACTION_DIST_INPUTS]
    )
    wanted = distribution.to_deterministic().sample().numpy().clip(-1.0, 1.0)
    difference = float(np.abs(policy.forward(seen) - wanted).max())
    if difference > TOLERANCE:
        raise RuntimeError(
            f"the exported policy differs by {difference:.1e} from the one that was trained"
        )
    return layers


def distribute_weights(algorithm: PPO) -> None:
    """Gives the learner's weights to all processes and waits until they have them.

    RLlib's own ``sync_weights`` drops what is for a process that has not yet answered the last
    time, as it is with those that have just been made: after its ``restore_from_path`` too, the
    first steps would come from untrained weights.
    """
    state = algorithm.learner_group.get_state("learner/rl_module", inference_only=True)["learner"]
    algorithm.env_runner_group.foreach_env_runner(lambda runner: runner.set_state(state))
