"""Comparisons from Python, for scripts and notebooks: ``compare`` and what it returns."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import joblib
import pandas as pd
from matplotlib.figure import Figure

from asv_env.checks import choice
from asv_env.files import write_text
from asv_env.numerics import numerics
from asv_env.params import EnvParams
from baselines.evaluate import suites
from baselines.evaluate.conditions import CUSTOM, Condition, Suite
from baselines.evaluate.policy_sources import PolicyLike, check_not_importing, named
from baselines.evaluate.report import charts, document, svg
from baselines.evaluate.request import MOST_EPISODES, REPLAYS, Request, check_whole, collect, run
from baselines.evaluate.results import Results, frame, write_csv
from baselines.evaluate.store import Store
from baselines.evaluate.summary import MEASURES, summarise
from baselines.evaluate.tables import descriptions, formats
from baselines.evaluate.workers import WorkerError
from baselines.rollout import film, trajectories
from baselines.rollout.process_state import neutral


class InputError(ValueError):
    """An argument cannot be used; nothing was run, and no results were changed."""


class StoppedError(RuntimeError):
    """A comparison could not be finished; the finished episodes of its folder are kept."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Result of ``compare``: the episodes of all policies, and statistics of them."""

    request: Request  #: what was compared
    results: Results  #: rows of the episodes by condition, policy and training
    summary: Mapping[str, Any]  #: success, measures and comparisons, as in summary.json

    @property
    def episodes(self) -> pd.DataFrame:
        """All episodes, one a row, with the columns of ``episodes.csv``."""
        return frame(self.results)

    def table(self) -> pd.DataFrame:
        """Returns a row for each condition and policy.

        Columns: ``episodes``, ``trainings``; ``success`` with its 95 % interval from
        ``success_low`` to ``success_high``; and the medians of the measures, in SI units.
        """
        rows = {}
        for condition, entry in self.summary["conditions"].items():
            for policy, found in entry["policies"].items():
                share = found["success"]
                rows[condition, policy] = {
                    **{name: found[name] for name in ("episodes", "trainings")},
                    "success": share["value"],
                    **{f"success_{bound}": share[bound] for bound in formats.BOUNDS},
                    **{name: found[name]["median"] for name in MEASURES if name in found},
                }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis(["condition", "policy"])

    def plot(self, chart: str = "overview", condition: str | None = None) -> Figure:
        """Returns a chart of the report as a Matplotlib figure; ValueError for an unknown name.

        Args:
            chart: "overview" of all conditions, or of one condition "profile", "times",
                "failures", "errors" or "goals".
            condition: its name; the first by default.
        """
        with svg.look():
            if chart == "overview":
                return charts.overview(self.results, self.summary).figure
            chosen = self._condition(condition)
            drawn = {each.name: each for each in charts.of_condition(self.results, chosen, {})}
        return drawn[choice("chart", chart, ["overview", *drawn])].figure

    def film(self, path: Path, policy: str | None = None, condition: str | None = None) -> None:
        """Films the first episode of a policy in a condition, by default the first of each.

        The path ends in ".gif" or ".mp4".
        """
        policies = self.request.policies
        source = policies[choice("policy", policy or next(iter(policies)), policies)][0]
        film.save(
            Path(path).expanduser(),
            source.factory,
            self._condition(condition).params,
            self.results.suite.seed,
        )

    def _condition(self, name: str | None) -> Condition:
        """Returns the condition of a name, the first one by default."""
        by_name = {one.name: one for one in self.results.suite.conditions}
        return by_name[choice("condition", name or next(iter(by_name)), by_name)]

    def __str__(self) -> str:
        return descriptions.text_table(self.summary)

    def _repr_html_(self) -> str:
        """Returns the table of results as a notebook shows it."""
        shown = descriptions.results(self.summary)
        whole = {"max_colwidth": None, "max_columns": None, "max_rows": None}
        options = {f"display.{name}": value for name, value in whole.items()}
        with pd.option_context({**options, "display.html.use_mathjax": False}):
            return pd.DataFrame(shown.rows, columns=shown.titles).to_html(index=False, border=1)


