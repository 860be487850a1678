"""Figures as drawings inside a page: they take its fonts, and its colours in light and dark."""

from __future__ import annotations

import html
import io
import re
from contextlib import AbstractContextManager
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from baselines.evaluate.report import palette

PX_PER_INCH, PT_PER_INCH = 96, 72
DPI = 160
"""Of what is kept as pixels."""
SMALLEST = 0.63
"""Share of its size below which a drawing is not shrunk, so that it can be read on a phone."""
THEME = {
    palette.BLACK: "currentColor",
    palette.GREY: "var(--muted)",
    palette.PALE: "var(--rule)",
    "#ffffff": "var(--card)",
}
"""Colours of figures that are those of the page."""

_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text: it takes the page's font and can be searched
    "svg.hashsalt": "report",
    "text.parse_math": False,  # names may have any letters
    "path.simplify_threshold": 0.15,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": palette.GREY,
    "axes.linewidth": 0.8,
    "axes.labelsize": 9.0,
    "axes.labelcolor": palette.BLACK,
    "axes.labelpad": 5.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": palette.PALE,
    "grid.linewidth": 0.7,
    "xtick.color": palette.GREY,
    "ytick.color": palette.GREY,
    "xtick.labelcolor": palette.BLACK,
    "ytick.labelcolor": palette.BLACK,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.major.size": 0.0,
    "ytick.major.size": 0.0,
    "xtick.major.pad": 5.0,
    "ytick.major.pad": 5.0,
    "font.size": 9.0,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "legend.borderaxespad": 0.0,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
}


def look() -> AbstractContextManager[None]:
    """The context in which the figures of a page are made and drawn."""
    return matplotlib.rc_context(_SETTINGS)  # type: ignore[arg-type]


def inline(figure: Figure, name: str, about: str) -> str:
    """A figure as an ``svg`` element.

    Args:
        figure: made in the ``look`` of a page.
        name: unique in its page; letters, digits and hyphens.
        about: what a reader who does not see it is told.
    """
    file = io.StringIO()
    nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    figure.savefig(file, format="svg", dpi=DPI, transparent=True, metadata=nothing)
    drawn = _plain(file.getvalue())
    for colour, theme in THEME.items():
        drawn = drawn.replace(f": {colour}", f": {theme}")
    wide, high = (side * PT_PER_INCH for side in figure.get_size_inches())
    size = wide / PT_PER_INCH * PX_PER_INCH
    return (
        f'<svg class="chart" role="img" aria-label="{html.escape(about)}" '
        f'viewBox="0 0 {wide:g} {high:g}" '
        f'style="max-width: {size:.0f}px; min-width: {size * SMALLEST:.0f}px">'
        f"{_own_names(drawn, name)}</svg>"
    )


def _plain(text: str) -> str:
    """What is inside the ``svg`` element, without what a page does not need."""
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", body, flags=re.DOTALL)
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    body = re.sub(r"<!--.*?-->", "", body, flags=re.DOTALL)
    body = re.sub(r"font-family: [^;\"]*;? ?", "", body)
    body = re.sub(r' transform="rotate\(-0 [^)]*\)"', "", body)
    body = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(?<=\.\d\d)\d+", "", tag[0]), body)
    return re.sub(r"\s*\n\s*", " ", body).replace("> <", "><")


def _own_names(drawn: str, name: str) -> str:
    """The drawing with names that no other one in the page has, only where they are used."""
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', drawn))

    def own(match: re.Match[str]) -> str:
        found = match.group(1)
        return f' id="{name}-{found}"' if found in used else ""

    drawn = re.sub(r' id="([^"]*)"', own, drawn)
    return re.sub(r'(xlink:href="|url\()#', rf"\1#{name}-", drawn)
