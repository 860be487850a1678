"""The folder of a run: what was asked for, by which code, and how far it has come.

==================  =============================================================================
``config.json``     options, and by which code, libraries and machine
``checkpoint.zip``  all that the training needs to go on
``curve.csv``       how good the policy was, evaluation by evaluation
``best.npz``        policy file of the best of them
``best.zip``        the same, as the engine saves it
``policy.npz``      policy file of the last
``tensorboard``     what the engine logs
==================  =============================================================================
"""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import uuid4

from asv_env.presets import make_params
from asv_env.sensing import observation
from baselines.learned import policy_file
from baselines.learned.metadata import Layers, Metadata, Phase
from baselines.learned.network import NetworkPolicy
from baselines.learned.phases import PhasedPolicy
from baselines.rollout import provenance
from baselines.rollout.files import remove_parts, write, write_text
from train import actors, tracking
from train.config import CONTROL_RATE, Config
from train.imitation import check_recorded

LIBRARIES = {
    "sb3": ("numpy", "scipy", "pymunk", "gymnasium", "stable-baselines3", "torch"),
    "rllib": ("numpy", "scipy", "pymunk", "gymnasium", "ray", "torch"),
}
OWN = (
    "config.json",
    "checkpoint.zip",
    "checkpoint",
    "curve.csv",
    "best.npz",
    "best.zip",
    "policy.npz",
)
TENSORBOARD, BEST = "tensorboard", "best"


