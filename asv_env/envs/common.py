"""What the adapters share: life cycle, copies, rendering, spaces, options of a reset."""

import math
import warnings
from collections.abc import Collection, Mapping
from copy import deepcopy
from enum import Enum
from numbers import Integral
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space

from asv_env.checks import choice, nearest, plain
from asv_env.envs.gym_spec import completed
from asv_env.params import DISCRETE_ACTIONS, EnvParams
from asv_env.render import MODES
from asv_env.sensing import observation
from asv_env.simulation import Simulation
from asv_env.types import Action, Observation, TimeStep


class ResetNeededError(gymnasium.error.ResetNeeded, RuntimeError, ValueError):
    """The call has to wait for a reset."""


class ClosedError(gymnasium.error.ClosedEnvironmentError, RuntimeError, ValueError):
    """The environment has been closed."""


class Stage(Enum):
    """Stage in the life of an environment; the value tells why a call is refused."""

    NEW = "there was no reset yet"
    RUNNING = "an episode is running"
    OVER = "the episode is over"
    CLOSED = "the environment is closed"


class Adapter:
    """A simulation behind an environment API.

    A copy, by ``copy.deepcopy`` or ``pickle``, continues to the bit like the original. Windows and
    drawn trails are not copied; a copy of an environment with ``render_mode="human"`` has
    ``render_mode=None``.
    """

    params: EnvParams  #: all parameters of the environment
    simulation: Simulation  #: the environment itself; scripted policies read its ``sensed``
    render_mode: str | None  #: "human", "rgb_array" or None
    metadata: dict[str, Any] = {"render_modes": list(MODES), "render_fps": 10}
    _viewer: Any = None
    _spec: Any = None

    def _open(self, simulation: Simulation, render_mode: str | None, **metadata: Any) -> None:
        """Begins the life of an environment."""
        if render_mode is not None:
            choice("render_mode", render_mode, MODES)
        self.simulation, self.render_mode = simulation, render_mode
        self.params = simulation.params
        own = {"render_fps": self.params.clock.control, **metadata}
        self.metadata = deepcopy(self.metadata) | own
        self._stage = Stage.NEW

    def __getstate__(self) -> dict[str, Any]:
        """Returns what a copy consists of: all but a window and what has been drawn."""
        state = {name: value for name, value in vars(self).items() if name != "_viewer"}
        if self.render_mode == "human":
            state["render_mode"] = None
        return state

    @property
    def spec(self) -> Any:
        """The ``EnvSpec`` from which Gymnasium made the environment, or None."""
        return self._spec

    @spec.setter
    def spec(self, spec: Any) -> None:
        self._spec = completed(spec, self.params.time_limit_ticks)

    def _boat_spaces(self, *team: int, flat: bool = False) -> tuple[Space[Any], Space[Any]]:
        """Returns the spaces of observations (..., K) and actions (..., 2), or (...) if discrete.

        Args:
            *team: leading axes, such as the number of boats.
            flat: whether all axes become one.
        """
        bound = observation.bounds(observation.features(self.params))
        high = np.array(np.broadcast_to(bound, (*team, len(bound))))
        shape = (*team, *self._action_shape)
        if flat:
            high, shape = high.reshape(-1), (math.prod(shape),)
        seen, choices = Box(-high, high, dtype=np.float32), len(DISCRETE_ACTIONS)
        if self.params.action_mode != "discrete":
            return seen, Box(-1.0, 1.0, shape, dtype=np.float32)
        return seen, MultiDiscrete(np.full(shape, choices)) if shape else Discrete(choices)

    @property
    def _action_shape(self) -> tuple[int, ...]:
        """Shape of a boat's action."""
        return () if self.params.action_mode == "discrete" else (2,)

    def _require(self, call: str, *stages: Stage) -> None:
        """Refuses a call in any other stage than these: ClosedError, ResetNeededError."""
        if self._stage in stages:
            return
        if self._stage is Stage.CLOSED:
            raise ClosedError(f"{call}: {self._stage.value}; make a new one")
        raise ResetNeededError(f"{call}: {self._stage.value}; call reset first")

    def _begin(self, seed: int | None, goal: Any) -> Observation:
        """Begins an episode of an only world and returns its observation (A, K)."""
        self._require("reset", Stage.NEW, Stage.RUNNING, Stage.OVER)
        observations = self.simulation.reset(seeds=[seed], goal=goal)
        self._stage = Stage.RUNNING
        self._show()
        return observations[0]

    def _advance(self, action: Action) -> tuple[TimeStep, bool, bool]:
        """Advances an only world under its boats' actions; returns step, terminated, truncated."""
        step = self.simulation.step(action[None])
        terminated, truncated = step.ending.terminated.item(), step.ending.truncated.item()
        if terminated or truncated:
            self._stage = Stage.OVER
        self._show()
        return step, terminated, truncated

    def render(self) -> Any:
        """Returns a frame (H, W, 3) uint8 with "rgb_array"; "human" needs no call."""
        return self._frame()

    def close(self) -> None:
        """Closes the window, if there is one; the environment cannot be used any more."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
        self._stage = Stage.CLOSED

    def _frame(self, world: int = 0) -> Any:
        """Returns a frame of a world; with "human" it goes to the window instead."""
        self._require("render", Stage.RUNNING, Stage.OVER)
        if self.render_mode is None:
            gymnasium.logger.warn("render: give render_mode='rgb_array' or 'human' to see anything")
            return None
        if self._viewer is None:
            from asv_env.render.viewer import Viewer  # drawing is an extra

            self._viewer = Viewer(self.params, self.render_mode)
        return self._viewer.draw(self.simulation.state, world)

    def _show(self) -> None:
        """Keeps the window up to date, if there is one."""
        if self.render_mode == "human":
            self._frame()


def world_seeds(seed: Any, num_worlds: int) -> list[Any]:
    """Returns a seed for each world: from one number, world i gets ``seed + i``.

    Anything else than a number is the seed of every world: None, or what the simulation refuses.
    """
    seed = plain(seed)
    if isinstance(seed, Integral) and not isinstance(seed, bool):
        return [seed + world for world in range(num_worlds)]
    return [seed] * num_worlds


def goal_option(options: Mapping[str, Any] | None, others: Collection[str] = ()) -> Any:
    """Returns the goal that ``reset(options=...)`` asks for, or None.

    Unknown options only warn, because PettingZoo's own test sends one.

    Raises:
        TypeError: options that are not a mapping.
    """
    if options is None:
        return None
    if not isinstance(options, Mapping):
        raise TypeError(f"options = {options!r}: give a mapping like {{'goal': [x, y, heading]}}")
    known = ["goal", *others]
    for name in options:
        if name not in known:
            hint = nearest(name, known) or f" Known: {', '.join(map(repr, known))}."
            warnings.warn(f"reset option {name!r} is unknown and ignored.{hint}", stacklevel=4)
    return options.get("goal")
