"""What the faces share: how they begin, are refused and drawn, their spaces and their infos."""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Collection, Iterable, Mapping
from typing import Any, NoReturn

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from asv_env.checks import choice
from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.sensing import observation
from asv_env.simulation import WORLDS_PER_SPACE, InitialStates, Simulation
from asv_env.tasks import starts
from asv_env.types import Bool, Float

RENDER_MODES = ("human", "rgb_array")
RENDER_FPS = 10
"""Frames a second at the default control rate; every environment states its own rate."""


class ResetNeededError(gymnasium.error.ResetNeeded, RuntimeError, ValueError):
    """Something was asked for that has to wait for a reset."""


class ClosedError(gymnasium.error.ClosedEnvironmentError, RuntimeError, ValueError):
    """Something was asked of an environment that has been closed."""


class Adapter:
    """A simulation behind an interface: its life, its pictures.

    Attributes:
        params: all parameters of the environment.
        simulation: the environment itself; scripted policies read its ``sensed``.
        render_mode: "human", "rgb_array" or None.
    """

    params: EnvParams
    simulation: Simulation
    render_mode: str | None
    _viewer: Any = None
    _NEW, _RUNNING, _OVER, _CLOSED = "new", "running", "over", "closed"

    def _open(
        self,
        render_mode: str | None,
        options: Mapping[str, Any],
        num_worlds: int = 1,
        worlds_per_space: int = WORLDS_PER_SPACE,
        initial_states: InitialStates = starts.sample,
    ) -> None:
        """Makes the simulation from names and options; see ``presets.make_params``."""
        if render_mode is not None:
            choice("render_mode", render_mode, RENDER_MODES)
        self.render_mode = render_mode
        self.params = make_params(**options)
        self.simulation = Simulation(self.params, num_worlds, worlds_per_space, initial_states)
        self._life = self._NEW

    def _metadata(self, **entries: Any) -> dict[str, Any]:
        fps = self.params.clock.control
        return {"render_modes": list(RENDER_MODES), "render_fps": fps, **entries}

    def _check_open(self, what: str) -> None:
        if self._life == self._CLOSED:
            self._refuse(what)

    def _check_begun(self, what: str) -> None:
        if self._life in (self._NEW, self._CLOSED):
            self._refuse(what)

    def _check_running(self, what: str) -> None:
        if self._life != self._RUNNING:
            self._refuse(what)

    def _refuse(self, what: str) -> NoReturn:
        if self._life == self._CLOSED:
            raise ClosedError(f"{what}: the environment is closed; make a new one")
        why = "the episode is over" if self._life == self._OVER else "there was no reset yet"
        raise ResetNeededError(f"{what}: {why}; call reset first")

    def _draw(self, world: int = 0) -> Any:
        """A frame (H, W, 3) uint8 of a world with "rgb_array"; with "human" it goes to a window."""
        self._check_begun("render")
        if self.render_mode is None:
            gymnasium.logger.warn(
                "render: nothing to draw without a render_mode; make the environment with "
                "render_mode='rgb_array' or 'human'"
            )
            return None
        if self._viewer is None:
            from asv_env.render.viewer import Viewer  # drawing is an extra

            self._viewer = Viewer(self.params, self.render_mode)
        return self._viewer.draw(self.simulation.state, world)

    def _show(self) -> None:
        """Keeps the window up to date, if there is one."""
        if self.render_mode == "human":
            self._draw()

    def _close(self) -> None:
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
        self._life = self._CLOSED


def boat_spaces(*leading: int) -> tuple[Box[np.float32], Box[np.float32]]:
    """Spaces of observations (..., K) and of actions (..., 2) with these leading axes."""
    high = np.broadcast_to(observation.BOUND, (*leading, len(observation.BOUND)))
    return Box(-high, high, dtype=np.float32), Box(-1.0, 1.0, (*leading, 2), dtype=np.float32)


def goal_option(options: Mapping[str, Any] | None, others: Collection[str] = ()) -> Any:
    """The goal that ``reset(options=...)`` asks for, or None.

    Unknown options warn only, because PettingZoo's own test sends one.

    Raises:
        TypeError: options that are not a mapping.
    """
    if options is None:
        return None
    if not isinstance(options, Mapping):
        raise TypeError(
            f"options = {options!r}: give a mapping such as {{'goal': [x, y, heading]}}"
        )
    known = ["goal", *others]
    for name in options:
        if name not in known:
            near = difflib.get_close_matches(str(name), known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(map(repr, known))}"
            warnings.warn(f"reset option {name!r} is unknown and ignored; {hint}", stacklevel=3)
    return options.get("goal")


def team_mean(values: Float) -> Float:
    """Mean (W,) over the boats of values (W, A) or (W, 1).

    One formula for every face, so that they agree to the bit.
    """
    mean: Float = np.add.reduce(values, axis=1) / values.shape[1]
    return mean


def joint_terms(terms: Mapping[str, Float]) -> dict[str, float]:
    """Reward terms of a single world, team means, as Python floats."""
    return {
        name: value.item() if value.size == 1 else team_mean(value).item()
        for name, value in terms.items()
    }


def boat_terms(terms: Mapping[str, Float], team: int) -> list[dict[str, float]]:
    """Reward terms of every boat of a single world, as Python floats."""
    values = {name: value[0].tolist() for name, value in terms.items()}
    return [
        {name: value[boat] if len(value) > 1 else value[0] for name, value in values.items()}
        for boat in range(team)
    ]


def summaries(simulation: Simulation, worlds: Iterable[int]) -> list[dict[str, Any]]:
    """What ``info`` says at the end of the episodes of some worlds, as Python scalars."""
    summary = simulation.summary()
    return [{name: value[world].item() for name, value in summary.items()} for world in worlds]


def masked(values: Mapping[str, Any], mask: Bool) -> dict[str, Any]:
    """Values (W,) of some worlds as Gymnasium's vector environments tell them.

    Args:
        values: arrays, or mappings of arrays, by name.
        mask: (W,) worlds that have them.

    Returns:
        Each value, zero where there is none, and its mask under the name with "_" before it.
    """
    infos: dict[str, Any] = {}
    everywhere = mask.all()
    for name, value in values.items():
        if isinstance(value, Mapping):
            infos[name] = masked(value, mask)
        elif everywhere:
            infos[name] = value.copy()
        else:
            infos[name] = np.where(mask, value, value.dtype.type(0))
        infos[f"_{name}"] = mask.copy()
    return infos
