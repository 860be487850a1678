"""Learning curves of trainings: ``python -m train.curves NAME=RUN,RUN ... --out FILE``.

Success and time on development seeds against the time of training. A line is the mean over the
runs of a name, at their common evaluations; the band is its 95 % interval by Student's t, or, of
a run alone, Wilson's interval of its success.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.stats import sem
from scipy.stats import t as student
from tyro.conf import Positional

from asv_env.checks import choice
from asv_env.files import write
from asv_env.text import one_line
from asv_env.types import Float
from baselines.evaluate import statistics
from baselines.evaluate.report import look, palette
from baselines.rollout.commands import FilePath, command
from train import evaluation

CONFIDENCE = 0.95
SUFFIXES = (".png", ".svg", ".pdf")
SETTINGS = {"savefig.dpi": 150, "svg.hashsalt": "curves", "text.parse_math": False}


@dataclass(frozen=True)
class Curve:
    """Evaluations of several runs in one group of worlds."""

    minutes: Float  #: (n,) time of training, mean over the runs
    success: Float  #: (runs, n) fraction of successful episodes
    time: Float  #: (runs, n) median time of successful episodes, s
    episodes: int  #: number of episodes of an evaluation


def read(runs: Sequence[Path], num_boats: int, scenario: str) -> Curve:
    """Returns the curve of some runs.

    Raises:
        FileNotFoundError: a folder without evaluations.
        ValueError: runs without evaluations in such worlds.
    """
    tables = [_rows(run / "curve.csv", num_boats, scenario) for run in runs]
    common = sorted(set.intersection(*(set(table.index) for table in tables)))
    if not common:
        raise ValueError(f"no evaluations with {num_boats} boats, scenario {scenario!r}, in {runs}")

    def column(name: str) -> Float:
        return np.array([table.loc[common, name] for table in tables], dtype=float)

    minutes, episodes = column("seconds").mean(axis=0) / 60, int(tables[0]["episodes"].iloc[0])
    return Curve(minutes, column("success"), column("median_time"), episodes)


def _rows(file: Path, num_boats: int, scenario: str) -> pd.DataFrame:
    """Returns the rows of ``curve.csv`` in such worlds by their timesteps."""
    if not file.exists():
        raise FileNotFoundError(f"{file} does not exist: is its folder that of a run?")
    rows = evaluation.read_curve(file).set_index("timesteps")
    return rows[(rows["num_boats"] == num_boats) & (rows["scenario"] == scenario)]


def band(values: Float) -> tuple[Float, Float]:
    """Returns the 95 % interval (n,), (n,) of the mean of values (runs, n), over 2 runs or more."""
    half = student.ppf((1 + CONFIDENCE) / 2, len(values) - 1) * sem(values)
    return values.mean(axis=0) - half, values.mean(axis=0) + half


def draw(curves: dict[str, Curve], title: str) -> Figure:
    """Returns a figure of curves by name."""
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
    _style(left, "success on development seeds (%)")
    left.set_ylim(-3, 103)
    figure.legend(loc="outside lower center", ncols=min(len(curves), 2), frameon=False)
    _style(right, "median time of successes (s)")
    right.set_ylim(bottom=0)
    figure.suptitle(title, fontsize="medium")
    return figure


def _success_band(curve: Curve) -> tuple[Float, Float]:
    """Returns the 95 % interval (n,), (n,) of the success."""
    if len(curve.success) > 1:
        low, high = band(curve.success)
        return np.clip(low, 0, 1), np.clip(high, 0, 1)
    counts = np.round(curve.success[0] * curve.episodes).astype(int)
    trials = [np.arange(curve.episodes)[None] < count for count in counts]
    estimates = [statistics.proportion(trial) for trial in trials]
    return np.array([e.low for e in estimates]), np.array([e.high for e in estimates])


def _style(axes: Axes, name: str) -> None:
    axes.set_xlabel("training (min)")
    axes.set_ylabel(name)
    axes.set_xlim(left=0)
    axes.grid(color=palette.PALE, lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)


def plot(
    curves: Positional[tuple[str, ...]],
    out: FilePath,
    num_boats: int = 4,
    scenario: str = "noisy",
    title: str = "",
) -> None:
    """Draw learning curves: success and time of deliveries against minutes of training.

    Args:
        curves: Curves, each NAME=RUN,RUN with the folders of its runs.
        out: Picture to be written: .png, .svg or .pdf.
        num_boats: Team size of the worlds.
        scenario: Disturbances of the worlds.
        title: Title of the picture.
    """
    if not 1 <= len(curves) <= len(palette.SERIES):
        raise ValueError(f"{len(curves)} curves: 1 to {len(palette.SERIES)} fit into a picture")
    choice("kind of picture", out.suffix, SUFFIXES)
    found: dict[str, Curve] = {}
    for word in curves:
        name, equals, runs = word.partition("=")
        if not equals or os.path.exists(word):
            name = runs = word
        name = one_line(name)
        if name in found:
            raise ValueError(f"{word}: name each curve once")
        parts = [runs] if os.path.exists(runs) else runs.split(",")
        folders = [Path(os.path.expanduser(part)) for part in parts]
        found[name] = read(folders, num_boats, scenario)
    with look.settings(SETTINGS):
        figure = draw(found, one_line(title))
        nothing = {"Date": None} if out.suffix == ".svg" else {"CreationDate": None}
        metadata: Any = None if out.suffix == ".png" else nothing
        write(out, lambda part: figure.savefig(part, metadata=metadata))


main = command(plot, "python -m train.curves")

if __name__ == "__main__":
    main()
