"""What an initial state must be, whoever samples it: numbers with which an episode can begin."""

from typing import Any

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.text import shown
from asv_env.types import InitialState

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
}  #: smallest and largest value of each field


def checked(start: Any, params: EnvParams) -> InitialState:
    """Returns an initial state with arrays of its own, headings wrapped.

    Raises:
        TypeError: something else than an ``InitialState``.
        ValueError: an array of another shape, or numbers that are not finite or out of range.
    """
    if not isinstance(start, InitialState):
        raise TypeError(f"initial states: {shown(start)}: return an asv_env.types.InitialState")
    team = params.num_boats
    shapes = {"motion": (1 + team, 6), "goal": (3,), "thrust_gain": (team, 2)}
    shapes |= {"drag_gain": (1 + team,), "mass_gain": (1 + team,), "failure_tick": (team,)}
    values: dict[str, Any] = {}
    for name, (low, high) in RANGES.items():
        given, shape = getattr(start, name), shapes.get(name, ())
        try:
            array = np.array(given, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.full(shape, np.nan)
        if array.shape != shape or not ((array >= low) & (array <= high)).all():
            raise ValueError(
                f"initial states: {name} = {shown(given)}: must be of shape {shape}, all finite "
                f"and in [{low:g}, {high:g}]"
            )
        values[name] = array if shape else float(array)
    if abs(values["side"]) != 1.0:
        raise ValueError(f"initial states: side = {values['side']:g}: must be 1 or -1")
    if (values["failure_tick"] >= 0).all():
        raise ValueError("initial states: failure_tick: fewer than all boats may fail")
    values["motion"][:, 2] = wrap(values["motion"][:, 2])
    values["goal"][2] = wrap(values["goal"][2])
    values["failure_tick"] = values["failure_tick"].astype(np.int64)
    return InitialState(**values)
