"""Keys by which a person steers all boats of a world at once."""

import itertools

import numpy as np

from asv_env.types import Action

AHEAD = {"tracking": (1.0, 0.0), "thrusters": (1.0, 1.0)}  #: action of full speed ahead, by mode
PORT = {"tracking": (0.0, 1.0), "thrusters": (-0.5, 0.5)}  #: action of a turn to port, by mode


def keys_to_action(action_mode: str, num_boats: int) -> dict[tuple[str, ...], Action]:
    """Returns actions (A, 2) by the keys that are pressed together.

    W and S are ahead and astern, A and D turn to port and starboard.
    """
    ahead, port = np.array(AHEAD[action_mode]), np.array(PORT[action_mode])
    speeds, turns = {"": 0.0, "w": 1.0, "s": -1.0}, {"": 0.0, "a": 1.0, "d": -1.0}
    actions = {}
    for speed, turn in itertools.product(speeds, turns):
        if keys := (*speed, *turn):
            action = np.clip(speeds[speed] * ahead + turns[turn] * port, -1.0, 1.0)
            actions[keys] = np.tile(action, (num_boats, 1)).astype(np.float32)
    return actions
