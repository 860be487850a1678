"""Describes the suites, with pictures: ``python -m baselines.evaluate.publish.gallery``.

The page lists the conditions of every suite, its seeds and its digest. A picture shows the first
initial states of conditions that look different.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from asv_env import files
from asv_env.params import EnvParams
from asv_env.render.viewer import Viewer
from asv_env.simulation import Simulation
from asv_env.types import Frame
from baselines.evaluate.conditions import Condition, Suite
from baselines.evaluate.suites import PUBLISHED
from baselines.evaluate.tables.formats import NOTHING
from baselines.evaluate.tables.table import grid
from baselines.rollout.commands import FilePath, command

PROGRAM = "python -m baselines.evaluate.publish.gallery"
SIDE = 400  #: width and height of the picture of a condition, px
COLUMNS, LARGEST = 3, 6  #: pictures in a row, and of a suite
LABEL = 34  #: height of the label below a picture, px
GAP = 12  #: space round pictures, px
INTRODUCTION = f"""\
# The suites

Written by `{PROGRAM}`. A suite is a set of seeded episodes that never
changes: its digest covers all parameters and the first initial states, and tests compare it. What
is marked *unseen* is out of distribution: no training may contain it. The pictures show first
initial states of conditions that look different. [Evaluation](evaluation.md) tells how suites are
run and what is computed from them.
"""


@dataclass(frozen=True)
class Options:
    """Files that are written."""

    page: FilePath = Path("docs/suites.md")  # the page; pictures lie in the folder of its name


def page(suites: Iterable[Suite], folder: str) -> str:
    """Returns the text of the page, whose pictures lie in a folder beside it."""
    parts = [INTRODUCTION.strip()]
    for suite in suites:
        first, last = suite.seeds[0], suite.seeds[-1]
        parts += [
            f"## {suite.name}",
            f"{suite.about} {len(suite.conditions)} conditions of {suite.episodes:,} episodes, "
            f"seeds {first} to {last}; digest `{suite.digest()}`.",
            f"![First initial states]({folder}/{suite.name}.png)",
            grid(
                ("condition", "what it is", "compared with", "boats"),
                [_line(condition) for condition in suite.conditions],
                left=("condition", "what it is", "compared with"),
            ),
        ]
    return "\n\n".join(parts) + "\n"


def _line(condition: Condition) -> list[str]:
    about = condition.about + " (*unseen*)" * condition.out_of_distribution
    boats = str(condition.params.num_boats)
    return [f"`{condition.name}`", about, condition.control or NOTHING, boats]


def pictured(suite: Suite) -> list[Condition]:
    """Returns conditions of a suite that look different, from the first to the last.

    They are spread evenly over those, ``LARGEST`` at most.
    """
    seen: list[Any] = []
    chosen = []
    for condition in suite.conditions:
        look = _look(condition.params)
        if look not in seen:
            seen.append(look)
            chosen.append(condition)
    places = np.linspace(0, len(chosen) - 1, min(LARGEST, len(chosen))).round().astype(int)
    return [chosen[place] for place in places]


def _look(params: EnvParams) -> tuple[Any, ...]:
    """Returns what decides how an initial state looks."""
    water = params.water.current, params.water.walls, params.water.gust_speed > 0
    hulls = tuple(params.vessel.corners), params.boat.length, params.variation.boat_size > 0
    return params.task.name, params.num_boats, hulls, water, params.obstacles, params.sensors.range


def frame(condition: Condition, seed: int) -> Frame:
    """Returns the picture (SIDE, SIDE, 3) of an initial state."""
    simulation = Simulation(condition.params)
    simulation.reset(seeds=[seed])
    drawn = Viewer(condition.params, size=(SIDE, SIDE)).draw(simulation.state)
    assert drawn is not None  # It is no window.
    return drawn


def picture(suite: Suite) -> Any:
    """Returns the picture of a suite, a Pillow image."""
    from PIL import Image, ImageDraw, ImageFont

    conditions = pictured(suite)
    columns = min(COLUMNS, len(conditions))
    rows = -(-len(conditions) // columns)
    across, down = SIDE + GAP, SIDE + LABEL + GAP
    image = Image.new("RGB", (columns * across + GAP, rows * down + GAP), "white")
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(19)
    for number, condition in enumerate(conditions):
        row, column = divmod(number, columns)
        left, top = GAP + column * across, GAP + row * down
        shown = np.ascontiguousarray(frame(condition, suite.seed))
        image.paste(Image.fromarray(shown), (left, top))
        place = left + SIDE / 2, top + SIDE + LABEL / 2
        draw.text(place, condition.name, "black", font, anchor="mm")
    return image


def write(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Writes the page and the pictures of all published suites.

    Raises:
        OSError: a file cannot be written.
    """
    _write(PUBLISHED, options.page)


def _write(suites: Sequence[Suite], target: Path) -> None:
    folder = target.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    for suite in suites:
        name = folder / f"{suite.name}.png"
        files.write(name, partial(picture(suite).save, format="PNG", optimize=True))
        print(f"{name}: written")
    files.write_text(target, page(suites, folder.name))
    print(f"{target}: written")


main = command(write, PROGRAM)

if __name__ == "__main__":
    main()
