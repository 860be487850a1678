"""Page of the model card of the learned policy: how it was trained, and what it reached then."""

import math
from collections.abc import Collection
from pathlib import Path
from typing import Any

from baselines.evaluate.tables import formats
from baselines.evaluate.tables.table import grid
from baselines.learned import team_policy

TITLE = "# The learned policy"
INTRODUCTION = """\
`{name}` ({size:,} bytes) is `learned` in the comparison. It holds numbers only and runs without
torch. This page is written by `python -m baselines.evaluate.publish` from the model card in the
file; results on the suites are in [docs/results](../../../docs/results/README.md), how such a file
is made in [docs/learned.md](../../../docs/learned.md).
"""
NOT_YET = """\
This folder is for the file of the policy `learned`, and holds none yet:
[docs/learned.md](../../../docs/learned.md) tells how to train it.
"""
SCORES = """\
Success in the last evaluation of the training, on development seeds, all of it in kinds of worlds
that it was trained on. *Time*, *distance* and *heading* are medians of the successful episodes.
"""
HEADS = (
    *("task", "boats", "scenario", "hull", "episodes", "success"),
    *("time [s]", "distance [cm]", "heading [rad]"),
)


def page(file: Path) -> str:
    """Returns the model card of a policy file in Markdown."""
    if not file.exists():
        return f"{TITLE}\n\n{NOT_YET}"
    _, card = team_policy.read(file)
    introduction = INTRODUCTION.format(name=file.name, size=file.stat().st_size)
    facts = grid(("training", ""), _facts(card), left=("training", ""))
    lines = [_line(score) for score in card["development"]]
    scores = grid(HEADS, lines, left=("task", "scenario", "hull"))
    return "\n".join((f"{TITLE}\n", introduction, f"{facts}\n", SCORES, scores)) + "\n"


def _facts(card: dict[str, Any]) -> list[tuple[str, str]]:
    """Returns how a policy was trained, as names and values."""
    options, (first, last) = card["options"], card["training_seeds"]
    software = [
        f"{one['revision'] or 'unknown'} (instructions {one['code']}), torch "
        f"{one['libraries']['torch']}, Python {one['python']}, {one['machine']}"
        for one in card["software"]
    ]
    return [
        ("command", f"`{card['command']}`"),
        ("kind", f"imitation of `allocation`, {card['rounds']} of {options['rounds']} rounds"),
        ("decisions", f"{card['decisions'] / 1e6:.1f} M of single boats"),
        ("time", f"{card['seconds'] / 3600:.1f} h"),
        ("seeds of its worlds", f"{first:,} to {last:,}"),
        ("tasks", _listed(options["tasks"])),
        ("boats", _listed(sorted(options["teams"]))),
        ("scenarios", _listed(options["scenarios"])),
        ("hulls", _listed(options["hulls"])),
        ("code", "; then ".join(software)),
    ]


def _listed(names: Collection[Any]) -> str:
    return ", ".join(map(str, dict.fromkeys(names)))


def _line(score: dict[str, Any]) -> list[str]:
    """Returns the line of an evaluation."""
    return [
        *(score["task"], str(score["num_boats"]), score["scenario"], score["vessel"]),
        *(str(score["episodes"]), formats.share(score["success"])),
        _median(score["median_time"], "s"),
        _median(score["position_error"], "cm", 100.0),
        _median(score["heading_error"], "rad"),
    ]


def _median(value: float, unit: str, scale: float = 1.0) -> str:
    """Returns a median, which is not a number where no episode succeeded or has such a value."""
    return formats.quantity(value if math.isfinite(value) else None, unit, scale)
