"""Keys by which a person steers all boats of a world at once."""

import itertools
from typing import Any

import numpy as np

from asv_env.arguments import COMMANDS

AHEAD = {"tracking": (1.0, 0.0), "thrusters": (1.0, 1.0)}  #: action of full speed ahead, by mode
PORT = {"tracking": (0.0, 1.0), "thrusters": (-0.5, 0.5)}  #: action of a turn to port, by mode


def keys_to_action(action_mode: str, num_boats: int) -> dict[tuple[str, ...], Any]:
    """Returns actions (A, 2), or (A,) if discrete, by the keys that are pressed together.

    W and S are ahead and astern, A and D turn to port and starboard.
    """
    mode = "tracking" if action_mode == "discrete" else action_mode
    ahead, port = np.array(AHEAD[mode]), np.array(PORT[mode])
    speeds, turns = {"": 0.0, "w": 1.0, "s": -1.0}, {"": 0.0, "a": 1.0, "d": -1.0}
    actions = {}
    for speed, turn in itertools.product(speeds, turns):
        if keys := (*speed, *turn):
            action = np.clip(speeds[speed] * ahead + turns[turn] * port, -1.0, 1.0)
            team = np.tile(action, (num_boats, 1)).astype(np.float32)
            actions[keys] = _nearest(team) if action_mode == "discrete" else team
    return actions


def _nearest(action: np.ndarray) -> np.ndarray:
    """Returns the numbers (A,) of the discrete actions that are nearest to tracking ones (A, 2)."""
    offset = action[:, None] - COMMANDS
    return np.linalg.norm(offset, axis=-1).argmin(axis=-1)
