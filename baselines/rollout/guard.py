"""One guard round a policy: whatever it does wrong fails the episode in which it does so.

Making the policy, its decision, what it returns, and the text of its errors are all foreign code.
Only Ctrl-C and other signals that end a command get through.
"""

import signal
from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.text import described
from asv_env.types import Action, Bool, Observation, Sensed
from baselines.distributed import distributed
from baselines.policy import MakePolicy, Policy, decision
from baselines.rollout.process_state import Terminated


class PolicyError(Exception):
    """A policy failed while it decided for several worlds, nobody knows in which of them."""


class Guard:
    """A policy whose failures and useless actions become zeros, reported in ``errors``, by world.

    The policy is made at its first decision, and again after a failure: nothing is left of what
    it kept of a failed episode.
    """

    def __init__(self, make_policy: MakePolicy, params: EnvParams) -> None:
        self._make, self._params = make_policy, params
        self._policy: Policy | None = None
        self.errors: dict[int, str] = {}

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``.

        Raises:
            PolicyError: the policy failed, and there are several worlds.
        """
        shape = (len(fresh), sensed.slot.shape[1], 2)
        try:
            if self._policy is None:
                self._policy = distributed(self._make(self._params), self._params)
            action, memory = decision(self._policy.act(sensed, observation, memory, fresh), shape)
        except BaseException as error:
            if is_ctrl_c(error):
                raise
            self._policy = None
            text = described(error)
            if len(fresh) > 1:
                raise PolicyError(text) from None
            self.errors = {0: text}
            return np.zeros(shape, dtype=np.float32), None
        views = len(sensed.tick) // len(fresh)
        finite = np.asarray(np.isfinite(action).all(axis=(1, 2)))
        self.errors = {
            world: f"action not finite at tick {sensed.tick[world * views]}"
            for world in map(int, np.flatnonzero(~finite))
        }
        return np.where(finite[:, None, None], action, np.float32(0.0)), memory


def is_ctrl_c(error: BaseException) -> bool:
    """Returns whether an error is the user's Ctrl-C or another signal that ends the command.

    Otherwise it is the policy's. Workers ignore Ctrl-C, and so do commands that a shell runs in the
    background, which hear SIGTERM nevertheless.
    """
    heard = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN
    return isinstance(error, Terminated) or (isinstance(error, KeyboardInterrupt) and heard)
