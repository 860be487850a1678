"""Checks of what a simulation is given: worlds to reset, seeds, actions."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from asv_env.params import DISCRETE_ACTIONS
from asv_env.text import shown
from asv_env.types import Float, Int

COMMANDS = np.array(DISCRETE_ACTIONS)  #: tracking actions (n, 2) by number


def worlds_to_reset(mask: Any, num_worlds: int) -> Int:
    """Returns the numbers of the worlds in a mask (W,) bool, of all with None.

    Raises:
        ValueError: another shape or type.
    """
    if mask is None:
        return np.arange(num_worlds)
    given = np.asarray(mask)
    if given.shape != (num_worlds,) or given.dtype != np.bool_:
        raise ValueError(
            f"mask of shape {given.shape} and type {given.dtype}: must be bool of shape "
            f"({num_worlds},)"
        )
    return np.flatnonzero(given)


def checked_seeds(seeds: Any, count: int) -> list[int | None]:
    """Returns a seed or None for each of ``count`` worlds; None stands for as many of them.

    Raises:
        ValueError: another number of seeds, or one that is no whole number of at least 0.
    """
    if seeds is None:
        return [None] * count
    if isinstance(seeds, str | bytes) or not isinstance(seeds, Iterable):
        raise ValueError(f"seeds = {shown(seeds)}: give a sequence with one for each world")
    given = list(seeds)
    if len(given) != count:
        raise ValueError(f"{len(given)} seeds for {count} worlds: give one for each")
    for seed in given:
        fine = isinstance(seed, int | np.integer) and not isinstance(seed, bool) and seed >= 0
        if seed is not None and not fine:
            raise ValueError(f"seed = {shown(seed)}: must be a whole number of at least 0 or None")
    return [None if seed is None else int(seed) for seed in given]


def continuous_action(action: Any, team: tuple[int, ...]) -> Float:
    """Returns actions (W, A, 2) as float64, clipped to [-1, 1].

    Args:
        action: those that were given.
        team: (W, A).

    Raises:
        TypeError: not real numbers.
        ValueError: another shape, or not finite.
    """
    command = np.asarray(_real(action, "biufO", (*team, 2)), dtype=np.float64, order="C")
    if not np.isfinite(command).all():
        world, boat, _ = np.argwhere(~np.isfinite(command))[0]
        raise ValueError(
            f"action {command[world, boat]} of boat {boat} in world {world}: must be finite; "
            "check the policy for NaN"
        )
    return np.minimum(np.maximum(command, -1.0), 1.0)


def discrete_action(action: Any, team: tuple[int, ...]) -> Float:
    """Returns the tracking actions (W, A, 2) of numbers (W, A) of ``DISCRETE_ACTIONS``.

    Raises:
        TypeError: not whole numbers.
        ValueError: another shape, or there is no action of this number.
    """
    number = _real(action, "iu", team)
    unknown = (number < 0) | (number >= len(COMMANDS))
    if unknown.any():
        world, boat = np.argwhere(unknown)[0]
        raise ValueError(
            f"action {number[world, boat]} of boat {boat} in world {world}: there are "
            f"{len(COMMANDS)} discrete actions, from 0 to {len(COMMANDS) - 1}"
        )
    return COMMANDS[number]


CHECKED_ACTION = {
    "tracking": continuous_action,
    "thrusters": continuous_action,
    "discrete": discrete_action,
}
"""Functions that check actions and return commands (W, A, 2), by ``action_mode``."""


def _real(action: Any, kinds: str, shape: tuple[int, ...]) -> np.ndarray:
    """Returns actions as an array of a shape, of one of some kinds of numbers."""
    what = "whole numbers" if kinds == "iu" else "real numbers"
    try:
        given = np.asarray(action)
        if given.dtype.kind not in kinds:
            raise TypeError(f"they are of type {given.dtype}")
        if given.dtype.kind == "O":
            given = given.astype(np.float64)
    except Exception as error:  # whatever another library's array raises
        kind = type(action).__name__
        raise TypeError(f"action of type {kind}: give {what} of shape {shape}") from error
    if given.shape != shape:
        raise ValueError(f"action of shape {given.shape}: must be {shape}")
    return given
