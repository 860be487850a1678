"""The file ``curve.csv`` of a run: a row for each evaluation in one group of worlds."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from baselines.rollout.files import write_text
from train.evaluation import Score

COLUMNS = [f.name for f in fields(Score)]


def read(file: Path) -> list[dict[str, str]]:
    """Returns the rows of the file; none where it does not exist yet."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as text:
        return list(csv.DictReader(text))


def append(file: Path, scores: Sequence[Score]) -> None:
    """Adds the rows of an evaluation."""
    _write(file, [*read(file), *map(asdict, scores)])


def last_timesteps(file: Path) -> int:
    """Returns the timesteps of the last evaluation; 0 where there is none."""
    return max((int(row["timesteps"]) for row in read(file)), default=0)


def truncate(file: Path, timesteps: int) -> None:
    """Drops the rows later than ``timesteps``, which a resumed training evaluates again."""
    rows = read(file)
    kept = [row for row in rows if int(row["timesteps"]) <= timesteps]
    if len(kept) < len(rows):
        _write(file, kept)


def _write(file: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS)
    writer.writeheader()
    writer.writerows(rows)
    write_text(file, text.getvalue())
