"""Actor and critic of stable-baselines3, whose critic may see the state of the world."""

from typing import Any

from gymnasium.spaces import Dict
from stable_baselines3.common.policies import ActorCriticPolicy, MultiInputActorCriticPolicy
from stable_baselines3.common.torch_layers import create_mlp
from torch import Tensor, nn

from train.sections import NetworkOptions

ACTIVATIONS = {"relu": nn.ReLU, "tanh": nn.Tanh}


class ActorAndCritic(nn.Module):
    """Hidden layers of an actor that sees "obs" (n, K) and of a critic that sees "state" too.

    Features (n, K + S) are both in this order, as a ``CombinedExtractor`` joins them.
    """

    def __init__(self, space: Dict, hidden: list[int], activation: type[nn.Module]) -> None:
        super().__init__()
        self._seen, state = (space[name].shape[0] for name in ("obs", "state"))  # type: ignore[index]
        self.policy_net = nn.Sequential(*create_mlp(self._seen, -1, hidden, activation))
        self.value_net = nn.Sequential(*create_mlp(self._seen + state, -1, hidden, activation))
        self.latent_dim_pi = self.latent_dim_vf = hidden[-1]

    def forward(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """Returns the last hidden layers (n, hidden[-1]) of actor and critic."""
        return self.forward_actor(features), self.forward_critic(features)

    def forward_actor(self, features: Tensor) -> Tensor:
        """Returns the last hidden layer of the actor, from what a boat observes."""
        return self.policy_net(features[:, : self._seen])

    def forward_critic(self, features: Tensor) -> Tensor:
        """Returns the last hidden layer of the critic, from observation and state of the world."""
        return self.value_net(features)


class CentralCriticPolicy(MultiInputActorCriticPolicy):
    """The actor sees what its boat observes, the critic the true state of the world too."""

    def _build_mlp_extractor(self) -> None:
        assert isinstance(self.observation_space, Dict)
        assert isinstance(self.net_arch, list)
        self.mlp_extractor: Any = ActorAndCritic(
            self.observation_space, self.net_arch, self.activation_fn
        )


def policy_class(options: NetworkOptions) -> tuple[type[ActorCriticPolicy], dict[str, Any]]:
    """Returns the class of actor and critic, and its arguments."""
    return CentralCriticPolicy if options.critic == "central" else ActorCriticPolicy, {
        "net_arch": list(options.hidden),
        "activation_fn": ACTIVATIONS[options.activation],
        "log_std_init": options.log_std_init,
    }


def actor(policy: ActorCriticPolicy) -> nn.Module:
    """Returns the network from observations to mean actions; it shares the policy's weights."""
    return nn.Sequential(policy.mlp_extractor.policy_net, policy.action_net)
