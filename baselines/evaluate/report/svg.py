"""Figures as SVG elements of a page, with its fonts and its colours, light or dark."""

import io
import re
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from baselines.evaluate.report import palette
from baselines.evaluate.report.look import settings

HALF = 5.3  #: width of one of two figures side by side, inches
FEW = 400  #: largest number of marks in a panel that are drawn as vectors, not as pixels
PX_PER_INCH = 96  #: CSS pixels an inch
PT_PER_INCH = 72  #: points an inch, the unit of Matplotlib's SVG
DPI = 160  #: resolution of the parts that are kept as pixels
THEME = {
    palette.BLACK: "currentColor",
    palette.GREY: "var(--muted)",
    palette.PALE: "var(--rule)",
    "#ffffff": "var(--surface)",
}
"""Colours of figures that are replaced by those of the page."""

_SETTINGS: dict[str, Any] = {
    "svg.fonttype": "none",  # text stays text: it takes the page's font and can be searched
    "svg.hashsalt": "report",
    "path.simplify_threshold": 0.15,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.linewidth": 0.8,
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.titlesize": 9.5,
    "grid.color": palette.PALE,
    "grid.linewidth": 0.7,
    "legend.handlelength": 1.4,
    "lines.linewidth": 1.6,
    "lines.solid_capstyle": "round",
    "text.parse_math": False,  # names may have any letters
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("axes.edgecolor", "xtick.color", "ytick.color"), palette.GREY),
    **dict.fromkeys(("axes.labelcolor", "xtick.labelcolor", "ytick.labelcolor"), palette.BLACK),
    **dict.fromkeys(("font.size", "axes.labelsize"), 9.0),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8.5),
    **dict.fromkeys(("xtick.major.size", "ytick.major.size", "legend.borderaxespad"), 0.0),
    **dict.fromkeys(("xtick.major.pad", "ytick.major.pad", "axes.labelpad"), 5.0),
}


@dataclass(frozen=True)
class Svg:
    """The content of an ``svg`` element, with the size of its view box, points."""

    width: float
    height: float
    content: str

    @property
    def pixels(self) -> float:
        """Its natural width, CSS pixels."""
        return self.width / PT_PER_INCH * PX_PER_INCH


def look() -> AbstractContextManager[None]:
    """Returns the context in which the figures of a page are made and drawn."""
    return settings(_SETTINGS)


def draw(figure: Figure, name: str) -> Svg:
    """Returns a figure, made in the context ``look``, as SVG; its name is unique in the page."""
    file = io.StringIO()
    nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    figure.savefig(file, format="svg", dpi=DPI, transparent=True, metadata=nothing)
    drawn = _plain(file.getvalue())
    for colour, theme in THEME.items():
        drawn = drawn.replace(f": {colour}", f": {theme}")
    width, height = (side * PT_PER_INCH for side in figure.get_size_inches())
    return Svg(width, height, _unique_ids(drawn, name))


def _plain(text: str) -> str:
    """Returns the content of the ``svg`` element, without what a page does not need."""
    body = text[text.index(">", text.index("<svg")) + 1 : text.rindex("</svg>")]
    unused = r"<defs>\s*<style.*?</style>\s*</defs>|<metadata>.*?</metadata>|<!--.*?-->"
    body = re.sub(unused, "", body, flags=re.DOTALL)
    body = re.sub(r"font-family: [^;\"]*;? ?", "", body)
    body = re.sub(r' transform="rotate\(-0 [^)]*\)"', "", body)
    body = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(?<=\.\d\d)\d+", "", tag[0]), body)
    return re.sub(r"\s*\n\s*", " ", body).replace("> <", "><")


def _unique_ids(drawn: str, name: str) -> str:
    """Returns the drawing with ids that are unique in the page; unused ids are dropped."""
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', drawn))

    def renamed(match: re.Match[str]) -> str:
        found = match.group(1)
        return f' id="{name}-{found}"' if found in used else ""

    drawn = re.sub(r' id="([^"]*)"', renamed, drawn)
    return re.sub(r'(xlink:href="|url\()#', rf"\1#{name}-", drawn)
