"""What the command does: it runs what is missing, and leaves its files."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from tqdm import tqdm

from baselines.evaluate import workers
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.options import FILES, parse, parser
from baselines.evaluate.policy_sources import Entrant
from baselines.evaluate.report import document
from baselines.evaluate.results import Results, write_csv
from baselines.evaluate.store import Series, Store
from baselines.evaluate.summary import summarise
from baselines.evaluate.tables.table import text_table
from baselines.evaluate.workers import Job, WorkerError
from baselines.rollout import files, film, provenance, trajectories
from baselines.rollout.episodes import Label

LIBRARIES = ("numpy", "scipy", "pymunk")
JOB = 500
"""Largest number of episodes that a worker takes at a time."""


def origin(suite: Suite) -> dict[str, Any]:
    """By what episodes are made, beside the policies."""
    return {
        "suite": suite.name,
        "task": suite.task,
        "set of episodes": suite.digest(),
        "state of the code": provenance.code(),
        "set of libraries": provenance.versions(LIBRARIES),
    }


def run(options: argparse.Namespace, store: Store) -> None:
    """Runs the episodes that are not there yet, with a progress bar."""
    jobs = [
        job
        for condition in options.suite.conditions
        for one in options.entrants
        for number in range(len(one.sources))
        for job in _jobs(options, store, condition, one, number)
    ]
    total = len(options.suite.conditions) * options.suite.episodes
    total *= sum(len(one.sources) for one in options.entrants)
    missing = sum(len(job.seeds) for job in jobs)
    with tqdm(total=total, initial=total - missing, unit="episode", file=sys.stderr) as bar:
        for series, log in workers.run(jobs, options.workers):
            store.add(series, log)
            bar.set_description(f"{series.policy}, {series.condition}", refresh=False)
            bar.update()


def _jobs(
    options: argparse.Namespace, store: Store, condition: Condition, one: Entrant, number: int
) -> list[Job]:
    """The episodes of one series that are missing, shared out."""
    label = Label(one.name, one.training_seed(number), condition.name, condition.scenario)
    record = None
    if options.record:
        record = trajectories.folder(options.out, condition.name, one.name, label.training_seed)
    series = Series(condition.name, one.name, number)
    there = _there(store, series, options.suite, record)
    missing = [seed for seed in options.suite.seeds if seed not in there]
    size = max(1, min(JOB, -(-len(missing) // max(1, options.workers))))
    return [
        Job(
            series,
            condition,
            one.sources[number],
            options.fingerprints[one.name][number],
            label,
            tuple(missing[k : k + size]),
            options.num_envs,
            record,
        )
        for k in range(0, len(missing), size)
    ]


def _there(store: Store, series: Series, suite: Suite, record: Path | None) -> set[int]:
    """Seeds of the episodes with which nothing is left to do."""
    if record is None:
        return store.seeds(series)
    files.remove_parts(record)
    return {
        row.seed
        for row in store.rows(series, suite.seeds)
        if row.error or trajectories.holds(record, row)
    }


def collect(options: argparse.Namespace, store: Store) -> Results:
    """The rows of all episodes that were asked for."""
    suite = options.suite
    rows = {
        (condition.name, one.name): [
            list(store.rows(Series(condition.name, one.name, number), suite.seeds))
            for number in range(len(one.sources))
        ]
        for condition in suite.conditions
        for one in options.entrants
    }
    return Results(suite, tuple(one.name for one in options.entrants), rows)


def save(
    options: argparse.Namespace, store: Store, results: Results, made_by: dict[str, Any]
) -> dict[str, Any]:
    """Writes the files of the output folder; returns the summary."""
    suite = options.suite
    write_csv(options.out / "episodes.csv", results)
    summary = {
        "suite": suite.name,
        "about": suite.about,
        "episodes": suite.episodes,
        "seeds": [suite.seeds[0], suite.seeds[-1]],
        "origin": made_by,
        "policies": options.fingerprints,
        **summarise(results),
    }
    (options.out / "summary.json").write_text(
        json.dumps(summary, indent=2) + "\n", encoding="utf-8"
    )
    document.write(options.out, results, summary, store, options.replays)
    return summary


def main(arguments: Sequence[str] | None = None) -> None:
    """See ``baselines.evaluate.main``."""
    options = parse(arguments)
    made_by = origin(options.suite)
    try:
        store = Store(options.out, made_by, options.fingerprints, options.overwrite)
        for policy in store.dropped:
            trajectories.remove(options.out, policy)
    except OSError as error:
        parser().error(str(error))
    with closing(store):
        try:
            run(options, store)
        except (KeyboardInterrupt, WorkerError, OSError) as error:
            reason = "stopped" if isinstance(error, KeyboardInterrupt) else str(error)
            sys.exit(f"\n{reason}\nFinished episodes are kept: give the same command to go on.")
        results = collect(options, store)
        summary = save(options, store, results, made_by)
    print(text_table(summary))
    _name_broken(results)
    print(f"Results: {', '.join(str(options.out / name) for name in FILES)}")
    if options.video is not None:
        _film(options)


def _film(options: argparse.Namespace) -> None:
    source, condition = options.entrants[0].sources[0], options.suite.conditions[0]
    try:
        film.save(options.video, source.make, condition.params, options.suite.seed)
    except Exception as error:  # of a policy, of a codec: all else is there by now
        sys.exit(f"{options.video}: no film, {type(error).__name__}: {error}")
    print(f"Video: {options.video}")


def _name_broken(results: Results) -> None:
    """Names the episodes that a policy has broken, the first few of them."""
    broken = [row for row in results if row.error]
    for row in broken[:10]:
        print(f"policy error: {row.policy}, {row.condition}, seed {row.seed}: {row.error}")
    if len(broken) > 10:
        print(f"... and {len(broken) - 10} more; see the column error of episodes.csv")
