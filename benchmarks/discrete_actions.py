"""What the discrete actions can express: ``python benchmarks/discrete_actions.py``.

The scripted policy drives with its actions rounded to the nearest of ``DISCRETE_ACTIONS`` at every
step, with and without the remainder being carried over to the next step.
"""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
import tyro

from asv_env import make_params
from asv_env.checks import check_whole
from asv_env.params import DISCRETE_ACTIONS, EnvParams
from asv_env.types import Action, Bool, Float, Observation, Sensed
from baselines.rollout import runner, seeds
from baselines.rollout.commands import command
from baselines.scripted.scripted_policy import ScriptedPolicy

COMMANDS = np.array(DISCRETE_ACTIONS)


@dataclass(frozen=True)
class Options:
    """Prints how often the scripted policy delivers with discrete actions."""

    task: str = "push"  #: name of the task
    difficulties: tuple[str, ...] = ("easy", "standard")  #: names of tiers
    episodes: int = 100  #: number of episodes of each
    seed: int = seeds.DEVELOPMENT.start  #: first seed

    def __post_init__(self) -> None:
        check_whole(self, "episodes", 1)
        seeds.check(range(self.seed, self.seed + self.episodes), "development")


class Rounded:
    """The scripted policy with its actions rounded to discrete ones."""

    def __init__(self, carries: bool, params: EnvParams) -> None:
        self._carries, self._scripted = carries, ScriptedPolicy(params)

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, tuple[Any, Float]]:
        """See ``Policy.act``; the memory is the scripted policy's and the remainders (W, A, 2)."""
        scripted, left = memory or (None, np.zeros((*sensed.slot.shape, 2)))
        action, scripted = self._scripted.act(sensed, observation, scripted, fresh)
        wanted = action + np.where(fresh[:, None, None], 0.0, left)
        offset = wanted[..., None, :] - COMMANDS
        rounded = COMMANDS[np.linalg.norm(offset, axis=-1).argmin(axis=-1)]
        left = np.clip(wanted - rounded, -1.0, 1.0) if self._carries else np.zeros_like(wanted)
        return rounded.astype(np.float32), (scripted, left)


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Runs the episodes and prints a line for each tier and way of rounding."""
    wanted = range(options.seed, options.seed + options.episodes)
    for difficulty in options.difficulties:
        params = make_params(options.task, difficulty=difficulty)
        for way, make in {
            "as they are": ScriptedPolicy,
            "rounded": partial(Rounded, False),
            "rounded, remainders carried over": partial(Rounded, True),
        }.items():
            logs = runner.run(make, params, wanted, len(wanted))
            delivered = sum(log.episode.success for log in logs)
            print(f"{difficulty}, {way}: {delivered} of {len(wanted)}", flush=True)


main = command(study, "python benchmarks/discrete_actions.py")

if __name__ == "__main__":
    main()
