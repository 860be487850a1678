"""Policies of several networks in a file: one approaches the vessel, others push it.

Each of them has a job that is learned in minutes to hours, and can be trained and watched alone.
Which of them acts is decided as in the scripted policy: the team approaches until the vessel is in
closure, then it pushes; when the goal is not reached in time, or a boat is lost, it begins again,
and then the next network pushes. A team size may have networks of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.geometry import plane
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.tasks import TASKS
from asv_env.types import Action, Bool, Int, Observation, Sensed
from baselines.learned import network
from baselines.learned.network import About, Held, Layers, NetworkPolicy
from baselines.mirror import SideAway, SideMemory, goal_across
from baselines.policy import Policy

FORMAT = "asv-env phases 1"
BEHIND = 0.1
"""How far on the side of the team a goal must lie for it to go round, lengths of the vessel."""
FAR = 2.0
"""Distance from the vessel at which a boat is lost while others push, lengths of the vessel."""


@dataclass(frozen=True)
class Phase:
    """One network and its job.

    Attributes:
        layers: of the network.
        about: what it was made for.
        patience: time after which its attempt is given up, s for a vessel of 0.40 m.
        boats: the team size that has this network for itself; None serves all that have none.
    """

    layers: Layers
    about: About
    patience: float = float("inf")
    boats: int | None = None


@dataclass
class PhaseMemory:
    """What a team remembers.

    Attributes:
        sides: from which sides the teams push.
        attempt: (W,) number of the attempt, from 0.
        acts: (W,) number of the network that acts; 0 approaches.
        ticks: (W,) for which it has acted.
        held: of each network.
    """

    sides: SideMemory
    attempt: Int
    acts: Int
    ticks: Int
    held: Sequence[Held | None]


class PhasedPolicy:
    """Approaches from the side of the vessel away from the goal, then pushes.

    Args:
        phases: the network that approaches, then those that push: the first one in the first
            attempt, and so on; the last one in all that are left. Only those count that serve
            the environment's team.
        params: of the environment.

    Raises:
        ValueError: they were made for other actions, other observations or other teams.
    """

    def __init__(self, phases: Sequence[Phase], params: EnvParams) -> None:
        phases = serving(phases, params.num_boats)
        self._networks = [
            NetworkPolicy(one.layers, replace(one.about, tasks=tuple(TASKS), mirrors=False), params)
            for one in phases
        ]
        self._params = params
        self._away = SideAway(params)
        scale = params.vessel.length / NOMINAL_LENGTH * params.clock.control
        self._behind = BEHIND * params.vessel.length
        self._patience = np.array([one.patience * scale for one in phases])

    def act(
        self, sensed: Sensed, observation: Observation, memory: PhaseMemory | None, fresh: Bool
    ) -> tuple[Action, PhaseMemory]:
        """See ``Policy.act``."""
        if memory is None:
            none = np.zeros(len(fresh), dtype=np.int64)
            memory = PhaseMemory(None, none, none, none, [None] * len(self._networks))  # type: ignore[arg-type]
        ticks = memory.ticks + 1
        late = ticks >= self._patience[memory.acts]
        gives_up = ~fresh & (late | ((memory.acts > 0) & self._lost(sensed)))
        begins = fresh | gives_up
        attempt = np.where(fresh, 0, memory.attempt + gives_up)
        seen, sides = self._away.see(sensed, memory.sides, begins)
        misses = seen.closed & (memory.acts == 0) & ~begins & (goal_across(seen) > self._behind)
        if misses.any():
            begins |= misses
            seen, sides = self._away.see(sensed, sides, begins)
        pushes = seen.closed | ((memory.acts > 0) & ~begins)
        acts = np.where(pushes, 1 + np.minimum(attempt, len(self._networks) - 2), 0)
        changes = begins | (acts != memory.acts)
        observed = network.observed(seen, self._params)
        action = np.zeros((*sensed.slot.shape, 2), dtype=np.float32)
        held = []
        for number, one in enumerate(self._networks):
            says, holds = one.act(seen, observed, memory.held[number], changes)
            action = np.where((acts == number)[:, None, None], says, action)
            held.append(holds)
        action[..., 1] *= sides.side[:, None].astype(np.float32)
        ticks = np.where(changes, 0, ticks)
        return action, PhaseMemory(sides, attempt, acts, ticks, held)

    def _lost(self, sensed: Sensed) -> Bool:
        """(W,) whether a boat that works is far from the vessel."""
        place = plane(sensed.estimate)
        far = np.abs(place[:, 1:] - place[:, :1]) > FAR * self._params.vessel.length
        lost: Bool = np.logical_or.reduce(far & sensed.working, axis=1)
        return lost


def serving(phases: Sequence[Phase], num_boats: int) -> Sequence[Phase]:
    """Those for a team: its own, or those of all teams that have none.

    Raises:
        ValueError: there are fewer than two.
    """
    own = [one for one in phases if one.boats == num_boats]
    own = own or [one for one in phases if one.boats is None]
    if len(own) < 2:
        raise ValueError(
            f"{len(own)} networks for a team of {num_boats}: there must be two at least, one that "
            "approaches and one that pushes"
        )
    return own


def save(path: Path, phases: Sequence[Phase], card: dict[str, Any]) -> None:
    """Writes a policy file (``.npz``) of several networks.

    Args:
        path: of the file.
        phases: the networks, see ``PhasedPolicy``.
        card: where it comes from; free of form.
    """
    told = [
        {"about": asdict(one.about), "patience": one.patience, "boats": one.boats} for one in phases
    ]
    weights: dict[str, Any] = {}
    for number, one in enumerate(phases):
        weights |= network.arrays(one.layers, f"phase_{number}_")
    about = {"format": FORMAT, "phases": told, "card": card}
    np.savez_compressed(path, **network.told(about), **weights)


def read(path: Path) -> tuple[list[Phase], dict[str, Any]]:
    """The networks of a policy file, and its card.

    Raises:
        ValueError: it is not such a file, or of another format.
        FileNotFoundError: there is none.
    """
    with network.contents(path, FORMAT) as (about, file):
        phases = [
            Phase(
                network.layers_in(file, f"phase_{number}_"),
                network.about_of(one["about"]),
                one["patience"],
                one.get("boats"),
            )
            for number, one in enumerate(about["phases"])
        ]
        return phases, about["card"]


def holds_several(path: Path) -> bool:
    """Whether a policy file is one of several networks.

    Raises:
        ValueError: it is not a policy file.
        FileNotFoundError: there is none.
    """
    with network.contents(path, network.FORMAT, FORMAT) as (about, _):
        several: bool = about.get("format") == FORMAT
        return several


def load(path: Path, params: EnvParams) -> Policy:
    """The policy of a file, of one network or of several, for an environment.

    Raises:
        ValueError: not a policy file, or a policy for something else.
        FileNotFoundError: there is none.
    """
    if not holds_several(path):
        return network.load(path, params)
    phases, _ = read(path)
    try:
        return PhasedPolicy(phases, params)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
