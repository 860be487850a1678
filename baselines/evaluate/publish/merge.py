"""Adds policies to published results: ``python -m baselines.evaluate.publish.merge RUN FOLDER``.

Thousands of episodes of the scripted policies need not be run again for a policy that comes later.
They are kept if the suite and the libraries are the same, and if the first of them, run again in
every condition with the code as it is, come out the same but for rounding, which differs between
processors. In a few it may have grown: a team that chases a vessel for minutes in moving water
magnifies it. Other code would change them all, so most have to be the same, and the others have to
end alike. The return does not count, whose weights may have changed.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import astuple, replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from baselines.evaluate.conditions import Suite
from baselines.evaluate.policy_sources import Source
from baselines.evaluate.report import rendering
from baselines.evaluate.results import Results, of_rows, read_csv, write_csv
from baselines.evaluate.suites import SUITES
from baselines.evaluate.summary import summarise
from baselines.rollout import runner
from baselines.rollout.episodes import Episode, Label

ROWS, SUMMARY, REPORT = "episodes.csv", "summary.json", "report.md"
SAME = ("suite", "task", "set of episodes", "set of libraries")
"""Of what two runs are made, where they can be compared."""
ROUNDING = 1e-6
"""Relative and in m, rad and s: to which the same episode comes out on another processor."""


def add(run: Path, published: Path, checked: int) -> None:
    """Adds the policies of a run to published results, in place of those of the same names.

    Args:
        run: folder of a run of the same suite, with as many episodes or more.
        published: folder of the results.
        checked: episodes of each condition and published policy that are run again.

    Raises:
        ValueError: they cannot be compared.
        FileNotFoundError: a folder holds no results.
    """
    new, old = _summary(run), _summary(published)
    for name in SAME:
        if new["origin"][name] != old["origin"][name]:
            raise ValueError(
                f"{name} is {old['origin'][name]!r} in {published} and {new['origin'][name]!r} in "
                f"{run}: run all policies again"
            )
    if new["episodes"] < old["episodes"]:
        raise ValueError(
            f"{run} has {new['episodes']} episodes of each condition, {published} {old['episodes']}: "
            f"run it with --episodes {old['episodes']}"
        )
    suite = SUITES[old["suite"]].first(old["episodes"])
    kept = [row for row in read_csv(published / ROWS) if row.policy not in new["policies"]]
    check(suite, of_rows(suite, kept), checked)
    added = [row for row in read_csv(run / ROWS) if row.seed in suite.seeds]
    results = of_rows(suite, [*kept, *added])
    told = {
        **old,
        "policies": {**old["policies"], **new["policies"]},
        "added": {**old.get("added", {}), **dict.fromkeys(new["policies"], new["origin"])},
        **summarise(results),
    }
    write_csv(published / ROWS, results)
    (published / SUMMARY).write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
    (published / REPORT).write_text(rendering.markdown(results, told), encoding="utf-8")


def check(suite: Suite, results: Results, count: int) -> None:
    """Runs the first episodes of every condition again.

    Raises:
        ValueError: half of them or more come out otherwise, or one of them ends otherwise.
    """
    pairs = [(condition, policy) for condition in suite.conditions for policy in results.policies]
    for condition, policy in tqdm(pairs, desc="published episodes, run again"):
        before = results.rows[condition.name, policy][0][:count]
        label = Label(policy, None, condition.name, condition.scenario)
        logs = runner.run(
            Source(policy).make, condition.params, [row.seed for row in before], count, label
        )
        again = {log.episode.seed: log.episode for log in logs}
        other = [row for row in before if not _same(again[row.seed], row)]
        ends_otherwise = any(again[row.seed].cause != row.cause for row in other)
        if ends_otherwise or (other and 2 * len(other) >= len(before)):
            raise ValueError(
                f"{policy}, {condition.name}: {len(other)} of {len(before)} episodes come out otherwise "
                f"than published, seed {other[0].seed} among them; run all policies again"
            )


def _same(one: Episode, other: Episode) -> bool:
    """Whether two rows are of the same episode, whatever was paid for it."""
    pairs = zip(
        astuple(one), astuple(replace(other, episode_return=one.episode_return)), strict=True
    )
    return all(
        math.isclose(a, b, rel_tol=ROUNDING, abs_tol=ROUNDING)
        if isinstance(a, float) and isinstance(b, float)
        else a == b
        for a, b in pairs
    )


def _summary(folder: Path) -> dict[str, Any]:
    summary: dict[str, Any] = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    return summary


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="python -m baselines.evaluate.publish.merge")
    parser.add_argument("run", type=Path, help="folder of a run of the suite")
    parser.add_argument("published", type=Path, help="folder of the results")
    parser.add_argument("--checked", type=int, default=5, help="episodes (%(default)s)")
    options = parser.parse_args(arguments)
    try:
        add(options.run, options.published, options.checked)
    except (ValueError, OSError) as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
