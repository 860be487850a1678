"""Tunes the gains of the policy ``allocation``: ``python -m baselines.allocation.tune``.

The cross-entropy method searches the logarithms of ``allocation_gains.FOUND``, first those of teams
that hold the vessel, then those of two boats. A candidate's score is that of the script's search:
success, and how fast and exact it is, averaged over scenarios. Every generation has episodes of its
own, the same for all its candidates. At the end the values found and those from before are compared
on the same further episodes, and those from before stay unless the others are better by more than
twice the standard error of the difference.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.files import write_text
from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.types import Float
from baselines.allocation import allocation_gains
from baselines.allocation.allocation_gains import AllocationGains, ManoeuvreGains
from baselines.allocation.allocation_policy import AllocationPolicy
from baselines.rollout import runner, seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.cross_entropy import search
from baselines.rollout.episodes import Episode
from baselines.rollout.lock import locked
from baselines.rollout.score_log import ScoreLog
from baselines.scripted.tune import score

PROGRAM = "python -m baselines.allocation.tune"
WORLDS = {"team": ((4, "noisy"), (3, "noisy"), (6, "failure")), "pair": ((2, "noisy"),)}
"""Numbers of boats and scenarios of the episodes in which each part of the gains is searched."""
SPREAD = 0.15  #: standard deviation of the logarithms of the first candidates
SIGNIFICANT = 2.0  #: standard errors by which values have to be better to be taken
LOG = "scores.jsonl"  #: file name of the scores
Values = Mapping[str, Mapping[str, float]]  #: gains by part and name


@dataclass(frozen=True)
class Options:
    """How long is searched, and where the results are kept."""

    generations: int = 3  #: generations of each part of the search
    population: int = 8  #: candidates of a generation
    elite: int = 3  #: candidates of a generation to which the next one is fitted
    episodes: int = 24  #: episodes of a candidate in each scenario, run side by side
    checked: int = 100  #: episodes in each scenario in which the result is compared with the start
    seed: int = seeds.DEVELOPMENT.start + 20_000_000  #: first seed of the episodes
    out: FilePath = Path("runs/allocation-tune")  #: folder of the scores, for resuming
    result: FilePath = allocation_gains.FILE  #: file that is written

    def __post_init__(self) -> None:
        check_whole(self, "generations population episodes", 1)
        check_whole(self, "checked", 2)
        check_whole(self, "elite", 2, self.population - 1)
        count = len(WORLDS) * self.generations * self.episodes + self.checked
        seeds.check(range(self.seed, self.seed + count), "development")


def policy(params: EnvParams, values: Values) -> AllocationPolicy:
    """Returns the policy with other values of the gains that are searched."""
    team, pair = (dict[str, Any](values[part]) for part in WORLDS)
    gains = replace(AllocationGains(), **team), replace(ManoeuvreGains(), **pair)
    return AllocationPolicy(params, *gains)


def episodes(values: Values, worlds: tuple[int, str], wanted: range) -> list[Episode]:
    """Returns the episodes of the seeds wanted, run with these gains in such worlds."""
    params = make_params("transport", worlds[0], worlds[1])
    logs = runner.run(lambda given: policy(given, values), params, wanted, len(wanted))
    return sorted((log.episode for log in logs), key=lambda row: row.seed)


def scores(rows: Sequence[Episode], worlds: tuple[int, str]) -> Float:
    """Returns the scores (n,) of episodes in such worlds."""
    params = make_params("transport", worlds[0], worlds[1])
    return np.array([score([row], params) for row in rows])


def scored(values: Values, part: str, wanted: range) -> float:
    """Returns the score of gains over seeds, averaged over the worlds of a part."""
    each = [scores(episodes(values, worlds, wanted), worlds) for worlds in WORLDS[part]]
    return float(np.mean(each))


def improved(start: Values, part: str, options: Options, first: int, log: ScoreLog) -> Values:
    """Returns gains, to three digits, of which those of a part were searched from a seed on."""
    names = list(start[part])
    total = options.generations * options.population
    with tqdm(total=total, desc=part, unit="candidate", file=sys.stderr) as bar:

        def values_of(candidate: Float) -> Values:
            pairs = zip(names, np.exp(candidate).tolist(), strict=True)
            return {**start, part: {name: float(f"{value:.3g}") for name, value in pairs}}

        def objective(candidate: Float) -> float:
            begin = first + bar.n // options.population * options.episodes
            wanted = range(begin, begin + options.episodes)
            values = values_of(candidate)
            what = f"{part} {wanted} {json.dumps(values, sort_keys=True)}"
            found = log.score(what, partial(scored, values, part, wanted))
            bar.update()
            bar.set_postfix(score=f"{found:.3f}")
            return found

        mean = np.log([start[part][name] for name in names])
        rng = np.random.default_rng(options.seed)
        numbers = options.generations, options.population, options.elite
        return values_of(search(objective, mean, np.full_like(mean, SPREAD), rng, *numbers))


def compared(before: Values, after: Values, part: str, wanted: range) -> dict[str, Any]:
    """Returns how gains do on the same episodes: deliveries, scores, and their difference."""
    delivered, each = {}, []
    for name, values in (("before", before), ("after", after)):
        runs = {worlds: episodes(values, worlds, wanted) for worlds in WORLDS[part]}
        delivered[name] = {
            f"{boats} boats, {scenario}": float(np.mean([row.success for row in rows]))
            for (boats, scenario), rows in runs.items()
        }
        each.append(np.concatenate([scores(rows, worlds) for worlds, rows in runs.items()]))
    gain = each[1] - each[0]
    return {
        "delivered": delivered,
        "score": {"before": float(each[0].mean()), "after": float(each[1].mean())},
        "gain": float(gain.mean()),
        "standard error": float(gain.std(ddof=1) / np.sqrt(len(gain))),
    }


def tune(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Search the gains of the policy ``allocation`` on development seeds.

    Repeat the command to continue a search that was stopped.

    Raises:
        ValueError, OSError: seeds for another purpose, or a file cannot be used.
    """
    kept: dict[str, Mapping[str, float]] = dict(allocation_gains.FOUND)
    parts, first = {}, options.seed
    last = first + len(WORLDS) * options.generations * options.episodes
    with locked(options.out):
        log = ScoreLog(options.out / LOG, "baselines.allocation.tune")
        for part in WORLDS:
            found = improved(kept, part, options, first, log)
            first += options.generations * options.episodes
            result = compared(kept, found, part, range(last, last + options.checked))
            better = result["gain"] > SIGNIFICANT * result["standard error"]
            parts[part] = {"found": found[part], "taken": better, **result}
            kept = dict(found) if better else kept
        numbers = ("generations", "population", "elite", "episodes", "checked", "seed")
        search_options = {name: asdict(options)[name] for name in numbers}
        text = {"gains": kept, "search": {"by": PROGRAM, **search_options}, "parts": parts}
        write_text(options.result, json.dumps(text, indent=2) + "\n")
    taken = {part: one["taken"] for part, one in parts.items()}
    print(f"{options.result}: {json.dumps({'taken': taken})}")


main = command(tune, PROGRAM)

if __name__ == "__main__":
    main()
