"""Checkpoints of RLlib: a folder each, and a file that names the last."""

import json
import shutil
import tempfile
from dataclasses import asdict
from pathlib import Path

from ray.rllib.algorithms.ppo import PPO

from baselines.rollout.files import write_text
from train.keep_best import Status

STATUS = "status.json"
"""File in a checkpoint that says how far the training has come."""


class Checkpoints:
    """Checkpoints of a run. Whenever a run is killed, the file names one that is whole.

    Args:
        folder: of the run.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / "checkpoint"
        self._last = self._folder / "last"

    def last(self) -> tuple[Path | None, Status]:
        """Returns the folder of the last checkpoint, if there is one, and its status."""
        if not self._last.exists():
            return None, Status()
        found = self._folder / self._last.read_text(encoding="utf-8")
        return found, Status(**json.loads((found / STATUS).read_text(encoding="utf-8")))

    def save(self, algorithm: PPO, status: Status) -> None:
        """Writes a checkpoint, then deletes all others."""
        self._folder.mkdir(exist_ok=True)
        new = Path(tempfile.mkdtemp(prefix=f"{status.timesteps}-", dir=self._folder))
        algorithm.save_to_path(new.absolute())
        (new / STATUS).write_text(json.dumps(asdict(status)), encoding="utf-8")
        write_text(self._last, new.name)
        for folder in self._folder.iterdir():
            if folder.is_dir() and folder != new:
                shutil.rmtree(folder)
