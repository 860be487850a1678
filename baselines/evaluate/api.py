"""Compares policies from Python, for scripts and notebooks: ``compare``."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from asv_env.params import EnvParams
from baselines.evaluate import execution, suites
from baselines.evaluate.comparison import Comparison
from baselines.evaluate.conditions import CUSTOM, Condition, Suite
from baselines.evaluate.named_policies import PolicyLike, named
from baselines.evaluate.report import document
from baselines.evaluate.request import REPLAYS, Request, check_least, cores
from baselines.evaluate.results import write_csv
from baselines.evaluate.store import Store
from baselines.evaluate.summary import summarise
from baselines.evaluate.workers import WorkerError
from baselines.rollout import trajectories
from baselines.rollout.files import write_text


class InputError(ValueError):
    """Something that was asked for is wrong; nothing was run, nothing is lost."""


class StoppedError(RuntimeError):
    """A comparison could not be finished; the finished episodes of its folder are kept."""


def compare(
    policies: Mapping[str, PolicyLike],
    suite: str | Suite | Condition | EnvParams | Sequence[Condition] = "quick-v1",
    episodes: int | None = None,
    out: str | Path | None = None,
    *,
    task: Any = None,
    workers: int | None = None,
    num_envs: int = 64,
    replays: int | None = None,
    record: bool = False,
    overwrite: bool = False,
    trust_pickles: bool = False,
    progress: bool = True,
) -> Comparison:
    """Runs policies on the same seeded episodes and returns how they compare.

    Args:
        policies: by name, each a registered name ("scripted"), a policy file, "module:Class", a
            class or function ``EnvParams -> Policy``, or a list of these: several trainings. The
            others are compared with the first.
        suite: name of a suite, a Suite, Conditions of your own, or an environment's parameters.
        episodes: number of episodes of each condition, the first ones; None takes the suite's.
        out: folder for all files and the report. What it holds already, made by the same code, is
            kept, and only what is missing is run. None leaves no files.
        task: runs the suite with another task: a name, "module:NAME" or a Task.
        workers: number of processes, None one a core; 0 runs everything in this one, for a
            debugger.
        num_envs: number of worlds side by side in a process.
        replays: number of first episodes of each condition that can be watched in the report;
            where policies fail, up to as many again are added.
        record: save trajectories too, for imitation learning.
        overwrite: replace what is in the way in the folder.
        trust_pickles: read stable-baselines3 models; doing so runs whatever code is in them.
        progress: show a progress bar.

    Raises:
        InputError: a policy, a suite, a number or a folder that cannot be used.
        StoppedError: a worker died, or the disk is full.
    """
    with TemporaryDirectory(prefix="asv-env-") as scratch:
        with _refusing():
            if record and out is None:
                raise ValueError("record=True: trajectories need a folder (out=...)")
            chosen = _suite(suite, episodes, task)
            request = Request(
                chosen,
                named(policies, trust_pickles),
                Path(scratch if out is None else out),
                cores() if workers is None else workers,
                num_envs,
                REPLAYS // len(chosen.conditions) if replays is None else replays,
                record,
                overwrite,
            )
            store = Store(request.out, request.provenance, request.fingerprints, overwrite)
            for policy in store.dropped:
                trajectories.remove(request.out, policy)
        with closing(store):
            try:
                execution.run(request, store, progress)
            except (WorkerError, OSError) as error:
                raise StoppedError(str(error)) from error
            comparison = _comparison(request, store)
            if out is not None:
                _save(request, store, comparison)
    return comparison


@contextmanager
def _refusing() -> Iterator[None]:
    """Turns whatever is wrong with the input into an InputError."""
    try:
        yield
    except (ValueError, TypeError, OSError, ImportError) as error:
        raise InputError(str(error)) from error


def _suite(given: Any, episodes: int | None, task: Any) -> Suite:
    """Returns the suite with as many episodes and the task that were asked for."""
    suite = suites.find(given)
    if task is not None:
        suite = suite.with_task(task)
    if episodes is None:
        return suite
    check_least("episodes", episodes, 1)
    if episodes > suite.episodes and suite.name != CUSTOM:
        raise ValueError(
            f"episodes={episodes}: {suite.name} has {suite.episodes} of each condition"
        )
    return suite.first(episodes)


def _comparison(request: Request, store: Store) -> Comparison:
    results = execution.collect(request, store)
    suite = request.suite
    summary = {
        "suite": suite.name,
        "about": suite.about,
        "episodes": suite.episodes,
        "seeds": [suite.seeds[0], suite.seeds[-1]],
        "provenance": request.provenance,
        "policies": request.fingerprints,
        **summarise(results),
    }
    return Comparison(request, results, summary)


def _save(request: Request, store: Store, comparison: Comparison) -> None:
    """Writes the files of the folder."""
    results, summary = comparison.results, comparison.summary
    write_csv(request.out / "episodes.csv", results)
    text = json.dumps(summary, indent=2) + "\n"
    write_text(request.out / "summary.json", text)
    document.write(request.out, results, summary, store, request.replays)