def compare(
    policies: Mapping[str, PolicyLike],
    suite: str | Suite | Condition | EnvParams | Sequence[Condition] = "quick-v2",
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
    """Runs policies on the same seeded episodes and compares them.

    Args:
        policies: policies by the names that tables show. Each is a registered name ("scripted"), a
            policy file, "module:Class", or a class or function ``EnvParams -> Policy``; a list of
            these is one policy that was trained several times. All are compared with the first.
        suite: name of a suite, a Suite, one or several Conditions, or an environment's parameters.
        episodes: number of episodes of each condition; None takes the suite's.
        out: folder for the episodes, the summary and the report. Episodes that it holds from the
            same code are kept, and only missing ones are run. None keeps no files.
        task: task that replaces that of the suite: a name, "module:NAME" or a Task.
        workers: number of worker processes; None is one per core, 0 runs everything in the
            current process, for a debugger, which a policy may crash. The results do not depend on
            it.
        num_envs: number of worlds that a process runs at once. The results do not depend on it.
        replays: number of episodes of each condition that the report can replay, the first ones;
            up to as many failed episodes are added.
        record: whether to save trajectories for imitation learning, below ``out``.
        overwrite: whether to replace results in ``out`` that were made by other code, of another
            suite or by another policy of the same name; otherwise they are an error.
        trust_pickles: whether to read stable-baselines3 models, which runs any code in them.
        progress: whether to show a progress bar.

    Returns:
        Comparison with ``table()``, ``episodes``, ``summary``, ``plot()`` and ``film()``.

    Raises:
        InputError: a policy, a suite, a number or a folder that cannot be used.
        StoppedError: a worker died, or the disk is full.
    """
    with refusing():
        check_not_importing()
        if record and out is None:
            raise ValueError("record=True: trajectories need a folder (out=...)")
        scratch = TemporaryDirectory(prefix="asv-env-") if out is None else nullcontext(out)
    with neutral(), numerics(), scratch as folder:
        with refusing():
            chosen, sources = _suite(suite, episodes, task), named(policies, trust_pickles)
            workers = joblib.cpu_count() if workers is None else workers
            replays = REPLAYS // len(chosen.conditions) if replays is None else replays
            request = Request(
                chosen, sources, _folder(folder), workers, num_envs, replays, record, overwrite
            )
            store = Store(request.out, request.provenance, request.fingerprints, overwrite)
            for policy in store.dropped:
                trajectories.remove(request.out, policy)
        with closing(store):
            try:
                run(request, store, progress)
                comparison = _comparison(request, store)
                if out is not None:
                    results, summary = comparison.results, comparison.summary
                    write_csv(request.out / "episodes.csv", results)
                    write_text(request.out / "summary.json", json.dumps(summary, indent=2) + "\n")
                    document.write(request.out, results, summary, store, request.replays)
            except (WorkerError, OSError) as error:
                raise StoppedError(str(error)) from error
    return comparison


@contextmanager
def refusing() -> Iterator[None]:
    """Turns whatever is wrong with the input into an InputError."""
    try:
        yield
    except (ValueError, TypeError, OSError, ImportError) as error:
        raise InputError(str(error)) from error


def _folder(given: str | Path) -> Path:
    """Returns the absolute path of an output folder: a policy may change the current folder."""
    if not os.fspath(given):
        raise ValueError("out='': name a folder")
    return Path(os.path.expanduser(given)).absolute()


def _suite(given: Any, episodes: int | None, task: Any) -> Suite:
    """Returns the suite with as many episodes and the task that were asked for."""
    suite = suites.find(given)
    if task is not None:
        suite = suite.with_task(task)
    if episodes is None:
        return suite
    check_whole("episodes", episodes, 1, MOST_EPISODES)
    if episodes > suite.episodes and suite.name != CUSTOM:
        raise ValueError(
            f"episodes={episodes}: {suite.name} has {suite.episodes} of each condition"
        )
    return suite.first(int(episodes))


def _comparison(request: Request, store: Store) -> Comparison:
    results, suite = collect(request, store), request.suite
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
