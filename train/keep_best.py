"""Evaluation between updates: the best policy and the last stay in the folder of the run."""

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from baselines.learned.network import Layers
from train import evaluation
from train.config import SEEDS_PER_RUN
from train.evaluation import Score
from train.run import BEST, LAST, Run

PROGRESS_BAR = {"unit": " steps", "unit_scale": True, "desc": "PPO", "file": sys.stderr}
"""Options of the progress bar of a training."""


@dataclass
class Status:
    """How far a training has come, over all processes of its run."""

    timesteps: int = 0  #: decisions of single boats
    seconds: float = 0.0  #: time of training, s
    best: float = float("inf")  #: selection score of the best policy, s


@dataclass
class KeepBest:
    """Evaluates policies of a training, keeps the best and counts the time."""

    run: Run  #: with the folder
    status: Status  #: of the training, which is kept up to date
    bar: tqdm  #: of the timesteps
    log: Callable[[str, float], object]  #: writes a number by its name
    since: float  #: time on the monotonic clock from which on the training counts, s

    def evaluate(self, layers: Layers, save_model: Callable[[], object] = lambda: None) -> None:
        """Scores a policy and writes its files; ``save_model`` is called for the best so far."""
        run, status = self.run, self.status
        self.count_time()
        scores = evaluation.evaluate(
            layers, run.metadata, run.config, status.timesteps, status.seconds
        )
        self.count_time()
        selection_score = float(np.mean([score.penalised_time for score in scores]))
        best = selection_score < status.best
        if best:
            status.best = selection_score
            save_model()
        keep(run, layers, scores, best)
        self._show(scores)

    def _show(self, scores: Sequence[Score]) -> None:
        """Logs scores, and writes success and time next to the progress bar."""
        for score in scores:
            group = f"evaluation/{score.num_boats}_{score.scenario}"
            self.log(f"{group}_success", score.success)
            self.log(f"{group}_time", score.median_time)
        success = np.mean([score.success for score in scores])
        times = [score.median_time for score in scores if score.success]
        took = f", {np.mean(times):.1f} s" if times else ""
        self.bar.set_postfix_str(f"success {success:.0%}{took}")

    def count_time(self) -> None:
        """Adds the time since the last call to the seconds of the training."""
        now = time.monotonic()
        self.status.seconds += now - self.since
        self.since = now


def keep(run: Run, layers: Layers, scores: Sequence[Score], best: bool) -> None:
    """Writes the policy files of an evaluation, then its rows of the learning curve.

    The rows come last: where they are, the policy files are too.
    """
    first, initial = run.config.first_seed, run.config.init_from
    model_card = {
        "options": run.config.learned() | {"init_from": initial and initial.name},
        "timesteps": scores[0].timesteps,
        "training_seeds": [first, first + SEEDS_PER_RUN - 1],
        "development": [vars(score) for score in scores],
        "began_with": run.recorded("began_with"),
    }
    for name in [BEST, LAST] if best else [LAST]:
        run.save_policy(name, layers, model_card)
    evaluation.append_to_curve(run.curve, scores)


def passed(timesteps: int, rollout: int, every: int) -> bool:
    """Returns whether the last ``rollout`` timesteps (or none) reached a multiple of ``every``."""
    return timesteps // every > (timesteps - rollout) // every
