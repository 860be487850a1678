"""The ``spec`` that Gymnasium assigns to an environment: completed, and read for its time limit."""

import copy
import sys
from collections.abc import Mapping
from enum import Enum
from typing import Any

from asv_env import checks

REGISTRATION = "gymnasium.envs.registration"  #: module of ``gymnasium.make``


def completed(spec: Any, max_episode_steps: int) -> Any:
    """Returns a spec with the true length of episodes and options that JSON can express.

    Environments made from it, or from its JSON text, are the same again.
    """
    if not hasattr(spec, "max_episode_steps"):  # None, or of another library
        return spec
    complete = copy.copy(spec)
    complete.kwargs, complete.max_episode_steps = plain(spec.kwargs), max_episode_steps
    complete.kwargs.pop("max_episode_steps", None)  # as an option of ``make_vec``
    return complete


def plain(value: Any) -> Any:
    """Returns a value whose arrays are lists and whose NumPy numbers are Python's, all copies."""
    value = checks.plain(value)
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {plain(key): plain(one) for key, one in value.items()}
    if type(value) in (list, tuple):
        return type(value)(map(plain, value))
    return value


def requested_steps() -> int | None:
    """Returns the ``max_episode_steps`` of the call of ``gymnasium.make`` that assigns a spec.

    ``make`` passes the number to its wrapper ``TimeLimit`` alone, which can shorten episodes but
    not lengthen them. So it is looked up in the caller of a ``spec`` setter that calls this: an
    argument of ``make``, or a field of the spec from which it makes. Where there is no such call,
    nothing is found, and the wrapper acts.
    """
    frame = sys._getframe(2)
    if frame.f_code.co_name != "make" or frame.f_globals.get("__name__") != REGISTRATION:
        return None
    steps = frame.f_locals.get("max_episode_steps")
    if steps is not None:
        return steps
    return getattr(frame.f_locals.get("env_spec"), "max_episode_steps", None)
