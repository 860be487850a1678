"""The colours of all figures and pages: Okabe and Ito's, distinct to colour-blind readers too."""

from collections.abc import Iterable
from itertools import cycle

BLACK, GREY, PALE = "#000000", "#7f7f7f", "#d9d9d9"
BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#E69F00", "#009E73", "#CC79A7"
SKY, VERMILLION = "#56B4E9", "#D55E00"
SERIES = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY)  #: colours of curves and policies, in order


def by_policy(policies: Iterable[str]) -> dict[str, str]:
    """Returns the colours of policies, by name; they follow from the order."""
    return dict(zip(policies, cycle(SERIES), strict=False))
