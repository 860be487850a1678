"""The learned policies that are part of this package: a policy file for each task.

They come from ``python -m train``; what each was trained on is in its card
(``network.read(path(task))``) and in ``docs/learned.md``. They run on NumPy alone.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from asv_env.params import TASKS, EnvParams
from baselines import network
from baselines.network import NetworkPolicy

FOLDER = Path(__file__).parent / "policies"


def path(task: str) -> Path:
    """Of the policy file of a task."""
    return FOLDER / f"{task}{network.SUFFIX}"


def learned(params: EnvParams) -> NetworkPolicy:
    """The learned policy of the environment's task.

    Raises:
        ValueError: the environment takes thruster actions.
    """
    return network.load(path(params.task.name), params)


def fingerprint() -> str:
    """A digest of all of them."""
    files = [path(task).read_bytes() for task in TASKS]
    return hashlib.sha256(b"".join(files)).hexdigest()[:16]
