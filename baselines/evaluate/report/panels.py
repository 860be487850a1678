"""Empty figures of the report, with one panel or a panel a policy, and their legends and labels."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

HALF = 5.3
"""Width of one of two figures side by side, inches."""
WIDE = 8.6
"""Width of a figure of bars, inches."""
FULL = 10.9
"""Width of a row of panels, inches."""
FEW = 400
"""Largest number of marks in a panel that are drawn as vectors, not as pixels."""
PERCENT = (0.0, 100.0)
"""Limits of an axis in percent."""
FIFTHS = range(0, 101, 20)
"""Ticks of an axis in percent."""
COLUMNS = 4
"""Largest number of panels side by side; five policies have three and two."""
TITLE = 0.28
"""Space above a panel, inches."""
FOOT = 0.5
"""Space below a panel, inches."""
LEFT = 0.75
"""Space left of the panels, inches."""
GAP = 0.1
"""Space around the panels where there are several rows of them, inches."""


def single(width: float, height: float) -> tuple[Figure, Axes]:
    """Returns a figure of one panel; sizes in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def legend(figure: Figure, axes: Axes, columns: int = 5) -> None:
    """Puts the legend above the panel."""
    handles, labels = axes.get_legend_handles_labels()
    above: Any = "outside upper left"  # missing from the type stubs
    figure.legend(handles, labels, loc=above, ncols=min(columns, len(labels)))


def label_rows(axes: Axes, labels: Sequence[str]) -> None:
    """Labels one row a label, from the top down."""
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")


def by_policy(policies: Sequence[str], aspect: float) -> tuple[Figure, dict[str, Axes]]:
    """Returns a figure with a panel a policy, each ``aspect`` times as high as it is wide."""
    count = len(policies)
    columns = count if count <= COLUMNS else -(-count // 2)
    rows = -(-count // columns)
    width = HALF if count == 1 else min(FULL, columns * 3.6)
    height = TITLE + aspect * ((width - LEFT) / columns - 0.06)
    figure = Figure(figsize=(width, rows * height + (rows + 1) / 2 * FOOT))
    figure.set_layout_engine("constrained", h_pad=GAP if rows > 1 else 0.04)
    axes = list(figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).flat)
    for unused in axes[count:]:
        unused.remove()
    return figure, dict(zip(policies, axes, strict=False))


def label(panels: Mapping[str, Axes], x: str, y: str) -> None:
    """Labels the x axis of all panels, and the y axis of those in the first column."""
    for axes in panels.values():
        place = axes.get_subplotspec()
        assert place is not None
        axes.set_xlabel(x)
        if place.is_first_col():
            axes.set_ylabel(y)
        axes.tick_params(labelbottom=True)
