"""PPO of stable-baselines3 whose actor and critic have learning rates of their own."""

import io
import json
import random
import zipfile
from dataclasses import asdict
from pathlib import Path
from typing import Any, Self

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.utils import set_random_seed
from stable_baselines3.common.vec_env import VecEnv

from baselines.rollout.commands import unbroken
from train.config import Config
from train.keep_best import Status
from train.sb3.policies import policy_class
from train.sections import LEAST_RATE

RATE_FACTOR = 1.3  #: factor by which the actor's learning rate is adapted
TOLERANCE = 1.5  #: factor by which the divergence of an update may miss its target
RATES = (1e-6, 1e-3)  #: smallest and largest learning rate of the actor
STATS_WINDOW = 2048  #: ends of boats' episodes over which returns and success are averaged
SAME_NAMES = "learning_rate gamma gae_lambda ent_coef vf_coef max_grad_norm target_kl"
"""Options that stable-baselines3 calls as CleanRL does."""


class TorchRolloutBuffer(RolloutBuffer):
    """Gathers minibatches by torch, in a third of the time that NumPy takes."""

    def _get_samples(self, batch_inds: np.ndarray, env: Any = None) -> RolloutBufferSamples:
        rows = torch.from_numpy(batch_inds)
        seen, actions, *others = (
            torch.from_numpy(column).index_select(0, rows)
            for column in (
                *(self.observations, self.actions, self.values),
                *(self.log_probs, self.advantages, self.returns),
            )
        )
        return RolloutBufferSamples(seen, actions, *(column.flatten() for column in others))


