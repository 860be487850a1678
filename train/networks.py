"""Actor and critic of stable-baselines3: perceptrons that see the same, or the world's state."""

from __future__ import annotations

from typing import Any

import torch
from gymnasium.spaces import Dict
from stable_baselines3.common.policies import ActorCriticPolicy, MultiInputActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import Tensor, nn

from baselines.network import Layers
from train.config import Config

ACTIVATIONS = {"relu": nn.ReLU, "tanh": nn.Tanh}


class AsTheyAre(BaseFeaturesExtractor):
    """Hands a dictionary of observations on."""

    def __init__(self, observation_space: Dict) -> None:
        super().__init__(observation_space, features_dim=1)

    def forward(self, observations: dict[str, Tensor]) -> Any:
        """The same."""
        return observations


class ApartPerceptrons(nn.Module):
    """The hidden layers of an actor of "obs" and of a critic of "obs" and "state"."""

    def __init__(self, space: Dict, hidden: list[int], activation: type[nn.Module]) -> None:
        super().__init__()
        seen, state = (space[name].shape[0] for name in ("obs", "state"))  # type: ignore[index]
        self.policy_net = perceptron(seen, hidden, activation)
        self.value_net = perceptron(seen + state, hidden, activation)
        self.latent_dim_pi = self.latent_dim_vf = hidden[-1]

    def forward(self, features: dict[str, Tensor]) -> tuple[Tensor, Tensor]:
        """Of the actor and of the critic."""
        return self.forward_actor(features), self.forward_critic(features)

    def forward_actor(self, features: dict[str, Tensor]) -> Tensor:
        """Of the actor, from what a boat observes."""
        latent: Tensor = self.policy_net(features["obs"])
        return latent

    def forward_critic(self, features: dict[str, Tensor]) -> Tensor:
        """Of the critic, from that and from the state of the world."""
        latent: Tensor = self.value_net(torch.cat([features["obs"], features["state"]], dim=-1))
        return latent


class CentralCriticPolicy(MultiInputActorCriticPolicy):
    """The actor sees what its boat observes, the critic the true state of the world too."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **{**kwargs, "features_extractor_class": AsTheyAre})

    def _build_mlp_extractor(self) -> None:
        assert isinstance(self.observation_space, Dict)
        assert isinstance(self.net_arch, list)
        self.mlp_extractor: Any = ApartPerceptrons(
            self.observation_space, self.net_arch, self.activation_fn
        )


def perceptron(inputs: int, hidden: list[int], activation: type[nn.Module]) -> nn.Sequential:
    """Hidden layers, an activation behind each."""
    layers: list[nn.Module] = []
    for size in hidden:
        layers += [nn.Linear(inputs, size), activation()]
        inputs = size
    return nn.Sequential(*layers)


def policy_class(config: Config) -> type[ActorCriticPolicy]:
    """For the critic that is asked for."""
    return CentralCriticPolicy if config.critic == "central" else ActorCriticPolicy


def policy_options(config: Config) -> dict[str, Any]:
    """What the class is made with."""
    return {
        "net_arch": list(config.hidden),
        "activation_fn": ACTIVATIONS[config.activation],
        "log_std_init": config.log_std_init,
    }


def linear_layers(policy: ActorCriticPolicy) -> list[nn.Linear]:
    """Those of the actor, from the observation to the mean action."""
    hidden = [one for one in policy.mlp_extractor.policy_net if isinstance(one, nn.Linear)]
    return [*hidden, policy.action_net]  # type: ignore[list-item]


def actor(policy: ActorCriticPolicy) -> nn.Module:
    """From observations to mean actions; shares its weights with the policy."""
    return nn.Sequential(policy.mlp_extractor.policy_net, policy.action_net)


def layers_of(policy: ActorCriticPolicy) -> Layers:
    """The actor as a policy file wants it."""
    return [
        (one.weight.detach().numpy().T.copy(), one.bias.detach().numpy().copy())
        for one in linear_layers(policy)
    ]


def put_layers(policy: ActorCriticPolicy, layers: Layers) -> None:
    """Gives the actor the weights of a policy file.

    Raises:
        ValueError: layers of other sizes.
    """
    own = linear_layers(policy)
    wanted = [tuple(one.weight.shape)[::-1] for one in own]
    given = [weight.shape for weight, _ in layers]
    if wanted != given:
        raise ValueError(
            f"layers of sizes {given} do not fit the actor's {wanted}: choose --hidden after them"
        )
    with torch.no_grad():
        for one, (weight, bias) in zip(own, layers, strict=True):
            one.weight.copy_(torch.as_tensor(weight.T))
            one.bias.copy_(torch.as_tensor(bias))
