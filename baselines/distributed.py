"""Distributed execution: each boat runs the whole policy on what it knows itself.

With ``SensorParams.shared=False`` every boat has a row of its own in ``Sensed``. To the policy
these rows are worlds: it decides for all boats of each, and a boat does what is decided for it in
its own.
"""

from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.sensing import observation as observing
from asv_env.types import Action, Bool, Observation, Sensed
from baselines.policy import Policy, decision


def distributed(policy: Policy, params: EnvParams) -> Policy:
    """Returns a policy that acts in an environment as a team of boats does, each by its own row.

    Where all boats share what they know, it is the policy itself.
    """
    return policy if params.sensors.shared else Distributed(policy, params)


class Distributed:
    """A policy of which every boat runs a copy; the memory holds those of all copies."""

    def __init__(self, policy: Policy, params: EnvParams) -> None:
        self._policy, self._params = policy, params
        self._features = observing.features(params)

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``; ``sensed`` has a row for each boat, all else is of the worlds."""
        del observation  # Each boat's own alone, and a copy of the policy decides for all of them.
        views, team = sensed.slot.shape
        observed = observing.observe(self._features, sensed, self._params)
        given = sensed, observed, memory, np.repeat(fresh, team)
        action, memory = decision(self._policy.act(*given), (views, team, 2))
        return observing.own_rows(action), memory
