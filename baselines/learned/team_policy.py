"""One policy for every team, hull and task: a network of sets that all boats share, and its file.

A file is an NPZ of the network's weights, and of ``policy``, a JSON text: ``format`` is ``FORMAT``,
and ``model_card`` tells where the policy comes from, in any form. Nothing in it is code.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.files import write
from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Observation, Sensed
from baselines.learned import npz
from baselines.learned.set_network import SetNetwork, Weights, check
from baselines.learned.team_view import TeamView, ViewMemory

FORMAT = "asv-env team policy 1"  #: grows with what boats see and with the network


class TeamPolicy:
    """Decides for each boat by what it sees, see ``TeamView``.

    Args:
        weights: those of a ``SetNetwork``.
        params: parameters of the environment; ``action_mode`` must be "tracking".

    Raises:
        ValueError: the environment takes thruster actions, or the weights do not fit.
    """

    def __init__(self, weights: Weights, params: EnvParams) -> None:
        self._network, self._view = SetNetwork(weights), TeamView(params)

    def act(
        self, sensed: Sensed, observation: Observation, memory: ViewMemory | None, fresh: Bool
    ) -> tuple[Action, ViewMemory]:
        """See ``Policy.act``."""
        seen, memory = self._view.observe(sensed, memory, fresh)
        return self._view.command(self._network(seen), memory), memory


def save(path: Path, weights: Weights, model_card: Mapping[str, Any]) -> None:
    """Writes a file, all at once; see ``asv_env.files.write``.

    Args:
        path: name of the file.
        weights: those of a ``SetNetwork``.
        model_card: where the policy comes from; anything that JSON can express.
    """
    check(weights)
    arrays: dict[str, Any] = {name: np.asarray(w, np.float32) for name, w in weights.items()}
    arrays["policy"] = np.array(json.dumps({"format": FORMAT, "model_card": model_card}))
    write(path, lambda part: np.savez_compressed(part, **arrays))


def read(path: Path) -> tuple[Weights, dict[str, Any]]:
    """Returns the weights of a file, and its model card.

    Raises:
        ValueError: it is not such a file, or of another format.
        FileNotFoundError: there is no such file.
    """
    try:
        arrays = npz.read(path)
        policy = json.loads(str(arrays.pop("policy")))
        if policy["format"] != FORMAT:
            raise ValueError(f"its format is {policy['format']!r}")
        check(arrays)
        return arrays, dict(policy["model_card"])
    except (KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
        reason = " ".join(str(error).split())
        message = f"{path} is not a policy file of the format {FORMAT!r}: {reason}"
        raise ValueError(message) from error


def is_team_policy(path: Path) -> bool:
    """Returns whether a file claims to be one of this kind, of any version."""
    try:
        policy = json.loads(str(npz.read(path, ["policy"])["policy"]))
        return str(policy["format"]).startswith(FORMAT.rstrip("0123456789"))
    except (KeyError, ValueError, TypeError, RecursionError):
        return False
