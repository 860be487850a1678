"""Training by the engine sb3: imitation, then PPO of stable-baselines3, with checkpoints.

At every checkpoint the worlds are made again, from seeds that follow from the timesteps. A run that
is resumed from a checkpoint therefore learns what it would have learned without a stop, to the bit,
on the same machine with the same number of threads.
"""

import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure
from tqdm import tqdm

from asv_env.files import named, write_bytes
from baselines.learned.network import Layers
from train import actors, imitation
from train.config import SEEDS_PER_RUN, Config
from train.evaluation import last_timesteps, truncate_curve
from train.keep_best import PROGRESS_BAR, KeepBest, passed
from train.launch import open_run, tracked
from train.run import TENSORBOARD, Run
from train.sb3.policies import actor
from train.sb3.ppo import Learner
from train.sb3.vec_env import TrainingVecEnv

ADVANCES = 0.7  #: fraction of episodes that must succeed for the curriculum to advance


class Callback(BaseCallback):
    """Evaluates, saves, makes the worlds again and shows progress, between updates.

    ``resumed`` are the timesteps of the checkpoint from which a run is resumed, None for a new run.
    """

    model: Learner

    def __init__(
        self, run: Run, worlds: TrainingVecEnv, keep_best: KeepBest, bar: tqdm, resumed: int | None
    ) -> None:
        super().__init__()
        self._run, self._worlds, self._keep_best = run, worlds, keep_best
        self._bar, self._resumed = bar, resumed

    def _on_step(self) -> bool:
        self._bar.update(self.training_env.num_envs)
        return True

    def _on_rollout_start(self) -> None:
        config, now = self._run.config, self.model.num_timesteps
        rows = self.training_env.num_envs
        rollout = rows * config.ppo.num_steps
        evaluates = passed(now, rollout, config.evaluation.every)
        if not (evaluates or passed(now, rollout, config.checkpoint_every)):
            return
        if now != self._resumed:  # else that was done before the run was stopped
            if evaluates:
                self.evaluate()
            self.advance_curriculum()
            self.save()
        seed = config.first_seed + now // rollout * rows % (SEEDS_PER_RUN - rows)
        self.model._last_obs = self._worlds.restart(self.model.progress, seed)
        self.model._last_episode_starts = np.ones(rows, dtype=bool)

    def evaluate(self) -> None:
        """Scores the policy as it is, and keeps it if it is the best so far."""
        model, file = self.model, self._run.folder / "best.zip"
        model.status.timesteps = model.num_timesteps
        layers = actors.get_layers(actor(model.policy))
        self._keep_best.evaluate(layers, lambda: write_bytes(file, model.saved()))

    def advance_curriculum(self) -> None:
        """Lets goals, noise and variation grow where most episodes have succeeded."""
        ended, step = self.model.ep_success_buffer, self._run.config.curriculum.step
        if ended and np.mean(ended) >= ADVANCES:
            self.model.progress = min(1.0, self.model.progress + step)
        if ended:
            ended.clear()
        self.model.logger.record("curriculum/progress", self.model.progress)

    def save(self) -> None:
        """Writes the checkpoint."""
        self._keep_best.count_time()
        write_bytes(self._run.checkpoint, self.model.saved())


def train(config: Config) -> None:
    """Trains, from the beginning or from the checkpoint of the run.

    Raises:
        ValueError, OSError: something is wrong with the options, or a file of the run cannot be
            read or written; see ``open_run``.
    """
    torch.set_num_threads(config.compute.torch_threads)
    run, layers = open_run(config)
    with closing(run), named(run.folder), _quiet_writers():
        if run.checkpoint.exists() and last_timesteps(run.curve) >= config.ppo.total_timesteps:
            return
        with tracked(run):
            _train(run, layers)


@contextmanager
def _quiet_writers() -> Iterator[None]:
    """Keeps threads that write the log of TensorBoard from printing errors of the system.

    The training hears of them as soon as it logs again.
    """
    before = threading.excepthook

    def report(failed: threading.ExceptHookArgs) -> None:
        if not issubclass(failed.exc_type, OSError):
            before(failed)

    threading.excepthook = report
    try:
        yield
    finally:
        threading.excepthook = before


def _train(run: Run, layers: Layers | None) -> None:
    """Trains in the folder of a run that is open."""
    config, total = run.config, run.config.ppo.total_timesteps
    began, worlds = time.monotonic(), TrainingVecEnv(config)
    resumed = run.checkpoint.exists()
    learner = _learner(run, worlds, layers)
    done = learner.num_timesteps
    truncate_curve(run.curve, done if resumed else -1)
    learner.set_logger(configure(str(run.folder / TENSORBOARD), ["tensorboard"]))
    with tqdm(total=total, initial=done, **PROGRESS_BAR) as bar:
        keep_best = KeepBest(run, learner.status, bar, learner.logger.record, began)
        callback = Callback(run, worlds, keep_best, bar, done if resumed else None)
        callback.init_callback(learner)
        if done < total:
            learner.learn(total - done, callback, reset_num_timesteps=False)
        if last_timesteps(run.curve) < learner.num_timesteps:
            callback.evaluate()
            callback.save()
    worlds.close()


def _learner(run: Run, worlds: TrainingVecEnv, layers: Layers | None) -> Learner:
    """Returns the learner of the checkpoint, or one that begins with layers or by imitation."""
    if run.checkpoint.exists():
        learner = Learner.resume(run.config, worlds, run.checkpoint)
        run.note_code()
    else:
        learner = Learner.create(run.config, worlds)
        if layers is not None:
            actors.set_layers(actor(learner.policy), layers)
        imitation.imitate(actor(learner.policy), run.config)
    return learner
