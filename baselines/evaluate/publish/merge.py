"""Adds policies to published results: ``python -m baselines.evaluate.publish.merge RUN PUBLISHED``.

The episodes of the published policies are not all run again. They are kept if the suite and the
libraries are the same, and if the first episodes of every condition, run again with the present
code, come out the same but for rounding, which differs between processors. In a few episodes
rounding may have grown, as when a team chases a vessel for minutes in moving water, but other code
would change them all: more than half must be the same, and the others must end alike. The return is
not compared, because the weights of the reward may have changed.
"""

import json
import math
from dataclasses import astuple, replace
from pathlib import Path
from typing import Any

from tqdm import tqdm
from tyro.conf import Positional

from asv_env import files
from asv_env.checks import choice
from baselines.evaluate.conditions import Suite
from baselines.evaluate.policy_sources import find
from baselines.evaluate.publish import summaries
from baselines.evaluate.results import Results, of_rows, read_csv, write_csv
from baselines.evaluate.suites import SUITES
from baselines.evaluate.summary import summarise
from baselines.rollout import runner
from baselines.rollout.commands import FilePath, command
from baselines.rollout.episodes import Episode, Label
from baselines.rollout.lock import locked

ROWS, SUMMARY, REPORT = "episodes.csv", summaries.NAME, "report.md"
SAME = ("suite", "task", "set of episodes", "set of libraries")  #: provenance of both runs
ROUNDING = 1e-6  #: tolerance of equal numbers of an episode, relative and in m, rad and s


def add(run: Positional[FilePath], published: Positional[FilePath], checked: int = 5) -> None:
    """Adds policies to published results of the same suite; those of the same names are replaced.

    Args:
        run: folder of the run, with as many episodes of each condition or more.
        published: folder of the published results.
        checked: number of episodes of each condition and published policy that are run again.

    Raises:
        ValueError: the runs cannot be compared.
        FileNotFoundError: a folder holds no results.
    """
    if checked < 1:
        raise ValueError(f"--checked {checked}: must be at least 1")
    for folder in (run, published):  # before a lock is left there
        summaries.read(folder / SUMMARY)
    with locked(published):
        _add(run, published, checked)


def _add(run: Path, published: Path, checked: int) -> None:
    new, old = (summaries.read(each / SUMMARY) for each in (run, published))
    _check_provenance(run, new, published, old)
    suite = SUITES[choice("suite", old["suite"], SUITES)].first(old["episodes"])
    kept = [row for row in read_csv(published / ROWS) if row.policy not in new["policies"]]
    check(suite, of_rows(suite, kept), checked)
    added = [row for row in read_csv(run / ROWS) if row.seed in suite.seeds]
    results = of_rows(suite, [*kept, *added])
    fingerprints = {**old["policies"], **new["policies"]}
    summary = {
        **old,
        "policies": {name: fingerprints[name] for name in results.policies},
        "added": {**old.get("added", {}), **dict.fromkeys(new["policies"], new["provenance"])},
        **summarise(results),
    }
    report = summaries.markdown(published / SUMMARY, results, summary)
    write_csv(published / ROWS, results)
    files.write_text(published / SUMMARY, json.dumps(summary, indent=2) + "\n")
    files.write_text(published / REPORT, report)


def _check_provenance(run: Path, new: dict[str, Any], published: Path, old: dict[str, Any]) -> None:
    """Raises ValueError where the summaries are of runs that cannot be compared."""
    for name in SAME:
        there, here = old["provenance"].get(name), new["provenance"].get(name)
        if there != here:
            raise ValueError(
                f"{name} is {there!r} in {published} and {here!r} in {run}: run all policies again"
            )
    if new["episodes"] < old["episodes"]:
        raise ValueError(
            f"{run} has {new['episodes']} episodes of each condition, {published} has "
            f"{old['episodes']}: run it with --episodes {old['episodes']}"
        )


def check(suite: Suite, results: Results, count: int) -> None:
    """Runs the first ``count`` episodes of every condition and policy again.

    Raises ValueError where half of them or more differ, or one of them ends differently.
    """
    pairs = [(condition, policy) for condition in suite.conditions for policy in results.policies]
    for condition, policy in tqdm(pairs, desc="published episodes, run again"):
        before = results.rows[condition.name, policy][0][:count]
        label = Label(policy, None, condition.name, condition.scenario_name)
        seeds = [row.seed for row in before]
        logs = runner.run(find(policy).factory, condition.params, seeds, count, label)
        again = {log.episode.seed: log.episode for log in logs}
        differ = [row for row in before if not _same(again[row.seed], row)]
        ends_differently = any(again[row.seed].cause != row.cause for row in differ)
        if ends_differently or (differ and 2 * len(differ) >= len(before)):
            raise ValueError(
                f"{policy}, {condition.name}: {len(differ)} of {len(before)} episodes differ from "
                f"the published ones, seed {differ[0].seed} among them; run all policies again"
            )


def _same(first: Episode, second: Episode) -> bool:
    """Returns whether two rows are of the same episode, whatever its return."""
    rows = astuple(first), astuple(replace(second, episode_return=first.episode_return))
    return all(
        math.isclose(a, b, rel_tol=ROUNDING, abs_tol=ROUNDING)
        if isinstance(a, float) and isinstance(b, float)
        else a == b
        for a, b in zip(*rows, strict=True)
    )


main = command(add, "python -m baselines.evaluate.publish.merge")

if __name__ == "__main__":
    main()
