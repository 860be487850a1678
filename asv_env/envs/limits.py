"""The time limit as other libraries give it: a number of steps, ``max_episode_steps``."""

from collections.abc import Mapping
from dataclasses import is_dataclass, replace
from numbers import Integral
from typing import Any

from asv_env.checks import Whole
from asv_env.params import EnvParams

LARGEST_LIMIT = 10**9  #: largest number of steps of an episode


def limited(params: EnvParams, options: Mapping[str, Any], **steps: Any) -> EnvParams:
    """Returns parameters whose episodes are truncated after a number of control steps.

    Args:
        params: parameters of the environment.
        options: those of ``make_params`` from which the parameters were made.
        **steps: the number, by the name under which a library passes it; None, or -1 as
            Gymnasium has it, leaves the time limit as it is.

    Raises:
        ValueError: not a whole number from 1 to ``LARGEST_LIMIT``, or there is another limit too.
    """
    given = {
        name: Whole(1, LARGEST_LIMIT).checked(name, number)
        for name, number in steps.items()
        if not (number is None or (isinstance(number, Integral) and number == -1))
    }
    if len(set(given.values())) > 1:
        raise ValueError(f"{' and '.join(f'{k} = {v}' for k, v in given.items())}: give one")
    hz, ticks = params.clock.control, params.time_limit_ticks
    for name, number in given.items():
        if number != ticks and _has_time_limit(options):
            raise ValueError(
                f"{name} = {number} and time_limit = {params.task.time_limit:g} s, which is "
                f"{ticks} steps at {hz} Hz: give one of the two"
            )
        if number != ticks:
            return replace(params, task=replace(params.task, time_limit=number / hz))
    return params


def _has_time_limit(options: Mapping[str, Any]) -> bool:
    task = options.get("task_params", {})
    return "time_limit" in options or is_dataclass(task) or "time_limit" in task
