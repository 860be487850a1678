"""Page of the model cards of the learned policies: how each network was trained."""

from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from asv_env.tasks import TASKS
from baselines.evaluate.tables.formats import share
from baselines.evaluate.tables.table import grid
from baselines.learned import policy_file

TITLE = "# The learned policies"
INTRODUCTION = """\
The files in this folder are `learned` in the comparison. They hold numbers only and run without
torch. This page is written by `python -m baselines.evaluate.publish` from the metadata of the
files; their results on the suites are in [docs/results](../../../docs/results/README.md), how such
files are made in [docs/learned.md](../../../docs/learned.md).

A *step* is a decision of a single boat. *Success* and *time* (median) are those of the last
evaluation on development seeds, in the task of that training, noisy first; of many combinations of
team and scenario, the median and the range. A file in the second column had no model card.
"""
NOT_YET = """\
This folder is for the files of the policy `learned`, and holds none yet:
[docs/learned.md](../../../docs/learned.md) tells how to train them.
"""
MOST = 5  #: largest number of evaluations that are listed one by one
HEADS = (
    *("training", "begins with", "scenarios", "boats", "steps", "minutes", "seeds of its worlds"),
    *("success", "time [s]"),
)


def page(folder: Path) -> str:
    """Returns the model cards of all policy files in a folder, in Markdown."""
    files = sorted(folder.glob(f"*{policy_file.SUFFIX}"))
    parts = [TITLE, (INTRODUCTION if files else NOT_YET).strip()]
    for file in files:
        tasks = [name.capitalize() for name, t in TASKS.items() if policy_file.file_for(t) == file]
        parts += [f"## {file.name}", f"For {' and '.join(tasks)}; {file.stat().st_size:,} bytes."]
        for card in of_networks(file):
            parts.append(grid(HEADS, map(_line, trainings(card)), left=HEADS[:3]))
    return "\n\n".join(parts) + "\n"


def of_networks(file: Path) -> list[dict[str, Any]]:
    """Returns the model card of each network of a policy file."""
    _, card = policy_file.read(file)
    cards: list[dict[str, Any]] = card.get("phases", [card])
    return cards


def trainings(card: dict[str, Any]) -> list[dict[str, Any]]:
    """Returns the model cards of all trainings that led to a network, the first one first."""
    before = card.get("began_with")
    return [*(trainings(before) if before else []), card]


def _line(card: dict[str, Any]) -> list[str]:
    options, scores = card["options"], card["development"]
    worlds = options["worlds"]
    begins = "imitation of `scripted`" if options["imitation"]["rounds"] else "nothing"
    if options["init_from"]:
        begins = "the one above" if card.get("began_with") else f"`{options['init_from']}`"
    first, last = card["training_seeds"]
    return [
        options["task"],
        begins,
        ", ".join(worlds["scenarios"]),
        ", ".join(map(str, worlds["teams"])),
        f"{card['timesteps'] / 1e6:.1f} M",
        f"{scores[0]['seconds'] / 60:.0f}",
        f"{first:,} to {last:,}",
        _listed([score["success"] for score in scores], share),
        _listed([score["median_time"] for score in scores], "{:.1f}".format),
    ]


def _listed(values: Sequence[float], text: Callable[[float], str]) -> str:
    """Returns the values of some evaluations; of many, the median and the range."""
    if len(values) <= MOST:
        return ", ".join(map(text, values))
    return f"{text(median(values))} ({text(min(values))} to {text(max(values))})"
