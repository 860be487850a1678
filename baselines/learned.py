"""The learned policies that are part of this package: ``learned``, one file a task.

They were trained by ``train``; what each was trained on, how well it does and where it fails is on
its card, in ``weights/README.md``.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from asv_env.params import TASKS, EnvParams
from baselines import network
from baselines.network import NetworkPolicy

FOLDER = Path(__file__).parent / "weights"
"""Where the policy files are."""


def file(task: str) -> Path:
    """The policy file of a task."""
    return FOLDER / f"{task}{network.SUFFIX}"


def learned_policy(params: EnvParams) -> NetworkPolicy:
    """The policy that was trained for a task, for an environment.

    Args:
        params: of the environment.

    Raises:
        ValueError: actions or observations of another kind than those with which it was trained.
    """
    return network.load(file(params.task.name), params)


def fingerprint() -> str:
    """A digest of all policy files."""
    digest = hashlib.sha256()
    for task in TASKS:
        digest.update(file(task).read_bytes())
    return digest.hexdigest()[:16]
