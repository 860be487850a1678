"""The report in Markdown: its tables and words, without figures."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from baselines.evaluate.report import words
from baselines.evaluate.results import Results
from baselines.evaluate.tables import table
from baselines.evaluate.tables.table import Table


def document(results: Results, summary: Mapping[str, Any]) -> str:
    """The whole report."""
    parts = [f"# {summary['suite']}", summary["about"], f"{words.ran(results, summary)}."]
    parts += [
        _list(
            f"`{name}`: {words.policy(prints, name)}"
            for name, prints in summary["policies"].items()
        )
    ]
    parts += ["## Results", *_shown(table.results(summary), "results")]
    parts += _shown(table.measures(summary), "measures")
    compared = table.comparisons(summary)
    if compared.rows:
        first = results.policies[0]
        parts += [f"## Compared with {first}", *_shown(compared, "comparisons", first)]
    disturbed = table.controls(summary)
    if disturbed.rows:
        parts += ["## Compared with the control", *_shown(disturbed, "controls")]
    parts += ["## Conditions"]
    for name, about in words.conditions(results).items():
        parts += [f"### {name}", f"{about}.", markdown(table.of_condition(summary, name))]
    lines = words.broken(results)
    if lines:
        parts += ["## Broken episodes", words.BROKEN, _list(lines)]
    parts += ["## Methods", _list(words.METHODS), "## Origin", _origin(summary)]
    return "\n\n".join(parts) + "\n"


def markdown(shown: Table) -> str:
    """A table; columns of words are flush left."""
    return grid(shown.titles, shown.rows, [one.title for one in shown.columns if one.words])


def grid(heads: Sequence[str], rows: Sequence[Sequence[str]], left: Collection[str] = ()) -> str:
    """Cells as a table.

    Args:
        heads: of the columns.
        rows: of as many cells.
        left: heads of the columns that are flush left, not right.
    """
    rules = [":--" if head in left else "--:" for head in heads]
    lines = [[_inert(cell) for cell in line] for line in (heads, *rows)]
    lines.insert(1, rules)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _inert(text: str) -> str:
    """Text that does not end its cell."""
    return " ".join(text.replace("|", "\\|").split())


def _shown(shown: Table, name: str, first: str = "") -> list[str]:
    return [words.TABLES[name].format(first=first), markdown(shown)]


def _list(lines: Iterable[str]) -> str:
    return "\n".join(f"- {line}" for line in lines)


def _origin(summary: Mapping[str, Any]) -> str:
    origin = summary["origin"]
    libraries = ", ".join(f"{k} {v}" for k, v in origin["set of libraries"].items())
    return _list(
        [
            f"set of episodes: `{origin['set of episodes']}`",
            f"state of the code: `{origin['state of the code']}`",
            f"libraries: {libraries}",
        ]
    )
