"""The words and tables of a report, and its templates, filled in with Jinja2.

Web page and Markdown show the same. In both, what others have written is escaped.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from asv_env.text import one_line
from baselines.evaluate.conditions import Condition
from baselines.evaluate.results import Results
from baselines.evaluate.tables import descriptions, formats
from baselines.evaluate.tables import markdown as markdown_text
from baselines.policy import POLICIES

SHOWN = 20  #: largest number of broken episodes that are listed
BROKEN = (
    "In these episodes the policy raised an error or gave an invalid action. They count as "
    "failures."
)
"""Explanation of the list of broken episodes."""
METHODS = (
    "Every policy meets the same episodes: initial states, goals, disturbances and noise follow "
    "from the seed of an episode alone.",
    "Shares have Wilson's interval; means and interquartile means (IQM) one by bootstrap-t over "
    "the episodes. Times and errors count the episodes to which they apply: a policy that fails "
    "often has few times to goal.",
    "Where a policy was trained several times, trainings and episodes are crossed sources of "
    "variance, and the intervals widen with the differences between trainings: runs of many "
    "episodes do not replace many trainings.",
    "Policies are compared within episodes, so that what makes an episode hard for both cancels. "
    "To be sooner counts a failure as later than any success, and a tie as one half.",
    "McNemar's test is exact and two-sided; it compares two single policies and is not given where "
    "one was trained several times.",
    "Every interval and every p holds on its own; nothing is adjusted for multiple comparisons.",
)
"""How the numbers were computed, point by point."""


def markdown(results: Results, summary: Mapping[str, Any]) -> str:
    """Returns the report in Markdown: its tables and words, without figures."""
    return render("report.md", **content(results, summary))


def render(name: str, **values: Any) -> str:
    """Returns a template of the folder ``templates``, filled in with values."""
    return _environment().get_template(name).render(values)


def content(results: Results, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Returns what the templates of both reports show, by the names they use."""
    compared = (
        (f"Compared with {results.policies[0]}", descriptions.comparisons(summary)),
        ("Compared with the control", descriptions.controls(summary)),
    )
    libraries = summary["provenance"]["set of libraries"]
    return {
        "summary": summary,
        "ran": _ran(results, summary),
        "policies": {name: _policy(name, of) for name, of in summary["policies"].items()},
        "tables": [descriptions.results(summary), descriptions.measures(summary)],
        "comparisons": [(heading, shown) for heading, shown in compared if shown.rows],
        "conditions": [_condition(each, summary) for each in results.suite.conditions],
        "broken": broken(results),
        "about_broken": BROKEN,
        "methods": METHODS,
        "provenance": summary["provenance"],
        "libraries": ", ".join(f"{name} {version}" for name, version in libraries.items()),
    }


def _ran(results: Results, summary: Mapping[str, Any]) -> str:
    """Returns how much was run, such as "1 policy in 2 conditions of 8 episodes, seed 3"."""
    low, high = summary["seeds"]
    conditions = _counted(len(results.suite.conditions), "condition")
    policies = _counted(len(results.policies), "policy", "policies")
    seeds = f"seed {low}" if low == high else f"seeds {low} to {high}"
    return f"{policies} in {conditions} of {_counted(results.suite.episodes, 'episode')}, {seeds}"


def _policy(name: str, fingerprints: Sequence[str]) -> str:
    """Returns a description of a policy from its fingerprints, one a training."""
    first = fingerprints[0]
    if len(fingerprints) > 1:
        return f"{len(fingerprints)} trainings: {', '.join(fingerprints)}"
    if first not in POLICIES:
        return f"fingerprint {first}"
    return "part of this package" if first == name else f"{first}, part of this package"


def _condition(each: Condition, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the name of a condition, a description, its successes and all its measures."""
    boats, control = _counted(each.params.num_boats, "boat"), each.control
    parts = (each.about, boats, f"task {each.task_name}", control and f"control {control}")
    policies = summary["conditions"][each.name]["policies"]
    return {
        "name": each.name,
        "about": "; ".join(filter(None, parts)),
        "shares": {p: formats.share(policies[p]["success"]["value"]) for p in policies},
        "table": descriptions.of_condition(summary, each.name),
    }


def broken(results: Results) -> list[str]:
    """Returns the first episodes that ended with an error of the policy, one a line."""
    rows = [row for row in results if row.error]
    lines = []
    for row in rows[:SHOWN]:
        training = "" if row.training_seed is None else f", training {row.training_seed}"
        message = one_line(str(row.error))
        lines.append(f"{row.policy}{training}, {row.condition}, seed {row.seed}: {message}")
    if len(rows) > SHOWN:
        lines.append(f"and {len(rows) - SHOWN} more: see the column error of episodes.csv")
    return lines


def _counted(number: int, one: str, several: str | None = None) -> str:
    return f"{number} {one if number == 1 else several or one + 's'}"


def prose(text: str) -> Markup:
    """Returns text in HTML, with what stands between backquotes as code."""
    return Markup(re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def bracket(text: str, kind: str) -> Markup:
    """Returns text in HTML, with a bracket at its end in a ``span`` of the class ``kind``."""
    return Markup(re.sub(r" (\[[^\]]*\])$", rf' <span class="{kind}">\1</span>', str(escape(text))))


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("baselines.evaluate.report"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"prose": prose, "bracket": bracket}
    for function in (markdown_text.escaped, markdown_text.code):
        environment.filters[function.__name__] = function
    environment.filters["markdown_prose"] = markdown_text.prose
    environment.globals["nothing"] = formats.NOTHING
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "ensure_ascii": False}
    return environment
