"""How good a policy is while it is trained: on development seeds, as the comparison runs it."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from asv_env.params import NOMINAL_LENGTH, EnvParams, TaskParams
from asv_env.presets import make_params
from baselines.learned.metadata import Layers, Metadata
from baselines.learned.network import NetworkPolicy
from baselines.learned.policy_file import SUFFIX
from baselines.rollout import runner
from baselines.rollout.episodes import Episode
from baselines.rollout.files import write_text
from train.config import SEEDS_OF_A_RUN, Config
from train.run import BEST, Run


@dataclass(frozen=True)
class Score:
    """Of one policy in one group of worlds; a row of ``curve.csv``.

    Attributes:
        timesteps: of single boats, at which it was trained.
        seconds: of training until then, warm start and evaluations included.
        num_boats: of the team.
        scenario: what disturbed the worlds.
        episodes: number of them.
        success: share that was done in time.
        median_time: of those, s.
        position_error: of those at the end, median, m.
        heading_error: of those at the end, median of the size, rad.
        penalised_time: mean over all, with twice the time limit for a failure, s for a vessel of
            0.40 m.
    """

    timesteps: int
    seconds: float
    num_boats: int
    scenario: str
    episodes: int
    success: float
    median_time: float
    position_error: float
    heading_error: float
    penalised_time: float


COLUMNS = [f.name for f in fields(Score)]


def evaluate(
    layers: Layers, metadata: Metadata, config: Config, now: tuple[int, float]
) -> list[Score]:
    """Scores of a policy in all groups of worlds of a run.

    Args:
        layers: of the policy.
        metadata: what it was made for.
        config: of the run.
        now: timesteps and seconds of the training.
    """
    scores = []
    for team, scenario in config.shared_out(config.num_envs):
        params = make_params(config.task, team, scenario, side=side(config))
        episodes = run(layers, metadata, params, config)
        scores.append(score(episodes, params, scenario, now))
    return scores


def side(config: Config) -> str:
    """Of the vessel on which the team is evaluated.

    In Push the boats begin in their slots: those of a policy that finds the goal ahead of them
    begin on the side away from it.
    """
    return "goal" if config.mirror and config.task == "push" else TaskParams.side


def run(layers: Layers, metadata: Metadata, params: EnvParams, config: Config) -> list[Episode]:
    """Episodes of a policy on the development seeds."""
    seeds = range(config.eval_seed, config.eval_seed + config.eval_episodes)
    tracks = runner.run(lambda p: NetworkPolicy(layers, metadata, p), params, seeds, len(seeds))
    return [track.episode for track in tracks]


def score(
    episodes: Sequence[Episode], params: EnvParams, scenario: str, now: tuple[int, float]
) -> Score:
    """What episodes of one group amount to."""
    done = [one for one in episodes if one.success]
    late = 2 * params.time_limit_ticks / params.clock.control
    size = params.vessel.length / NOMINAL_LENGTH
    times = [one.duration if one.success else late for one in episodes]
    return Score(
        timesteps=now[0],
        seconds=round(now[1], 1),
        num_boats=params.num_boats,
        scenario=scenario,
        episodes=len(episodes),
        success=len(done) / len(episodes),
        median_time=_median([one.duration for one in done]),
        position_error=_median([one.position_error for one in done]),
        heading_error=_median([abs(one.heading_error or 0.0) for one in done]),
        penalised_time=float(np.mean(times)) / size,
    )


def keep(run: Run, layers: Layers, scores: Sequence[Score], best: bool) -> None:
    """Leaves a policy and its scores in the folder of its run.

    The rows of the curve come last: where they are, the policy files are too.

    Args:
        run: with the folder.
        layers: of the policy.
        scores: of it.
        best: whether it is the best so far.
    """
    first, start = run.config.first_seed, run.config.init_from
    model_card = {
        "options": run.config.learned() | {"init_from": start and start.name},
        "timesteps": scores[0].timesteps,
        "training_seeds": [first, first + SEEDS_OF_A_RUN - 1],
        "development": [vars(one) for one in scores],
        "began_with": run.began_with,
    }
    if best:
        run.save_policy(f"{BEST}{SUFFIX}", layers, model_card)
    run.save_policy(f"policy{SUFFIX}", layers, model_card)
    _put(run.curve, [*_rows(run.curve), *map(asdict, scores)])


def told(scores: Sequence[Score]) -> dict[str, float]:
    """What goes into the log, by name."""
    values = {}
    for one in scores:
        group = f"evaluation/{one.num_boats}_{one.scenario}"
        values[f"{group}_success"], values[f"{group}_time"] = one.success, one.median_time
    return values


def headline(scores: Sequence[Score]) -> str:
    """What a progress bar says."""
    success = float(np.mean([one.success for one in scores]))
    times = [one.median_time for one in scores if one.success]
    return f"success {success:.0%}" + (f", {np.mean(times):.1f} s" if times else "")


def _median(values: Sequence[float | None]) -> float:
    numbers = [value for value in values if value is not None]
    return round(float(np.median(numbers)), 5) if numbers else float("nan")


def merit(scores: Sequence[Score]) -> float:
    """By which the best policy of a run is chosen: less is better, s."""
    return float(np.mean([one.penalised_time for one in scores]))


def reached(file: Path) -> int:
    """Timesteps of the last evaluation in ``curve.csv``; 0 where there is none."""
    return max((int(row["timesteps"]) for row in _rows(file)), default=0)


def cut(file: Path, timesteps: int) -> None:
    """Drops what ``curve.csv`` says of later than ``timesteps``: it will be learned again."""
    rows = _rows(file)
    kept = [row for row in rows if int(row["timesteps"]) <= timesteps]
    if len(kept) < len(rows):
        _put(file, kept)


def _put(file: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Writes ``curve.csv``, all at once."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS)
    writer.writeheader()
    writer.writerows(rows)
    write_text(file, text.getvalue())


def _rows(file: Path) -> list[dict[str, str]]:
    """Rows of ``curve.csv``; none where it is not there yet."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as text:
        return list(csv.DictReader(text))