class Learner(PPO):
    """PPO whose actor and critic have learning rates of their own.

    Adam's steps have the same size however small a gradient is, and what a step of the actor does
    to its actions has to be small compared with their noise. So its learning rate follows the
    divergence of the updates. In the first updates only the critic learns: it has to judge the
    actor that there is before the actor follows it.
    """

    config: Config  #: of the run
    status: Status  #: timesteps, seconds and best score of the training
    actor_rate: float  #: learning rate of the actor
    progress: float  #: of the curriculum, 0 to 1
    kept: dict[str, Any]  #: what a resumed training needs besides weights, as JSON expresses it

    @classmethod
    def create(cls, config: Config, worlds: VecEnv) -> Self:
        """Returns an untrained learner."""
        set_random_seed(config.first_seed % 2**32)
        options, (policy, arguments) = config.ppo, policy_class(config.network)
        rows = options.num_steps * worlds.num_envs
        learner = cls(
            policy,
            worlds,
            n_steps=options.num_steps,
            batch_size=-(-rows // options.num_minibatches),
            n_epochs=options.update_epochs,
            clip_range=options.clip_coef,
            policy_kwargs=arguments,
            stats_window_size=STATS_WINDOW,
            device="cpu",
            **{name: getattr(options, name) for name in SAME_NAMES.split()},
        )
        learner.config, learner.status = config, Status()
        learner.actor_rate = options.actor_learning_rate
        learner.progress = config.curriculum.first_progress
        return learner

    def _setup_model(self) -> None:
        if isinstance(self.observation_space, Box):
            self.rollout_buffer_class = TorchRolloutBuffer
        super()._setup_model()
        networks: tuple[list[Any], list[Any]] = ([], [])  # actor, critic
        for name, weights in self.policy.named_parameters():
            networks["value" in name].append(weights)
        groups = [{"params": weights} for weights in networks]
        self.policy.optimizer = torch.optim.Adam(groups, self.lr_schedule(1.0), eps=1e-5)

    def _excluded_save_params(self) -> list[str]:
        # Whoever reads the file without this package needs no buffer.
        return [*super()._excluded_save_params(), "rollout_buffer_class"]

    def _update_learning_rate(self, optimizers: Any) -> None:
        options = self.config.ppo
        actor, critic = self.policy.optimizer.param_groups
        actor["lr"] = self.actor_rate * (1.0 if options.adapt_kl else self.annealing)
        if self.critic_only:
            actor["lr"] = 0.0
        critic["lr"] = options.learning_rate * self.annealing
        self.logger.record("train/actor_learning_rate", actor["lr"])
        self.logger.record("train/critic_learning_rate", critic["lr"])

    @property
    def critic_only(self) -> bool:
        """Whether this is one of the first updates, in which only the critic learns."""
        return self._n_updates < self.config.ppo.critic_updates * self.n_epochs

    @property
    def annealing(self) -> float:
        """Fraction of the initial learning rates now."""
        if not self.config.ppo.anneal_lr:
            return 1.0
        return max(LEAST_RATE, self._current_progress_remaining)

    def train(self) -> None:
        """Updates; then bounds the noise from below and adapts the actor's learning rate.

        Raises:
            ValueError: weights are no longer finite.
        """
        critic_only = self.critic_only
        try:
            super().train()
        except ValueError as error:  # torch checks what it gets, not all there is
            self._check_finite(error)
            raise
        self._check_finite()
        with torch.no_grad():
            self.policy.log_std.clamp_(min=self.config.network.log_std_min)
        if not critic_only:
            self._adapt_rate()

    def _check_finite(self, cause: Exception | None = None) -> None:
        """Refuses weights that are not finite."""
        if not all(bool(weights.isfinite().all()) for weights in self.policy.parameters()):
            raise ValueError(
                f"the training has diverged after {self.num_timesteps} timesteps, its weights are "
                "no longer finite: begin again with smaller learning rates; what the last "
                "checkpoint holds is kept"
            ) from cause

    def _adapt_rate(self) -> None:
        """Lets the actor's learning rate follow the divergence of the update."""
        target = self.config.ppo.adapt_kl
        if target is None:
            return
        ratio = self.logger.name_to_value["train/approx_kl"] / (target * self.annealing)
        if ratio > TOLERANCE:
            self.actor_rate = max(self.actor_rate / RATE_FACTOR, RATES[0])
        elif ratio < 1 / TOLERANCE:
            self.actor_rate = min(self.actor_rate * RATE_FACTOR, RATES[1])

    def saved(self) -> bytes:
        """Returns the file of stable-baselines3, from which ``resume`` continues too."""
        self.kept = {
            "num_timesteps": self.num_timesteps,
            "updates": self._n_updates,
            "actor_rate": self.actor_rate,
            "progress": self.progress,
            "status": asdict(self.status),
            "random": _random_states(),
        }
        content = io.BytesIO()
        with unbroken():
            self.save(content)
        return content.getvalue()

    @classmethod
    def resume(cls, config: Config, worlds: VecEnv, file: Path) -> Self:
        """Returns the learner of a checkpoint, of a run with these options.

        Of the file only weights and plain numbers are read. Nothing is unpickled.

        Raises:
            ValueError: the file is damaged, or of a learner of other options.
        """
        learner = cls.create(config, worlds)
        try:
            _, weights, _ = load_from_zip_file(file, load_data=False, device="cpu")
            with zipfile.ZipFile(file) as archive:
                kept = json.loads(archive.read("data"))["kept"]
            learner.set_parameters(weights, exact_match=True, device="cpu")
            learner.num_timesteps, learner._n_updates = kept["num_timesteps"], kept["updates"]
            learner.actor_rate, learner.progress = kept["actor_rate"], kept["progress"]
            learner.status = Status(**kept["status"])
            _restore_random_states(kept["random"])
        except Exception as error:  # libraries raise whatever they meet
            reason = f"{type(error).__name__}: {error}".splitlines()[0]
            raise ValueError(
                f"{file} cannot be read ({reason}): put back a copy of it, or begin again with "
                "--overwrite"
            ) from error
        return learner


def _random_states() -> list[Any]:
    """Returns the states of the generators from which stable-baselines3 draws, as JSON has them."""
    name, keys, *rest = np.random.get_state()  # noqa: NPY002
    return [
        random.getstate(),
        [name, np.asarray(keys).tolist(), *rest],
        torch.get_rng_state().tolist(),
    ]


def _restore_random_states(states: list[Any]) -> None:
    """Puts the generators into states that ``_random_states`` has returned."""
    (version, internal, gauss), numpy_state, torch_state = states
    random.setstate((version, tuple(internal), gauss))
    np.random.set_state(tuple(numpy_state))  # noqa: NPY002
    torch.set_rng_state(torch.tensor(torch_state, dtype=torch.uint8))
