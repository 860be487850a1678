"""The engine sb3: a warm start by imitation, then PPO of stable-baselines3.

At every checkpoint the worlds are made anew, from seeds that follow from how far the training has
come. A run that goes on from a checkpoint therefore does what it would have done if nobody had
stopped it, to the bit, on the same machine with the same number of threads.
"""

from __future__ import annotations

import random
import sys
import time
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from stable_baselines3.common.utils import set_random_seed
from tqdm import tqdm

from baselines.rollout.files import write
from train import actors, evaluation, tracking
from train.config import BAR, LEAST_RATE, SEEDS_OF_A_RUN, Config
from train.run import BEST, TENSORBOARD, Run, opened
from train.sb3 import policies
from train.sb3.buffer import Rollouts
from train.sb3.vec_env import Worlds

STEP = 1.3
"""Factor by which the actor's learning rate is adapted."""
BAND = 1.5
"""Factor from its target within which the divergence of an update is left alone."""
RATES = (1e-6, 1e-3)
"""Smallest and largest learning rate of the actor."""
WIDENS = 0.7
"""Share of the episodes that succeed where the curriculum widens."""
WINDOW = 2048
"""Ends of boats' episodes over which means are logged, and that share is taken."""


class Learner(PPO):
    """PPO whose actor and critic have learning rates of their own.

    Adam's steps are as large however small a gradient is, and what a step of the actor does to
    its actions has to be small beside their noise. So its learning rate follows the divergence
    of the updates. In the first updates only the critic learns: it has to judge the actor that
    there is before the actor follows it.

    Attributes:
        config: of the run.
        actor_rate: learning rate of the actor.
        seconds: of training so far, over all parts of the run.
        best: merit of the best policy so far, s.
        share: to which goals, noise and variation have grown.
        chance: states of the random generators at the checkpoint.
    """

    config: Config
    actor_rate: float
    seconds = 0.0
    best = float("inf")
    share = 1.0
    chance: Any = None

    @classmethod
    def made(cls, config: Config, worlds: Worlds) -> Learner:
        """An untrained one."""
        set_random_seed(config.first_seed % 2**32)
        rows = config.num_steps * worlds.num_envs
        learner = cls(
            policies.policy_class(config),
            worlds,
            learning_rate=config.learning_rate,
            n_steps=config.num_steps,
            batch_size=-(-rows // config.num_minibatches),
            n_epochs=config.update_epochs,
            gamma=config.gamma,
            gae_lambda=config.gae_lambda,
            clip_range=config.clip_coef,
            ent_coef=config.ent_coef,
            vf_coef=config.vf_coef,
            max_grad_norm=config.max_grad_norm,
            target_kl=config.target_kl,
            policy_kwargs=policies.policy_options(config),
            stats_window_size=WINDOW,
            device="cpu",
        )
        learner.config, learner.actor_rate = config, config.actor_learning_rate
        learner.share = config.first_share
        return learner

    def _setup_model(self) -> None:
        if isinstance(self.observation_space, Box):
            self.rollout_buffer_class = Rollouts
        super()._setup_model()
        critic = [one for name, one in self.policy.named_parameters() if "value" in name]
        actor = [one for name, one in self.policy.named_parameters() if "value" not in name]
        self.policy.optimizer = torch.optim.Adam(
            [{"params": actor}, {"params": critic}], self.lr_schedule(1.0), eps=1e-5
        )

    def _excluded_save_params(self) -> list[str]:
        # Whoever reads the file without this package needs no buffer.
        return [*super()._excluded_save_params(), "rollout_buffer_class"]

    def _update_learning_rate(self, optimizers: Any) -> None:
        waits = self._n_updates < self.config.critic_updates * self.n_epochs
        actor, critic = self.policy.optimizer.param_groups
        actor["lr"] = (
            0.0 if waits else self.actor_rate * (1.0 if self.config.adapt_kl else self.left)
        )
        critic["lr"] = self.config.learning_rate * self.left
        self.logger.record("train/actor_learning_rate", actor["lr"])
        self.logger.record("train/critic_learning_rate", critic["lr"])

    @property
    def left(self) -> float:
        """Share of the learning rates now."""
        return max(LEAST_RATE, self._current_progress_remaining) if self.config.anneal_lr else 1.0

    def train(self) -> None:
        """An update; then the noise is kept up, and the actor's rate follows the divergence."""
        waits = self._n_updates < self.config.critic_updates * self.n_epochs
        super().train()
        with torch.no_grad():
            self.policy.log_std.clamp_(min=self.config.log_std_min)
        if waits or self.config.adapt_kl is None:
            return
        share = self.logger.name_to_value["train/approx_kl"] / (self.config.adapt_kl * self.left)
        if share > BAND:
            self.actor_rate = max(self.actor_rate / STEP, RATES[0])
        elif share < 1 / BAND:
            self.actor_rate = min(self.actor_rate * STEP, RATES[1])

    @property
    def wide(self) -> bool:
        """Whether goals have widened to all where the run is to end there."""
        return self.config.until_wide and self.share >= 1.0

    def draw_as_at(self, chance: Any) -> None:
        """Puts the random generators into the states of a checkpoint."""
        plain, numpy_state, torch_state = chance
        random.setstate(plain)
        np.random.set_state(numpy_state)  # noqa: NPY002 (stable-baselines3 draws from it)
        torch.set_rng_state(torch_state)


def drawn() -> Any:
    """States of the random generators from which stable-baselines3 draws."""
    return random.getstate(), np.random.get_state(), torch.get_rng_state()  # noqa: NPY002


class Keeper(BaseCallback):
    """Evaluates, saves, renews the worlds and shows progress, between updates.

    Args:
        run: with the folder.
        worlds: of the training.
        bar: of the timesteps.
        resumed: timesteps of the checkpoint from which the run goes on; None for a new run.
    """

    model: Learner

    def __init__(self, run: Run, worlds: Worlds, bar: tqdm, resumed: int | None) -> None:
        super().__init__()
        self._run, self._worlds, self._bar, self._resumed = run, worlds, bar, resumed
        self._since = time.monotonic()

    def _on_step(self) -> bool:
        self._bar.update(self.training_env.num_envs)
        return not self.model.wide

    def _on_rollout_start(self) -> None:
        config, now = self._run.config, self.model.num_timesteps
        rollout = self.training_env.num_envs * config.num_steps
        evaluates = _passed(now, rollout, config.eval_every)
        if not (evaluates or _passed(now, rollout, config.checkpoint_every)):
            return
        if now != self._resumed:  # else that was done before the run was stopped
            if evaluates:
                self.evaluate()
            self.widen()
            self.save()
        rows = self.training_env.num_envs
        seed = config.first_seed + now // rollout * rows % (SEEDS_OF_A_RUN - rows)
        self.model._last_obs = self._worlds.renew(self.model.share, seed)
        self.model._last_episode_starts = np.ones(rows, dtype=bool)

    def evaluate(self) -> None:
        """Scores the policy as it is, and keeps it if it is the best so far."""
        model, run = self.model, self._run
        layers = actors.layers_of(policies.actor(model.policy))
        self._count_time()
        now = (model.num_timesteps, model.seconds)
        scores = evaluation.evaluate(layers, run.metadata, run.config, now)
        self._count_time()
        best = evaluation.merit(scores) < model.best
        if best:
            model.best = evaluation.merit(scores)
            write(run.folder / f"{BEST}.zip", model.save)
        evaluation.keep(run, layers, scores, best)
        for name, value in evaluation.told(scores).items():
            model.logger.record(name, value)
        self._bar.set_postfix_str(evaluation.headline(scores))

    def widen(self) -> None:
        """Lets goals, noise and variation grow where most episodes have succeeded."""
        ended, config = self.model.ep_success_buffer, self._run.config
        if ended and np.mean(ended) >= WIDENS:
            self.model.share = min(1.0, self.model.share + config.widening)
        if ended:
            ended.clear()
        self.model.logger.record("rollout/share", self.model.share)

    def save(self) -> None:
        """Writes the checkpoint."""
        self._count_time()
        self.model.chance = drawn()
        write(self._run.checkpoint, self.model.save)

    def _count_time(self) -> None:
        now = time.monotonic()
        self.model.seconds += now - self._since
        self._since = now


def _passed(now: int, rollout: int, every: int) -> bool:
    """Whether the last rollout has reached a multiple of ``every``, or there was none yet."""
    return now // every > (now - rollout) // every


def train(config: Config) -> None:
    """Trains, from the beginning or from the checkpoint that is there.

    Raises:
        ValueError, OSError: something of what was asked for does not go; see ``opened``.
    """
    torch.set_num_threads(config.torch_threads)
    run, start = opened(config)
    if run.checkpoint.exists() and evaluation.reached(run.curve) >= config.total_timesteps:
        return
    with tracking.tracked(config, run.folder, run.id):
        began, worlds = time.monotonic(), Worlds(config)
        resumed = run.checkpoint.exists()
        if resumed:
            run.note_code()
            learner = Learner.load(run.checkpoint, env=worlds, device="cpu")
            learner.draw_as_at(learner.chance)
        else:
            learner = Learner.made(config, worlds)
            actors.begin(policies.actor(learner.policy), config, start)
        learner.seconds += time.monotonic() - began
        done, total = learner.num_timesteps, config.total_timesteps
        evaluation.cut(run.curve, done if resumed else -1)
        learner.set_logger(configure(str(run.folder / TENSORBOARD), ["tensorboard"]))
        with tqdm(total=total, initial=done, **BAR) as bar:
            keeper = Keeper(run, worlds, bar, done if resumed else None)
            keeper.init_callback(learner)
            if done < total and not learner.wide:
                learner.learn(total - done, keeper, reset_num_timesteps=False)
            if evaluation.reached(run.curve) < learner.num_timesteps:
                keeper.evaluate()
                keeper.save()
        worlds.close()
        if config.until_wide and not learner.wide:
            print(f"goals have widened to {learner.share:.0%} only", file=sys.stderr)
