"""The folder of a run: its options, the code that trained it, and the names of its files.

==================  =============================================================================
``config.json``     options, code, libraries and machine
``checkpoint.zip``  all that the training needs to resume (``checkpoint``, a folder, of rllib)
``curve.csv``       scores of the policy, evaluation by evaluation
``best.npz``        policy file of the best evaluation
``best.zip``        the same policy, as stable-baselines3 saves it
``policy.npz``      policy file of the last evaluation
``tensorboard``     log of the engine
==================  =============================================================================
"""

import json
import platform
import sys
from collections.abc import Sequence
from typing import Any
from uuid import uuid4

from filelock import BaseFileLock

from asv_env.files import PREFIX, named, remove, write_text
from asv_env.sensing import observation
from baselines.learned import policy_file
from baselines.learned.network import Layers, Metadata
from baselines.rollout import provenance
from baselines.rollout.lock import NAME as LOCK
from baselines.rollout.lock import lock
from baselines.rollout.provenance import revision
from train.config import CONTROL_RATE, Config

COMMON = ("numpy", "scipy", "pymunk", "gymnasium", "torch")
LIBRARIES = {"sb3": (*COMMON, "stable-baselines3"), "rllib": (*COMMON, "ray")}
CONFIG, TENSORBOARD, BEST, LAST = "config.json", "tensorboard", "best.npz", "policy.npz"
LEARNED = (BEST, LAST, "best.zip", "checkpoint.zip", "checkpoint", "curve.csv")
OWN = (CONFIG, TENSORBOARD, *LEARNED)
"""Files and folders that are deleted when a run starts again."""


class Run:
    """The folder of the run with some options."""

    def __init__(self, config: Config) -> None:
        self.config, self.folder = config, config.folder
        self.curve = self.folder / "curve.csv"
        self.checkpoint = self.folder / "checkpoint.zip"  #: from which stable-baselines3 resumes
        self.checkpoints = self.folder / "checkpoint"  #: folder from which RLlib resumes
        self._lock: BaseFileLock | None = None

    def open(self, began_with: dict[str, Any] | None = None) -> None:
        """Creates the folder, or accepts that of the same run; without a checkpoint, starts again.

        No other run can use the folder until ``close``.

        Args:
            began_with: model card of the policy file with which learning begins, if there is one.

        Raises:
            ValueError: the folder holds another run, or one that this code cannot resume.
            FileExistsError: it holds something else, or another run uses it.
            OSError: nothing can be written there.
        """
        self._check_folder()  # before a lock is left in it
        self._lock = lock(self.folder)
        try:
            self._open(began_with)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Gives the folder back."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def _open(self, began_with: dict[str, Any] | None) -> None:
        config = self._check_folder()
        has_checkpoint = self.checkpoint.exists() or self.checkpoints.exists()
        if config is not None and has_checkpoint and not self.config.overwrite:
            self._check_same(config)
            return
        for name in OWN:
            remove(self.folder / name)
        options, version = self.config.learned(), observation.VERSION
        written = {"options": options, "began_with": began_with, "observation_version": version}
        self._write_config(written | {"id": uuid4().hex[:12]} | self._software)

    def note_code(self) -> None:
        """Notes in ``config.json`` where a run is resumed by other code or libraries."""
        config, now = self._read_config() or {}, self._software
        parts = [config, *config.get("resumed_with", [])]
        if any(parts[-1].get(name) != now[name] for name in ("code", "libraries")):
            print(f"{self.folder} is resumed with other code or libraries", file=sys.stderr)
            self._write_config(config | {"resumed_with": [*parts[1:], now]})

    @property
    def _software(self) -> dict[str, Any]:
        return software(LIBRARIES[self.config.engine])

    def _write_config(self, config: dict[str, Any]) -> None:
        write_text(self.folder / CONFIG, json.dumps(config, indent=2) + "\n")

    def _check_folder(self) -> dict[str, Any] | None:
        """Returns what is in ``config.json``, None of a new run; refuses a folder of others."""
        config = self._read_config()
        if config is not None or not self.folder.exists():
            return config
        with named(self.folder, "cannot be used"):
            names = {path.name for path in self.folder.iterdir()}
        names = {name for name in names - {LOCK} if not name.startswith(PREFIX)}
        if not names:
            return None
        if names - set(OWN) or not names & set(LEARNED):
            raise FileExistsError(
                f"{self.folder} holds something else than a run: choose another folder with --out"
            )
        if not self.config.overwrite:
            raise FileExistsError(
                f"{self.folder / CONFIG} is missing or damaged: begin again with --overwrite, or "
                "choose another folder with --out"
            )
        return None

    def _read_config(self) -> dict[str, Any] | None:
        """Returns the content of ``config.json``; None where there is none of a run."""
        try:
            config = json.loads((self.folder / CONFIG).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return None
        known = {"options": dict, "observation_version": int}
        if not isinstance(config, dict):
            return None
        fits = all(isinstance(config.get(name), kind) for name, kind in known.items())
        return config if fits else None

    def recorded(self, name: str) -> Any:
        """Returns a field of ``config.json``, such as "id" or "began_with"; None without it."""
        return (self._read_config() or {}).get(name)

    def _check_same(self, config: dict[str, Any]) -> None:
        """Refuses to resume a run of other options or observations."""
        remedy = "choose another folder with --out, or start again with --overwrite"
        if config["observation_version"] != observation.VERSION:
            raise ValueError(
                f"{self.folder} was trained on version {config['observation_version']} of the "
                f"observation, this is version {observation.VERSION}: {remedy}"
            )
        before = by_name(Config().learned()) | by_name(config["options"])
        now = by_name(self.config.learned())
        changed = [
            f"{name} was {before.get(name)!r} and is {now.get(name)!r}"
            for name in dict.fromkeys([*before, *now])
            if before.get(name) != now.get(name)
        ]
        if changed:
            raise ValueError(
                f"{self.folder} holds a run with other options ({'; '.join(changed)}): {remedy}"
            )

    def save_policy(self, name: str, layers: Layers, model_card: dict[str, Any]) -> None:
        """Writes a policy file into the folder."""
        policy_file.save(self.folder / name, layers, self.metadata, model_card)

    @property
    def metadata(self) -> Metadata:
        """What a policy of this run is made for."""
        config, network = self.config, self.config.network
        return Metadata(
            tasks=(config.definition.name,),
            activation=network.activation,
            action_repeat=CONTROL_RATE // config.worlds.decision_rate,
            residual=network.residual,
            observation=config.observed,
        )


def by_name(options: dict[str, Any]) -> dict[str, Any]:
    """Returns nested options by names such as "ppo.gamma"."""
    return {
        f"{name}.{field}" if field else name: inner
        for name, value in options.items()
        for field, inner in (value.items() if isinstance(value, dict) else [("", value)])
    }


def software(libraries: Sequence[str]) -> dict[str, Any]:
    """Returns the code, the libraries and the machine of a training."""
    return {
        "code": provenance.code("train"),
        "revision": revision(),
        "libraries": provenance.versions(libraries),
        "python": platform.python_version(),
        "machine": platform.machine(),
    }
