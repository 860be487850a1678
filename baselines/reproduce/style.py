"""The look of all figures: sizes, fonts, colours, and how a figure is saved."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from asv_env.files import write
from baselines.evaluate.report import look, palette

COLUMN = 88.0  #: width of one column of a journal, mm
PAGE = 180.0  #: width of two columns of a journal, mm
INCH = 25.4  #: length of an inch, mm
DPI = 200
SUFFIXES = (".png", ".pdf")
MAP = "viridis"

_SETTINGS: dict[str, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    **dict.fromkeys(("font.size", "axes.labelsize", "axes.titlesize"), 8.0),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 7.0),
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    **dict.fromkeys(("axes.linewidth", "xtick.major.width", "ytick.major.width"), 0.6),
    "lines.linewidth": 1.0,
    "patch.linewidth": 0.8,
    "savefig.dpi": DPI,
    "savefig.bbox": "tight",  # without the margin that maps of one scale leave
    "savefig.pad_inches": 0.02,
    "pdf.fonttype": 42,  # fonts are embedded as outlines that stay text
}


def applied() -> AbstractContextManager[None]:
    """Returns the context in which figures are made and saved."""
    return look.settings(_SETTINGS)


def panels(
    width: float, height: float, rows: int = 1, columns: int = 1, **subplots: Any
) -> tuple[Figure, list[Axes]]:
    """Returns a figure of ``width`` x ``height`` mm and its panels, row by row, with letters."""
    figure = Figure(figsize=(width / INCH, height / INCH), layout="compressed")
    axes = list(figure.subplots(rows, columns, squeeze=False, **subplots).flat)
    if len(axes) > 1:
        for letter, panel in zip("abcdefghijklmnop", axes, strict=False):
            panel.set_title(f"({letter})", loc="left")
    return figure, axes


def legend(figure: Figure, *axes: Axes) -> None:
    """Draws the legend of some panels above all of them."""
    entries = [panel.get_legend_handles_labels() for panel in axes]
    handles: list[Any] = [handle for entry in entries for handle in entry[0]]
    labels: list[Any] = [label for entry in entries for label in entry[1]]
    columns = len(labels) if len(labels) < 5 else len(labels) // 2
    above: Any = "outside upper center"  # which the stubs do not know
    figure.legend(handles, labels, loc=above, ncols=columns)


def save(figure: Figure, stem: Path) -> None:
    """Saves a figure as PNG and as PDF, without the time, so that equal figures are equal files."""
    metadata: dict[str, Any] = {".pdf": {"CreationDate": None}}
    for suffix in SUFFIXES:
        save = partial(figure.savefig, metadata=metadata.get(suffix))
        write(stem.with_suffix(suffix), save)


def boat_colours(team: int) -> Sequence[Any]:
    """Returns a colour for each boat, in the order of their slots along the hull."""
    if team <= len(palette.SERIES):
        return palette.SERIES[:team]
    return list(matplotlib.colormaps[MAP](np.linspace(0.0, 0.9, team)))
