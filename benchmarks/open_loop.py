"""How far actions by time alone come: ``python benchmarks/open_loop.py``.

A benchmark of control must not be passed by a policy that looks at nothing. For each suite a
sequence of actions is searched on seeds for development, in the first condition of every team size,
with the cross-entropy method, for the largest mean return. Then it runs in all conditions.
"""

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from tqdm import tqdm

from asv_env.checks import check_whole
from asv_env.params import EnvParams
from asv_env.types import Action, Bool, Float, Observation, Sensed
from baselines.evaluate.conditions import Condition
from baselines.evaluate.suites import SUITES
from baselines.rollout import runner, seeds
from baselines.rollout.commands import FilePath, command
from baselines.rollout.cross_entropy import search
from baselines.rollout.lock import locked
from baselines.rollout.score_log import ScoreLog

KNOTS = 8  #: number of times at which actions are given; they are linear in between
SPREAD = 0.5  #: standard deviation of the first candidates
LOG = "scores.jsonl"


@dataclass(frozen=True)
class Options:
    """Searches sequences of actions by time alone, and prints how often they succeed."""

    suites: tuple[str, ...] = ("plane-v2", "robust-v2")  #: names of suites
    generations: int = 6  #: generations of the search
    population: int = 12  #: candidates of each
    elite: int = 4  #: best ones of each, to which the next is fitted
    episodes: int = 16  #: episodes for a candidate's return
    checked: int = 100  #: episodes of each condition with the sequence that was found
    seed: int = seeds.DEVELOPMENT.start + 30_000_000  #: first seed
    out: FilePath = Path("runs/open-loop")  #: folder of the scores, from which a search resumes

    def __post_init__(self) -> None:
        check_whole(self, "generations population episodes checked", 1)
        check_whole(self, "elite", 2, self.population - 1)
        count = self.generations * self.episodes + self.checked
        seeds.check(range(self.seed, self.seed + count), "development")


class OpenLoop:
    """Plays a sequence of actions (KNOTS, A, 2), spread over the time limit."""

    def __init__(self, knots: Float, params: EnvParams) -> None:
        times = np.linspace(0.0, len(knots) - 1.0, params.time_limit_ticks + 1)
        first = np.minimum(times.astype(int), len(knots) - 2)
        share = (times - first)[:, None, None]
        self._actions = (1 - share) * knots[first] + share * knots[first + 1]

    def act(
        self, sensed: Sensed, observation: Observation, memory: Any, fresh: Bool
    ) -> tuple[Action, Any]:
        """See ``Policy.act``; of what is sensed only the clock is used."""
        tick = np.minimum(sensed.tick, len(self._actions) - 1)
        return np.clip(self._actions[tick], -1.0, 1.0).astype(np.float32), None


def rates(knots: Float, params: EnvParams, wanted: range) -> tuple[float, float]:
    """Returns success rate and mean return of a sequence over seeds."""
    logs = runner.run(partial(OpenLoop, knots), params, wanted, len(wanted))
    found = [(log.episode.success, log.episode.episode_return) for log in logs]
    return tuple(np.mean(found, axis=0).tolist())


def searched(condition: Condition, name: str, options: Options, log: ScoreLog) -> Float:
    """Returns the best sequence (KNOTS, A, 2) for a condition, whose ``name`` is unique."""
    params, total = condition.params, options.generations * options.population
    shape = (KNOTS, params.num_boats, 2)
    with tqdm(total=total, desc=condition.name, unit="candidate", file=sys.stderr) as bar:

        def objective(candidate: Float) -> float:
            first = options.seed + bar.n // options.population * options.episodes
            wanted = range(first, first + options.episodes)
            what = f"{name} {wanted} {candidate.round(6).tolist()}"
            score = log.score(what, lambda: rates(candidate.reshape(shape), params, wanted)[1])
            bar.update()
            return score

        mean, rng = np.zeros(np.prod(shape)), np.random.default_rng(options.seed)
        numbers = options.generations, options.population, options.elite
        return search(objective, mean, np.full_like(mean, SPREAD), rng, *numbers).reshape(shape)


def study(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Searches the sequences and prints a line for every condition.

    Raises:
        ValueError, OSError: an unknown suite, or the folder cannot be used.
    """
    found = [SUITES.find(name) for name in options.suites]
    first = options.seed + options.generations * options.episodes
    wanted = range(first, first + options.checked)
    with locked(options.out):
        log = ScoreLog(options.out / LOG)
        for suite in found:
            known: dict[int, Float] = {}
            for condition in suite.conditions:
                team = condition.params.num_boats
                if team not in known:
                    name = f"{suite.name} {suite.digest()} {condition.name}"
                    known[team] = searched(condition, name, options, log)
                success, total = rates(known[team], condition.params, wanted)
                line = f"{suite.name} {condition.name}: {100 * success:.1f} % of {len(wanted)}"
                print(f"{line}, mean return {total:.2f}", flush=True)


main = command(study, "python benchmarks/open_loop.py")

if __name__ == "__main__":
    main()
