"""The learned policies that are part of this package: ``learned``.

``train`` made them. Their model cards are in ``learned/weights/README.md``; ``docs/learned.md``
describes what they do and where they fail.
"""

import hashlib
from pathlib import Path

from asv_env.params import EnvParams
from asv_env.tasks.task import Task
from baselines.learned import policy_file
from baselines.policy import Policy

FOLDER = Path(__file__).parent / "weights"  #: folder of the policy files


def file_for(task: Task) -> Path:
    """Returns the policy file for a task: of all tasks with a goal it is the same."""
    return FOLDER / ("transport.npz" if task.has_goal else "approach.npz")


def learned_policy(params: EnvParams) -> Policy:
    """Returns the learned policy for the task of an environment; see ``policy_file.load``."""
    return policy_file.load(file_for(params.definition), params)


def fingerprint() -> str:
    """Returns a digest of all policy files."""
    files = sorted(FOLDER.glob(f"*{policy_file.SUFFIX}"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]
