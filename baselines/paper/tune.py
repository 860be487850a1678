"""Tunes the free parameters of the paper's controller: ``python -m baselines.paper.tune``.

The laws stay; the first turn is that of the shortest path for each goal. The push is tuned first,
from a formed closure, then the approach with the gains found for the push. Scores are those of
development episodes, in the push half of them with noise; every generation of the search has
episodes of its own, the same for all its candidates.
"""

import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from tqdm import tqdm

from asv_env.checks import TINY, check_numbers, check_whole, choice
from asv_env.files import write_text
from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.types import Float
from baselines.paper import tuned
from baselines.paper.paper_numbers import ARRIVAL_TIME, GAINS, PaperGains
from baselines.paper.paper_policy import PaperPolicy
from baselines.rollout import runner, seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.cross_entropy import search
from baselines.rollout.episodes import Episode
from baselines.rollout.lock import locked
from baselines.rollout.score_log import ScoreLog

PROGRAM = "python -m baselines.paper.tune"
SCENARIOS = ("nominal", "noisy")
TIME_LIMIT = 120.0  #: time for the push, and for the approach, s
CLOSENESS = 0.5  #: weight of the closeness to the goal; that of a delivery is 1
START = replace(
    GAINS,
    alpha1=None,
    min_radius=2.5,
    arrival_time=ARRIVAL_TIME["tracking"],
    push_speed=0.03,
    stop_distance=0.13,
    speed_integral=0.3,
    switch_distance=0.02,
)
"""Where the search begins: as printed, or what looked sensible in a few trials."""
LOG = "scores.jsonl"  #: file name of the scores


def push_score(rows: Sequence[Episode], params: EnvParams) -> float:
    """Returns the mean of deliveries, and of how close the vessel came to its goal pose."""
    task = params.task
    errors = [(row.min_position_error, row.heading_error_at_min) for row in rows]
    position, heading = np.array(errors, dtype=np.float64).T
    square = (position / task.position_tolerance) ** 2 + (heading / task.heading_tolerance) ** 2
    delivered = np.mean([row.success for row in rows])
    return float(delivered + CLOSENESS * np.mean(1 / (1 + square)))


def approach_score(rows: Sequence[Episode], params: EnvParams) -> float:
    """Returns the mean of the time that is left at success, relative to the time limit."""
    left = [row.success * (1 - row.duration / params.task.time_limit) for row in rows]
    return float(np.mean(left))


@dataclass(frozen=True)
class Stage:
    """A part of the search."""

    task: str  #: name of the task of its episodes
    names: tuple[str, ...]  #: gains that are searched, all positive: by their logarithms
    score: Callable[[Sequence[Episode], EnvParams], float]  #: of episodes, the larger the better
    share: float = 1.0  #: number of its generations, relative to that of the options
    scenarios: tuple[str, ...] = SCENARIOS  #: over which scores are averaged

    def gains(self, base: PaperGains, logarithms: Float) -> PaperGains:
        """Returns gains with other values (K,) of those that are searched."""
        values = dict(zip(self.names, np.exp(logarithms).tolist(), strict=True))
        if "min_radius" in values:
            values["min_radius"] = max(values["min_radius"], 1.0)
        return replace(base, **values)

    def logarithms(self, gains: PaperGains) -> Float:
        """Returns the logarithms (K,) of the gains that are searched."""
        return np.log([getattr(gains, name) for name in self.names])


STAGES = (
    Stage(
        "push",
        (
            *("min_radius", "stop_distance", "push_speed", "speed_integral", "switch_distance"),
            *("steering", "vessel_yaw", "cross_track", "max_yaw_offset", "keep_up"),
        ),
        push_score,
    ),
    Stage("approach", ("max_speed", "arrival_time", "sigma"), approach_score, 0.5, ("nominal",)),
)


