"""Scores of a policy while it is trained, on development seeds."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from asv_env.params import NOMINAL_LENGTH, EnvParams, TaskParams
from baselines.learned.network import Layers, Metadata, NetworkPolicy
from baselines.rollout import runner
from baselines.rollout.episodes import Episode
from train.config import Config


@dataclass(frozen=True)
class Score:
    """Score of a policy in one group of worlds; a row of ``curve.csv``."""

    timesteps: int
    """Decisions of single boats for which the policy was trained."""
    seconds: float
    """Time of the training until then, imitation and evaluations included, s."""
    num_boats: int
    """Team size."""
    scenario: str
    """Disturbances of the worlds."""
    episodes: int
    """Number of episodes."""
    success: float
    """Fraction of episodes that succeeded within the time limit."""
    median_time: float
    """Median duration of the successful episodes, s."""
    position_error: float
    """Median position error at the end of the successful episodes, m."""
    heading_error: float
    """Median absolute heading error at the end of the successful episodes, rad."""
    penalised_time: float
    """Mean duration of all episodes, s for a vessel of 0.40 m; a failure counts with twice the
    time limit."""


def evaluate(
    layers: Layers, metadata: Metadata, config: Config, timesteps: int, seconds: float
) -> list[Score]:
    """Returns the scores of a policy in all groups of worlds of a run.

    Args:
        layers: of the policy.
        metadata: what the policy was made for.
        config: of the run.
        timesteps: of the training so far.
        seconds: of the training so far.
    """
    scores = []
    for team, scenario in config.worlds.groups(config.worlds.num_envs):
        params = config.params(team, scenario, side=push_side(config))
        logs = runner.run(
            lambda p: NetworkPolicy(layers, metadata, p),
            params,
            config.evaluation.seeds,
            config.evaluation.episodes,
        )
        episodes = [log.episode for log in logs]
        scores.append(score(episodes, params, scenario, timesteps, seconds))
    return scores


def push_side(config: Config) -> str:
    """Returns the push side used in evaluation: away from the goal for mirrored Push policies."""
    return "goal" if config.worlds.mirror and config.definition.starts_grasped else TaskParams.side


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
        heading_error=_median([abs(episode.heading_error or 0.0) for episode in done]),
        penalised_time=float(np.mean(times)) / (params.vessel.length / NOMINAL_LENGTH),
    )


def _median(values: Sequence[float | None]) -> float:
    numbers = [value for value in values if value is not None]
    return round(float(np.median(numbers)), 5) if numbers else float("nan")


def selection_score(scores: Sequence[Score]) -> float:
    """Returns the number by which the best policy of a run is selected: less is better, s."""
    return float(np.mean([score.penalised_time for score in scores]))


def log_values(scores: Sequence[Score]) -> Iterator[tuple[str, float]]:
    """Yields what goes into the log: name and value."""
    for score in scores:
        group = f"evaluation/{score.num_boats}_{score.scenario}"
        yield f"{group}_success", score.success
        yield f"{group}_time", score.median_time


def headline(scores: Sequence[Score]) -> str:
    """Returns success and time in a few words, for a progress bar."""
    success = float(np.mean([score.success for score in scores]))
    times = [score.median_time for score in scores if score.success]
    return f"success {success:.0%}" + (f", {np.mean(times):.1f} s" if times else "")
