"""The environments of the paper's experiment and simulation, and episodes that are run in them."""

import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from tqdm import tqdm

from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.types import Float
from baselines.policy import MakePolicy
from baselines.rollout import runner
from baselines.rollout.episodes import POSE_LOG_EVERY, PoseLog

WORLDS = 48  #: number of worlds that are simulated side by side
SCENARIOS = ("nominal", "noisy")  #: exact measurement, and with noise


def experiment(task: str = "transport", preset: str = "experiment", **options: Any) -> EnvParams:
    """Returns the tank experiment: four boats, sensed at 20 Hz, controlled at 10 Hz."""
    return make_params(task, preset=preset, **options)


def simulation(task: str = "transport", num_boats: int = 10, **options: Any) -> EnvParams:
    """Returns the paper's numerical simulation, with wheel speeds commanded at 50 Hz.

    The goal is given from the pose at closure as in the experiment: alpha_1 = 1 suits the paper's
    goal, and hardly any other, not even the same one from a vessel that the boats have nudged.
    """
    return make_params(
        task,
        num_boats,
        preset="paper_simulation",
        action_mode="thrusters",
        goal_anchor="closure",
        **options,
    )


def run(
    make_policy: MakePolicy, params: EnvParams, seeds: Sequence[int], what: str
) -> list[PoseLog]:
    """Returns the pose logs of the episodes with these seeds, in their order.

    ``what`` is the title of the progress bar.
    """
    running = runner.run(make_policy, params, seeds, WORLDS)
    bar = tqdm(running, what, len(seeds), unit="episode", file=sys.stderr, leave=False, position=1)
    return sorted(bar, key=lambda log: log.episode.seed)


def episodes(
    make_policy: MakePolicy, params: EnvParams, seeds: Sequence[int], what: str
) -> list[dict[str, Any]]:
    """Returns the episodes with these seeds as rows of ``episodes.csv``; see ``run``."""
    return [asdict(log.episode) for log in run(make_policy, params, seeds, what)]


def before_closure(log: PoseLog, params: EnvParams) -> Float:
    """Returns the poses (T, B, 3) of a log up to its first closure; all where there is none."""
    time = log.episode.time_to_closure
    if time is None:
        return log.poses
    return log.poses[: 1 + round(time * params.clock.control / POSE_LOG_EVERY)]