@dataclass(frozen=True)
class Run:
    """A run's folder.

    Attributes:
        config: of the run.
    """

    config: Config

    @property
    def folder(self) -> Path:
        """Where it is."""
        return self.config.folder

    @property
    def checkpoint(self) -> Path:
        """File from which the training goes on."""
        return self.folder / "checkpoint.zip"

    @property
    def curve(self) -> Path:
        """File of the evaluations."""
        return self.folder / "curve.csv"

    def open(self, began_with: dict[str, Any] | None = None) -> None:
        """Begins the run, or finds the one that is there; without a checkpoint it is begun anew.

        Args:
            began_with: model card of the policy file with which learning begins, if it does.

        Raises:
            ValueError: the folder holds another run, or one that this code cannot go on with.
            FileExistsError: it holds something else.
        """
        told = self._told()
        if told is None and self.folder.exists() and any(self.folder.iterdir()):
            raise FileExistsError(
                f"{self.folder} holds something else than a run: choose another folder with --out"
            )
        if told is not None and self._has_checkpoint and not self.config.overwrite:
            self._check(told)
            return
        self._clear()
        self.folder.mkdir(parents=True, exist_ok=True)
        told = {"options": self.config.learned(), "began_with": began_with}
        told |= {"observation_version": observation.VERSION, "id": uuid4().hex[:12]}
        self._tell(told | _made_by(self.config))

    def note_code(self) -> None:
        """Notes in ``config.json`` by what the run goes on, where code or a library has changed."""
        told, now = self._told() or {}, _made_by(self.config)
        parts = [told, *told.get("went_on_with", [])]
        if any(parts[-1].get(name) != now[name] for name in ("code", "libraries")):
            print(f"{self.folder} goes on with other code or libraries", file=sys.stderr)
            self._tell(told | {"went_on_with": [*parts[1:], now]})

    @property
    def _has_checkpoint(self) -> bool:
        return self.checkpoint.exists() or (self.folder / "checkpoint").exists()

    def _tell(self, told: dict[str, Any]) -> None:
        text = json.dumps(told, indent=2) + "\n"
        write_text(self.folder / "config.json", text)

    def _told(self) -> dict[str, Any] | None:
        """What ``config.json`` says; None where there is none of a run."""
        try:
            told = json.loads((self.folder / "config.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        known = {"options", "observation_version"}
        return told if isinstance(told, dict) and known <= told.keys() else None

    def _said(self, name: str) -> Any:
        return (self._told() or {}).get(name)

    @property
    def began_with(self) -> dict[str, Any] | None:
        """Model card of the policy file with which learning began."""
        model_card: dict[str, Any] | None = self._said("began_with")
        return model_card

    @property
    def id(self) -> str | None:
        """By which a tracker knows the run again; None for one from before runs had any."""
        name: str | None = self._said("id")
        return name

    def _clear(self) -> None:
        for name in (*OWN, TENSORBOARD):
            path = self.folder / name
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)
        remove_parts(self.folder)

    def _check(self, told: dict[str, Any]) -> None:
        """Refuses to go on with a run that is not this one."""
        remedy = "choose another folder with --out, or begin anew with --overwrite"
        if told["observation_version"] != observation.VERSION:
            raise ValueError(
                f"{self.folder} was trained on version {told['observation_version']} of the "
                f"observation, this is version {observation.VERSION}: {remedy}"
            )
        before, now = Config().learned() | told["options"], self.config.learned()
        changed = [
            f"{name} was {before.get(name)!r} and is {now.get(name)!r}"
            for name in dict.fromkeys([*before, *now])
            if before.get(name) != now.get(name)
        ]
        if changed:
            raise ValueError(
                f"{self.folder} holds a run with other options ({'; '.join(changed)}): {remedy}"
            )

    def save_policy(self, name: str, layers: Layers, model_card: dict[str, Any]) -> Path:
        """Writes a policy file into the folder."""
        path = self.folder / name
        phases = [Phase(layers, self.metadata)]
        write(path, lambda part: policy_file.save(part, phases, model_card))
        return path

    @property
    def metadata(self) -> Metadata:
        """What a policy of this run is made for."""
        return Metadata(
            tasks=(self.config.task,),
            activation=self.config.activation,
            action_repeat=self.config.decide_every,
            residual=self.config.residual,
            mirrors=self.config.mirror,
        )


def opened(config: Config) -> tuple[Run, Layers | None]:
    """The run with its folder, once all that was asked for is found to go.

    Returns:
        The run, and the layers with which learning begins where ``initial`` has any.

    Raises:
        ValueError, OSError, ImportError: something does not go; nothing was made then.
    """
    start, model_card = initial(config)
    check_recorded(config)
    if config.hand_over is not None:
        handed, _ = policy_file.read(config.hand_over)
        try:
            for team in config.teams:
                PhasedPolicy(handed, make_params("transport", team))
        except ValueError as error:
            raise ValueError(f"--hand-over {config.hand_over}: {error}") from error
    tracking.check(config)
    run = Run(config)
    run.open(model_card)
    return run, start


def initial(config: Config) -> tuple[Layers, dict[str, Any]] | tuple[None, None]:
    """Layers and model card of the policy file with which learning begins, if there is one.

    Raises:
        ValueError: a policy of another kind of action or version of the observation, or of
            another activation.
        FileNotFoundError: there is no such file.
    """
    if config.init_from is None:
        return None, None
    phase, model_card = policy_file.read_single(config.init_from)
    layers, metadata = phase.layers, phase.metadata
    try:
        NetworkPolicy(layers, metadata, make_params(metadata.tasks[0]))
        actors.check_fit(layers, (len(observation.NAMES), *config.hidden, 2))
    except ValueError as error:
        raise ValueError(f"--init-from {config.init_from}: {error}") from error
    wanted = {
        "activation": (metadata.activation, config.activation),
        "mirror": (metadata.mirrors, config.mirror),
        "residual": (metadata.residual, config.residual),
        "decision_rate": (CONTROL_RATE // metadata.action_repeat, config.decision_rate),
    }
    for option, (told, asked) in wanted.items():
        if told != asked:
            raise ValueError(
                f"--init-from {config.init_from}: its {option} is {told!r}, that of the training "
                f"{asked!r}; train with that of the file"
            )
    return layers, model_card


def _made_by(config: Config) -> dict[str, Any]:
    return {
        "code": provenance.code("train"),
        "revision": revision(),
        "libraries": provenance.versions(LIBRARIES[config.engine]),
        "python": platform.python_version(),
        "machine": platform.machine(),
    }


def revision() -> str | None:
    """Of git, marked where files differ from it; None where there is none."""
    command = ["git", "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        told = subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return told.stdout.strip()
