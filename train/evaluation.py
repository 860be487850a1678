"""Scores of a policy while it is trained, on development seeds, and ``curve.csv``, their file."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from asv_env.files import write_text
from asv_env.params import NOMINAL_LENGTH, EnvParams
from baselines.learned.network import Layers, Metadata, NetworkPolicy
from baselines.rollout import runner, typed_csv
from baselines.rollout.episodes import Episode
from train.config import Config

UNDEFINED = ["median_time", "position_error", "heading_error"]
"""Columns that are "nan" where no episode succeeded."""


@dataclass(frozen=True)
class Score:
    """Score of a policy in one group of worlds; a row of ``curve.csv``."""

    timesteps: int  #: decisions of single boats for which the policy was trained
    seconds: float  #: time of the training until then, imitation and evaluations included, s
    num_boats: int  #: team size
    scenario: str  #: disturbances of the worlds
    episodes: int  #: number of episodes
    success: float  #: fraction of episodes that succeeded within the time limit
    median_time: float  #: median duration of the successful episodes, s
    position_error: float  #: median position error at the end of the successful episodes, m
    heading_error: float  #: median absolute heading error at the end of these episodes, rad
    penalised_time: float
    """Mean duration of all episodes, s for a vessel of 0.40 m; a failure counts with twice the
    time limit."""


def evaluate(
    layers: Layers, metadata: Metadata, config: Config, timesteps: int, seconds: float
) -> list[Score]:
    """Returns the scores of a policy, trained for so long, in all groups of worlds of a run.

    Raises:
        ValueError: it gives actions that are no numbers, or fails in another way.
    """
    options, make = config.evaluation, partial(NetworkPolicy, layers, metadata)
    scores = []
    for team, scenario in config.worlds.groups(config.worlds.num_envs):
        params = config.params(team, scenario)
        logs = runner.run(make, params, options.seeds, options.episodes)
        episodes = [log.episode for log in logs]
        if wrong := next((episode.error for episode in episodes if episode.error), None):
            raise ValueError(
                f"the training has diverged, its policy fails after {timesteps} timesteps "
                f"({wrong}): begin again with smaller learning rates, or other demonstrations"
            )
        scores.append(score(episodes, params, scenario, timesteps, seconds))
    return scores


def score(
    episodes: Sequence[Episode], params: EnvParams, scenario: str, timesteps: int, seconds: float
) -> Score:
    """Returns the score of the episodes of one group of worlds."""
    done = [episode for episode in episodes if episode.success]
    failed = 2 * params.time_limit_ticks / params.clock.control
    times = [episode.duration if episode.success else failed for episode in episodes]
    return Score(
        timesteps=timesteps,
        seconds=round(seconds, 1),
        num_boats=params.num_boats,
        scenario=scenario,
        episodes=len(episodes),
        success=len(done) / len(episodes),
        median_time=_median([episode.duration for episode in done]),
        position_error=_median([episode.position_error for episode in done]),
        heading_error=_median([e.heading_error and abs(e.heading_error) for e in done]),
        penalised_time=float(np.mean(times)) / (params.vessel.size / NOMINAL_LENGTH),
    )


def _median(values: Sequence[float | None]) -> float:
    numbers = [value for value in values if value is not None]
    return round(float(np.median(numbers)), 5) if numbers else float("nan")


def read_curve(file: Path) -> pd.DataFrame:
    """Returns the rows of the file, each a ``Score``; none where it does not exist yet.

    Raises:
        ValueError: the file is damaged.
    """
    names = [field.name for field in fields(Score)]
    if not file.exists() or not file.stat().st_size:
        return pd.DataFrame(columns=names)
    try:
        return typed_csv.read(file, Score, names, "nan", UNDEFINED)
    except ValueError as error:
        reason = " ".join(str(error).split())
        raise ValueError(
            f"{file} is no learning curve ({reason}): remove it, or begin again with --overwrite"
        ) from error


def append_to_curve(file: Path, scores: Sequence[Score]) -> None:
    """Adds the rows of an evaluation."""
    before, new = read_curve(file), pd.DataFrame(scores)
    _write_curve(file, pd.concat([before, new]) if len(before) else new)


def truncate_curve(file: Path, timesteps: int) -> None:
    """Drops the rows later than ``timesteps``, which a resumed training evaluates again."""
    rows = read_curve(file)
    if (rows["timesteps"] > timesteps).any():
        _write_curve(file, rows[rows["timesteps"] <= timesteps])


def _write_curve(file: Path, rows: pd.DataFrame) -> None:
    write_text(file, rows.to_csv(index=False, na_rep="nan"))


def last_timesteps(file: Path) -> int:
    """Returns the timesteps of the last evaluation; 0 where there is none."""
    return max(read_curve(file)["timesteps"], default=0)
