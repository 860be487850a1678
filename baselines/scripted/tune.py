"""Tunes the gains of the scripted policy that were searched: ``python -m baselines.scripted.tune``.

The cross-entropy method searches the logarithms of ``gains.FOUND``, first those of the approach,
then those of the push. A candidate's score is the share of development episodes in which it
succeeds, and how fast, averaged over ``SCENARIOS``; every generation has episodes of its own, the
same for all its candidates.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any, TypeVar, cast

import numpy as np
import tyro
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.files import write_text
from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.types import Float
from baselines.rollout import runner, seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.cross_entropy import search
from baselines.rollout.episodes import Episode
from baselines.rollout.lock import locked
from baselines.rollout.score_log import ScoreLog
from baselines.scripted import gains
from baselines.scripted.gains import GraspGains, PathGains, PushGains, Tolerances
from baselines.scripted.planner import PathPlanner
from baselines.scripted.scripted_policy import ScriptedPolicy

PROGRAM = "python -m baselines.scripted.tune"
SCENARIOS = {"nominal": 4, "noisy": 4, "mismatch": 4, "failure": 6}  #: and their number of boats
STAGES = {"approach": (GraspGains,), "push": (PushGains, PathGains, Tolerances)}
"""Task of the episodes of each part of the search, and the gains that are searched in it."""
SPREAD = 0.15  #: standard deviation of the logarithms of the first candidates
HASTE = 0.2  #: weight of the share of the time that is left at a success; that of the success is 1
PRECISION = 0.3  #: weight of how close a delivered vessel is to its goal pose
LOG = "scores.jsonl"  #: file name of the scores
Values = Mapping[str, float]  #: gains by name
Kind = TypeVar("Kind", GraspGains, PushGains, PathGains, Tolerances)


@dataclass(frozen=True)
class Options:
    """How long is searched, and where the results are kept."""

    generations: int = 6  #: generations of each part of the search
    population: int = 10  #: candidates of a generation
    elite: int = 4  #: candidates of a generation to which the next one is fitted
    episodes: int = 20  #: episodes of a candidate in each scenario
    checked: int = 100  #: episodes in each scenario in which the result is compared with the start
    workers: int = 2  #: processes
    seed: int = seeds.DEVELOPMENT.start + 10_000_000  #: first seed of the episodes
    out: FilePath = Path("runs/scripted-tune")  #: folder of the scores, from which a search resumes
    result: FilePath = gains.FILE  #: file that is written

    def __post_init__(self) -> None:
        check_whole(self, "generations population episodes checked workers", 1)
        check_whole(self, "elite", 2, self.population - 1)
        count = len(STAGES) * self.generations * self.episodes + self.checked
        seeds.check(range(self.seed, self.seed + count), "development")


def policy(params: EnvParams, values: Values) -> ScriptedPolicy:
    """Returns the scripted policy with other values of the gains that are searched."""
    grasp, push = changed(GraspGains(), values), changed(PushGains(), values)
    nominal = params.rescaled(1.0 / params.scale)
    planner = PathPlanner(nominal.hulls()[0], changed(PathGains(), values))
    return ScriptedPolicy(params, grasp, push, changed(Tolerances(), values), planner)


def changed(base: Kind, values: Values) -> Kind:
    """Returns gains with other values of those that have one."""
    own: Any = {f.name: values[f.name] for f in fields(cast(Any, base)) if f.name in values}
    return cast(Kind, replace(cast(Any, base), **own))


def worlds(task: str, scenario: str) -> EnvParams:
    """Returns the worlds of a task in one of ``SCENARIOS``."""
    return make_params(task, SCENARIOS[scenario], scenario)


def episodes(values: Values, task: str, scenario: str, wanted: range) -> list[Episode]:
    """Returns the episodes of the seeds wanted, run with these gains."""
    params = worlds(task, scenario)
    logs = runner.run(lambda given: policy(given, values), params, wanted, len(wanted))
    return sorted((log.episode for log in logs), key=lambda row: row.seed)


def score(rows: Sequence[Episode], params: EnvParams) -> float:
    """Returns the mean score of episodes: 1 for a success, and more if it is fast and exact."""
    found = []
    for row in rows:
        left = 1 - row.duration / params.task.time_limit
        found.append(row.success * (1 + HASTE * left + PRECISION * _closeness(row, params)))
    return float(np.mean(found))


def _closeness(row: Episode, params: EnvParams) -> float:
    """Returns how close the vessel is to its goal pose at the end, 0 to 1; 0 without a goal."""
    if row.position_error is None or row.heading_error is None:
        return 0.0
    position = row.position_error / params.task.position_tolerance
    heading = row.heading_error / params.task.heading_tolerance
    return 1 / (1 + position**2 + heading**2)


def scored(values: Values, task: str, wanted: range, executor: Executor) -> float:
    """Returns the score of gains in a task over seeds, averaged over the scenarios."""
    same = len(SCENARIOS)
    found = executor.map(episodes, [values] * same, [task] * same, SCENARIOS, [wanted] * same)
    pairs = zip(found, SCENARIOS, strict=True)
    return float(np.mean([score(rows, worlds(task, scenario)) for rows, scenario in pairs]))


def improved(
    start: Values, task: str, options: Options, first: int, log: ScoreLog, executor: Executor
) -> Values:
    """Returns gains, to three digits, of which those of a task were searched from a seed on."""
    known = {field.name for kind in STAGES[task] for field in fields(kind)}
    names = [name for name in start if name in known]
    total = options.generations * options.population
    with tqdm(total=total, desc=task, unit="candidate", file=sys.stderr) as bar:

        def values_of(candidate: Float) -> dict[str, float]:
            pairs = zip(names, np.exp(candidate).tolist(), strict=True)
            return {**start, **{name: float(f"{value:.3g}") for name, value in pairs}}

        def objective(candidate: Float) -> float:
            begin = first + bar.n // options.population * options.episodes
            wanted = range(begin, begin + options.episodes)
            values = values_of(candidate)
            what = f"{task} {wanted} {sorted(values.items())}"
            found = log.score(what, partial(scored, values, task, wanted, executor))
            bar.update()
            bar.set_postfix(score=f"{found:.3f}")
            return found

        mean = np.log([start[name] for name in names])
        rng = np.random.default_rng(options.seed)
        numbers = options.generations, options.population, options.elite
        return values_of(search(objective, mean, np.full_like(mean, SPREAD), rng, *numbers))


def check(values: Values, wanted: range, executor: Executor) -> dict[str, float]:
    """Returns the shares of transports that are delivered, by scenario."""
    same = len(SCENARIOS)
    jobs = [values] * same, ["transport"] * same, SCENARIOS, [wanted] * same
    found = executor.map(episodes, *jobs)
    shares = [float(np.mean([row.success for row in rows])) for rows in found]
    return dict(zip(SCENARIOS, shares, strict=True))


def tune(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Search the gains of the scripted policy on development seeds.

    Repeat the command to continue a search that was stopped.

    Raises:
        ValueError, OSError: seeds for another purpose, or a file cannot be used.
    """
    pool = ProcessPoolExecutor(options.workers, get_context("spawn"))
    with locked(options.out), pool as executor:
        log = ScoreLog(options.out / LOG, "baselines.scripted.tune")
        found, first = gains.FOUND, options.seed
        values: Values = found
        for task in STAGES:
            values = improved(values, task, options, first, log, executor)
            first += options.generations * options.episodes
        wanted = range(first, first + options.checked)
        shares = {
            "before": check(found, wanted, executor),
            "after": check(values, wanted, executor),
        }
        numbers = ("generations", "population", "elite", "episodes", "checked", "seed")
        result: dict[str, Any] = {
            "gains": dict(values),
            "search": {"by": PROGRAM, **{name: asdict(options)[name] for name in numbers}},
            "delivered": shares,
        }
        write_text(options.result, json.dumps(result, indent=2) + "\n")
    print(f"{options.result}: {json.dumps(shares)}")


main = command(tune, PROGRAM)

if __name__ == "__main__":
    main()
