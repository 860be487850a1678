"""The learned policies that are part of this package: ``learned``.

They were trained by ``train``; what each was trained on is on its card, in
``learned/weights/README.md``, how well it does and where it fails in ``docs/learned.md``.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from asv_env.params import EnvParams
from baselines.learned import policy_file
from baselines.policy import Policy

FOLDER = Path(__file__).parent / "weights"
"""Where the policy files are."""
FILES = {"approach": "approach.npz", "push": "transport.npz", "transport": "transport.npz"}
"""By task."""


def learned_policy(params: EnvParams) -> Policy:
    """The policy that was trained for a task, for an environment.

    Args:
        params: of the environment.

    Raises:
        ValueError: actions or observations of another kind than those with which it was trained.
    """
    return policy_file.load(FOLDER / FILES[params.task.name], params)


def fingerprint() -> str:
    """A digest of all policy files."""
    digest = hashlib.sha256()
    for name in sorted(set(FILES.values())):
        digest.update((FOLDER / name).read_bytes())
    return digest.hexdigest()[:16]