@dataclass(frozen=True)
class Options:
    """How long is searched, and where the results are kept."""

    generations: int = 4  #: generations of the push; the approach has fewer
    population: int = 8  #: candidates of a generation
    elite: int = 3  #: candidates of a generation to which the next one is fitted
    spread: float = 0.2  #: standard deviation of the logarithms of the first candidates
    episodes: int = 24  #: episodes of a candidate in each scenario
    checked: int = 100  #: episodes in each scenario in which the result is compared
    seed: int = seeds.DEVELOPMENT.start  #: first seed of the episodes
    only: tuple[str, ...] = tuple(stage.task for stage in STAGES)  #: stages that are searched
    start: FilePath | None = None  #: result of an earlier search, from which this one begins
    out: FilePath = Path("runs/paper-tune")  #: folder of the scores, from which a search resumes
    result: FilePath = tuned.FILE  #: file that is written

    def __post_init__(self) -> None:
        check_whole(self, "generations population episodes checked", 1)
        check_whole(self, "elite", 2, self.population - 1)
        check_numbers(self, "spread", TINY, 1.0)
        for name in self.only:
            choice("stage", name, [stage.task for stage in STAGES])
        count = len(STAGES) * self.generations * self.episodes + self.checked
        seeds.check(range(self.seed, self.seed + count), "development")


def episodes(gains: PaperGains, params: EnvParams, wanted: range) -> list[Episode]:
    """Returns the episodes of the seeds wanted, run with the paper's controller."""
    logs = runner.run(lambda params: PaperPolicy(params, gains), params, wanted, len(wanted))
    return sorted((log.episode for log in logs), key=lambda row: row.seed)


def scored(stage: Stage, gains: PaperGains, wanted: range) -> float:
    """Returns the score of gains over seeds, averaged over the scenarios."""
    found = []
    for scenario in stage.scenarios:
        params = make_params(stage.task, scenario=scenario, time_limit=TIME_LIMIT)
        found.append(stage.score(episodes(gains, params, wanted), params))
    return float(np.mean(found))


def improved(
    stage: Stage, base: PaperGains, options: Options, first: int, scores: ScoreLog
) -> PaperGains:
    """Returns gains in which those of a stage were searched, on episodes from a seed on."""
    generations = math.ceil(stage.share * options.generations)
    total = generations * options.population
    with tqdm(total=total, desc=stage.task, unit="candidate", file=sys.stderr) as bar:

        def objective(candidate: Float) -> float:
            begin = first + bar.n // options.population * options.episodes
            wanted = range(begin, begin + options.episodes)
            gains = stage.gains(base, candidate)
            what = f"{stage.task} {wanted} {sorted(asdict(gains).items())}"
            score = scores.score(what, partial(scored, stage, gains, wanted))
            bar.update()
            bar.set_postfix(score=f"{score:.3f}")
            return score

        mean, rng = stage.logarithms(base), np.random.default_rng(options.seed)
        numbers = generations, options.population, options.elite
        found = search(objective, mean, np.full_like(mean, options.spread), rng, *numbers)
    return stage.gains(base, found)


def check(gains: PaperGains, wanted: range) -> dict[str, float]:
    """Returns the shares of goals over the plane that are delivered, by scenario."""
    return {
        scenario: float(np.mean([row.success for row in rows]))
        for scenario in SCENARIOS
        for rows in [episodes(gains, make_params(scenario=scenario), wanted)]
    }


def tune(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Search the free parameters of the paper's controller on development seeds.

    Repeat the command to continue a search that was stopped.

    Raises:
        ValueError, OSError: seeds for another purpose, or a file cannot be used.
    """
    with locked(options.out):
        scores = ScoreLog(options.out / LOG, "baselines.paper.tune")
        gains, first, searches = START, options.seed, []
        if options.start is not None:
            earlier = json.loads(options.start.read_text(encoding="utf-8"))
            gains, searches = PaperGains(**earlier["gains"]), earlier["searches"]
        for stage in STAGES:
            if stage.task not in options.only:
                continue
            gains = improved(stage, gains, options, first, scores)
            first += options.generations * options.episodes
        gains = _rounded(gains)
        wanted = range(first, first + options.checked)
        numbers = (
            *("generations", "population", "elite", "spread", "episodes", "checked", "seed"),
            "only",
        )
        result: dict[str, Any] = {
            "gains": asdict(gains),
            "searches": [*searches, {n: getattr(options, n) for n in numbers}],
            "delivered": {"as printed": check(GAINS, wanted), "tuned": check(gains, wanted)},
        }
        write_text(options.result, json.dumps(result, indent=2) + "\n")
    print(f"{options.result}: {json.dumps(result['delivered'])}")


def _rounded(gains: PaperGains) -> PaperGains:
    """Returns gains with three digits."""
    given = {name: value for name, value in asdict(gains).items() if value is not None}
    return replace(gains, **{name: float(f"{value:.3g}") for name, value in given.items()})


main = command(tune, PROGRAM)

if __name__ == "__main__":
    main()
