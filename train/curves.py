"""Learning curves of one or several recipes: ``python -m train.curves NAME=RUN,RUN ... FILE``.

Success and time on development seeds against the time of training. A line is the mean over the
runs of a recipe, at their common evaluations; the band is its 95 % interval by Student's t, or, of
a run alone, Wilson's interval of its success.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.stats import t as student

from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.report import palette

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Curve:
    """Evaluations of the runs of a recipe in one group of worlds.

    Attributes:
        minutes: (n,) of training, mean over the runs.
        success: (runs, n) share of episodes.
        time: (runs, n) median of those that succeeded, s.
        episodes: of an evaluation.
    """

    minutes: Float
    success: Float
    time: Float
    episodes: int


def read(runs: Sequence[Path], num_boats: int, scenario: str) -> Curve:
    """The curve of some runs.

    Raises:
        FileNotFoundError: a folder without evaluations.
        ValueError: runs without evaluations in such worlds.
    """
    tables = [_rows(run / "curve.csv", num_boats, scenario) for run in runs]
    common = sorted(set.intersection(*map(set, tables)))
    if not common:
        raise ValueError(f"no evaluations with {num_boats} boats, scenario {scenario!r}, in {runs}")

    def column(name: str) -> Float:
        return np.array([[float(table[at][name]) for at in common] for table in tables])

    episodes = int(tables[0][common[0]]["episodes"])
    minutes = column("seconds").mean(axis=0) / 60
    return Curve(minutes, column("success"), column("median_time"), episodes)


def _rows(file: Path, num_boats: int, scenario: str) -> dict[int, dict[str, Any]]:
    """Rows of ``curve.csv`` in such worlds by their timesteps."""
    if not file.exists():
        raise FileNotFoundError(f"{file}: there is none; is its folder that of a run?")
    with file.open(newline="", encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    wanted = (str(num_boats), scenario)
    return {int(r["timesteps"]): r for r in rows if (r["num_boats"], r["scenario"]) == wanted}


def band(values: Float) -> tuple[Float, Float]:
    """95 % interval (n,), (n,) of the mean of values (runs, n) over two runs or more."""
    runs = len(values)
    half = student.ppf((1 + CONFIDENCE) / 2, runs - 1) * values.std(axis=0, ddof=1) / np.sqrt(runs)
    return values.mean(axis=0) - half, values.mean(axis=0) + half


def draw(curves: dict[str, Curve], title: str) -> Figure:
    """A figure of the curves of several recipes by name."""
    figure = Figure(figsize=(8, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    for colour, (name, curve) in zip(palette.SERIES[: len(curves)], curves.items(), strict=True):
        label = f"{name} ({len(curve.success)} runs)" if len(curve.success) > 1 else name
        left.plot(curve.minutes, 100 * curve.success.mean(axis=0), color=colour, label=label)
        low, high = _success_band(curve)
        left.fill_between(curve.minutes, 100 * low, 100 * high, color=colour, alpha=0.2, lw=0)
        right.plot(curve.minutes, np.mean(curve.time, axis=0), color=colour)
        if len(curve.time) > 1:
            right.fill_between(curve.minutes, *band(curve.time), color=colour, alpha=0.2, lw=0)
    _dress(left, "success on development seeds (%)")
    left.set_ylim(-3, 103)
    figure.legend(loc="outside lower center", ncols=min(len(curves), 2), frameon=False)
    _dress(right, "median time of successes (s)")
    right.set_ylim(bottom=0)
    figure.suptitle(title, fontsize="medium")
    return figure


def _success_band(curve: Curve) -> tuple[Float, Float]:
    if len(curve.success) > 1:
        low, high = band(curve.success)
        return np.clip(low, 0, 1), np.clip(high, 0, 1)
    counts = np.round(curve.success[0] * curve.episodes).astype(int)
    trials = [np.arange(curve.episodes) < count for count in counts]
    estimates = [statistics.proportion(trial[None]) for trial in trials]
    return np.array([one.low for one in estimates]), np.array([one.high for one in estimates])


def _dress(axes: Axes, name: str) -> None:
    axes.set_xlabel("training (min)")
    axes.set_ylabel(name)
    axes.set_xlim(left=0)
    axes.grid(color=palette.PALE, lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)


def main(arguments: Sequence[str] | None = None) -> None:
    """Draws what a command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m train.curves", description=__doc__)
    parser.add_argument("recipes", nargs="+", metavar="NAME=RUN,RUN", help="runs of a recipe")
    parser.add_argument("file", type=Path, help="picture: .png, .svg or .pdf")
    parser.add_argument("--num-boats", type=int, default=4, help="of the worlds (%(default)s)")
    parser.add_argument("--scenario", default="noisy", help="of the worlds (%(default)s)")
    parser.add_argument("--title", default="")
    options = parser.parse_args(arguments)
    if len(options.recipes) > len(palette.SERIES):
        parser.error(f"{len(options.recipes)} recipes: at most {len(palette.SERIES)} in a picture")
    try:
        curves = {}
        for word in options.recipes:
            name, _, runs = word.partition("=")
            folders = [Path(run) for run in (runs or name).split(",")]
            curves[name] = read(folders, options.num_boats, options.scenario)
        draw(curves, options.title).savefig(options.file, dpi=150)
    except (ValueError, OSError) as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
