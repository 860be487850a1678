"""What an initial state must be, whoever samples it: numbers with which an episode can begin."""

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from asv_env.compiled import compiled
from asv_env.geometry import wrapped
from asv_env.params import EnvParams
from asv_env.params.obstacle_params import grouping, rows, sampled
from asv_env.text import shown
from asv_env.types import Float, InitialState

RANGES = {
    "motion": (-1e6, 1e6),
    "goal": (-1e6, 1e6),
    "side": (-1.0, 1.0),
    "thrust_gain": (0.0, 1e3),
    "lag": (1e-9, 1e3),
    "drag_gain": (0.0, 1e3),
    "mass_gain": (1e-3, 1e3),
    "friction": (0.0, 1e2),
    "failure_tick": (-1, 1e15),
    "boat_size": (0.1, 10.0),
    "obstacle": (-1e6, 1e6),
}  #: smallest and largest value of each field


def checked(start: Any, params: EnvParams, rng: np.random.Generator) -> InitialState:
    """Returns an initial state with arrays of its own, headings wrapped.

    Where it has no obstacles, those of the parameters are taken, or sampled.

    Raises:
        TypeError: something else than an ``InitialState``.
        ValueError: an array of another shape, or numbers that are not finite or out of range.
    """
    if not isinstance(start, InitialState):
        raise TypeError(f"initial states: {shown(start)}: return an asv_env.types.InitialState")
    fields = dict(vars(start))
    if start.obstacle is None:
        fields["obstacle"] = _obstacles(start, params, rng)
    if start.boat_size is None:
        fields["boat_size"] = np.ones(params.num_boats)
    shapes, low, high = _limits(params.num_boats, int(grouping(params).groups[-1]))
    given = {name: _numbers(fields[name], shapes[name]) for name in RANGES}
    flat = np.concatenate([array.reshape(-1) for array in given.values()])
    fits = all(array.shape == shapes[name] for name, array in given.items())
    if not fits or not ((flat >= low) & (flat <= high)).all():
        _refuse(fields, given, shapes)
    values: dict[str, Any] = {
        name: array if shapes[name] else array.item() for name, array in given.items()
    }
    if abs(values["side"]) != 1.0:
        raise ValueError(f"initial states: side = {values['side']:g}: must be 1 or -1")
    if (values["failure_tick"] >= 0).all():
        raise ValueError("initial states: failure_tick: fewer than all boats may fail")
    if (values["obstacle"][:, 4] < 0.0).any():
        raise ValueError("initial states: obstacle: a radius is negative; give 0 or more")
    _wrap_headings(values["motion"], values["goal"])
    values["failure_tick"] = values["failure_tick"].astype(np.int64)
    return InitialState(**values)


@compiled
def _wrap_headings(motion: Float, goal: Float) -> None:
    for body in range(len(motion)):
        motion[body, 2] = wrapped(motion[body, 2])
    goal[2] = wrapped(goal[2])


def _numbers(given: Any, shape: tuple[int, ...]) -> Float:
    """Returns an array of numbers; NaN in place of what is none."""
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.full(shape, np.nan)


def _obstacles(start: InitialState, params: EnvParams, rng: np.random.Generator) -> Float:
    """Returns the obstacles (M, 5) of an initial state that names none."""
    shapes = params.obstacles
    if not isinstance(shapes, tuple):
        x, y, heading = np.array(start.goal, dtype=np.float64).tolist()
        shapes = sampled(params, rng, (x, y, heading), start.side)
    return rows(params, shapes)


@cache
def _limits(team: int, rows: int) -> tuple[dict[str, tuple[int, ...]], Float, Float]:
    """Returns the shapes of the fields by name; and the bounds of all numbers, in their order."""
    own = {"motion": (1 + team, 6), "goal": (3,), "thrust_gain": (team, 2)}
    own |= {"drag_gain": (1 + team,), "mass_gain": (1 + team,), "failure_tick": (team,)}
    own |= {"boat_size": (team,), "obstacle": (rows, 5)}
    shapes = {name: own.get(name, ()) for name in RANGES}
    bounds = [np.full((math.prod(shapes[name]), 2), RANGES[name]) for name in RANGES]
    low, high = np.concatenate(bounds).T
    return shapes, low, high


def _refuse(
    fields: Mapping[str, Any], given: Mapping[str, Float], shapes: Mapping[str, tuple[int, ...]]
) -> None:
    """Refuses the first field that is of another shape or has a number out of range."""
    for name, array in given.items():
        (low, high), shape = RANGES[name], shapes[name]
        if array.shape != shape or not ((array >= low) & (array <= high)).all():
            raise ValueError(
                f"initial states: {name} = {shown(fields[name])}: must be of shape "
                f"{shape}, all finite and in [{low:g}, {high:g}]"
            )
