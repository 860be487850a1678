"""Templates of the report, filled in with Jinja2; HTML is escaped, Markdown is not."""

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from baselines.evaluate.report.content import content
from baselines.evaluate.results import Results
from baselines.evaluate.tables.formats import NOTHING


def markdown(results: Results, summary: Mapping[str, Any]) -> str:
    """Returns the report in Markdown: its tables and words, without figures."""
    return render("report.md", **content(results, summary))


def render(name: str, **values: Any) -> str:
    """Returns a template of the folder ``templates``, filled in with values."""
    return _environment().get_template(name).render(values)


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
    environment.globals["nothing"] = NOTHING
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "ensure_ascii": False}
    return environment
