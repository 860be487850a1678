"""Training by the engine rllib: imitation, then PPO of Ray RLlib.

The processes that sample are on this machine, or on those of a Ray cluster, each of which needs
this package. All boats share one policy. Options mean what they mean to the engine sb3, but for
``adapt_kl`` and ``target_kl``, which have no effect: the actor's learning rate does not follow the
divergence of the updates.

A run that is resumed from a checkpoint begins new episodes. It does not repeat to the bit what it
would have done without a stop. RLlib's checkpoints are pickles, and reading one runs whatever code
is in it: resume only runs whose folder comes from nobody else.
"""

import time
from contextlib import closing
from pathlib import Path

import numpy as np
import torch
from ray.rllib.algorithms.ppo import PPO
from tensorboardX import SummaryWriter  # type: ignore[import-not-found]
from tqdm import tqdm

from asv_env.files import named
from baselines.learned.network import Layers
from train import actors, imitation
from train.config import Config
from train.evaluation import truncate_curve
from train.keep_best import PROGRESS_BAR, KeepBest, Status, passed
from train.launch import open_run, tracked
from train.rllib import checkpoints
from train.rllib.checkpoints import actor, module_of
from train.rllib.settings import BOAT, check, connected, settings
from train.run import TENSORBOARD, Run


class Training:
    """Samples, learns, evaluates and saves; for the arguments see ``KeepBest``."""

    def __init__(self, run: Run, algorithm: PPO, status: Status, bar: tqdm, since: float) -> None:
        self._run, self._algorithm, self._status, self._bar = run, algorithm, status, bar
        self._writer = SummaryWriter(str(run.folder / TENSORBOARD))
        self._keep_best = KeepBest(run, status, bar, self._log, since)

    def until_end(self) -> None:
        """Trains until all timesteps are done."""
        config = self._run.config
        total = config.ppo.total_timesteps
        while self._status.timesteps < total:
            new = self._update()
            now = self._status.timesteps
            evaluates = now >= total or passed(now, new, config.evaluation.every)
            if evaluates:
                self.evaluate()
            if evaluates or passed(now, new, config.checkpoint_every):
                self.save()

    def _update(self) -> int:
        """Samples and learns; returns the number of new timesteps."""
        result = self._algorithm.train()
        sampled = result["env_runners"]
        new = int(sampled["num_module_steps_sampled"][BOAT])
        self._status.timesteps += new
        self._bar.update(new)
        for name, value in result["learners"][BOAT].items():
            self._log(f"train/{name}", value)
        self._log("rollout/ep_rew_mean", sampled.get("episode_return_mean"))
        self._writer.flush()
        return new

    def evaluate(self) -> None:
        """Scores the policy as it is, and keeps it if it is the best so far."""
        self._keep_best.evaluate(checkpoints.checked_layers(self._algorithm, self._run))

    def _log(self, name: str, value: object) -> None:
        """Logs a finite number; leaves anything else out."""
        if isinstance(value, float | int) and np.isfinite(value):
            self._writer.add_scalar(name, value, self._status.timesteps)

    def save(self) -> None:
        """Writes the checkpoint."""
        self._keep_best.count_time()
        checkpoints.save_checkpoint(self._run.checkpoints, self._algorithm, self._status)


def begin(algorithm: PPO, config: Config, layers: Layers | None) -> None:
    """Gives an untrained learner its noise, and its actor the weights of a file or of imitation."""
    module = module_of(algorithm)
    with torch.no_grad():
        module.pi.log_std.fill_(config.network.log_std_init)
    if layers is not None:
        actors.set_layers(actor(module), layers)
    imitation.imitate(actor(module), config)


def train(config: Config) -> None:
    """Trains, from the beginning or from the checkpoint of the run.

    Raises:
        ValueError, OSError: something is wrong with the options; see ``check`` and ``open_run``.
    """
    check(config)
    torch.set_num_threads(config.compute.torch_threads)
    run, layers = open_run(config)
    with closing(run), named(run.folder):
        last, status = checkpoints.last_checkpoint(run.checkpoints)
        if status.timesteps < config.ppo.total_timesteps:
            with tracked(run), connected(config):
                _train(run, layers, last, status)


def _train(run: Run, layers: Layers | None, last: Path | None, status: Status) -> None:
    """Trains in the folder of a run that is open, from the last checkpoint if there is one."""
    config, done = run.config, status.timesteps
    algorithm, began = settings(config, done).build_algo(), time.monotonic()
    if last is None:
        begin(algorithm, config, layers)
    else:
        checkpoints.restore(algorithm, last)
        run.note_code()
    checkpoints.distribute_weights(algorithm)
    truncate_curve(run.curve, -1 if last is None else done)
    with tqdm(total=config.ppo.total_timesteps, initial=done, **PROGRESS_BAR) as bar:
        training = Training(run, algorithm, status, bar, began)
        if last is None:
            training.evaluate()
            training.save()
        training.until_end()
    algorithm.stop()
