"""A newcomer's first PPO: ``python benchmarks/first_success.py``.

The snippet of the README, with stable-baselines3's default network and hyperparameters but for the
sizes of rollouts and minibatches, learns the easy push with several seeds. Between updates the
deterministic policy is evaluated on seeds for development. Each training has a folder with a
``curve.csv``, which ``python -m train.curves`` draws; one that is complete is not repeated.
"""

import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
import tyro
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from tqdm import tqdm

from asv_env import BoatVecEnv, make_params
from asv_env.checks import check_whole
from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Observation, Sensed
from baselines.rollout import runner, seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.lock import locked
from train import evaluation
from train.evaluation import append_to_curve, last_timesteps

STEPS, BATCH, TIME_LIMIT = 128, 4096, 30.0  #: of the README's snippet


@dataclass(frozen=True)
class Options:
    """Trains the README's snippet with several seeds, and keeps the learning curves."""

    rows: int = 2_000_000  #: decisions of single boats for which each policy is trained
    seeds: int = 3  #: number of trainings
    every: int = 8  #: updates between evaluations
    episodes: int = 100  #: episodes of an evaluation
    torch_threads: int = 1  #: threads of torch
    out: FilePath = Path("docs/training")  #: folder of the trainings, ``easy-push-0`` and so on

    def __post_init__(self) -> None:
        check_whole(self, "rows seeds every episodes torch_threads", 1)


class Deterministic:
    """The mean actions of a model."""

    def __init__(self, model: PPO, params: EnvParams) -> None:
        self._model = model

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``."""
        rows = observation.reshape(-1, observation.shape[-1])
        action, _ = self._model.predict(rows, deterministic=True)
        return action.reshape(*observation.shape[:2], 2), None


class Watch(BaseCallback):
    """Evaluates the policy between updates; its time does not count as training."""

    def __init__(self, params: EnvParams, curve: Path, options: Options) -> None:
        super().__init__()
        self._params, self._curve, self._options = params, curve, options
        self._began, self._rollouts = time.monotonic(), 0
        self._bar = tqdm(total=options.rows, desc=curve.parent.name, unit="row", unit_scale=True)

    def _on_rollout_start(self) -> None:
        if self._rollouts % self._options.every == 0:
            self._evaluate()
        self._rollouts += 1
        self._bar.update(self.num_timesteps - self._bar.n)

    def _on_training_end(self) -> None:
        self._evaluate()
        self._bar.close()

    def _evaluate(self) -> None:
        paused, first = time.monotonic(), seeds.DEVELOPMENT.start
        wanted = range(first, first + self._options.episodes)
        logs = runner.run(partial(Deterministic, self.model), self._params, wanted, len(wanted))
        rows = [log.episode for log in logs]
        spent = paused - self._began
        score = evaluation.score(rows, self._params, "nominal", self.num_timesteps, spent)
        append_to_curve(self._curve, [score])
        self._bar.set_postfix(success=f"{score.success:.2f}")
        self._began += time.monotonic() - paused

    def _on_step(self) -> bool:
        return True


def train(seed: int, folder: Path, options: Options) -> None:
    """Trains with a seed, from the beginning, unless the folder has a complete curve."""
    curve = folder / "curve.csv"
    if last_timesteps(curve) >= options.rows:
        return
    curve.unlink(missing_ok=True)
    world = {"difficulty": "easy", "time_limit": TIME_LIMIT}
    boats = BoatVecEnv("push", num_envs=64, stagger=True, **world)
    model = PPO("MlpPolicy", boats, n_steps=STEPS, batch_size=BATCH, device="cpu", seed=seed)
    tier = make_params("push", difficulty="easy")  # with the tier's own time limit
    model.learn(options.rows, callback=Watch(tier, curve, options))


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Trains with every seed and prints when each first reached 80 % of successes.

    Raises:
        OSError: the folder cannot be used.
    """
    torch.set_num_threads(options.torch_threads)
    with locked(options.out):
        for seed in range(options.seeds):
            folder = options.out / f"easy-push-{seed}"
            folder.mkdir(exist_ok=True)
            train(seed, folder, options)
            rows = evaluation.read_curve(folder / "curve.csv")
            there = rows[rows["success"] >= 0.8]
            first = there["seconds"].min() if len(there) else np.inf
            last = rows.iloc[-1]
            print(
                f"seed {seed}: 80 % after {first:.0f} s, {100 * last['success']:.0f} % at the end, "
                f"after {last['seconds']:.0f} s"
            )


main = command(study, "python benchmarks/first_success.py")

if __name__ == "__main__":
    main()
