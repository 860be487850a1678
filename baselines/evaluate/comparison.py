"""What ``compare`` returns: tables and charts of policies that met the same episodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asv_env.checks import choice
from baselines.evaluate.report import charts, svg
from baselines.evaluate.request import Request
from baselines.evaluate.results import Results, frame
from baselines.evaluate.summary import MEASURES
from baselines.evaluate.tables import descriptions
from baselines.rollout import film

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Comparison:
    """Policies compared on the same episodes.

    Attributes:
        request: what was compared.
        results: rows of the episodes by condition, policy and training.
        summary: success, measures and comparisons with their intervals, as in ``summary.json``.
    """

    request: Request
    results: Results
    summary: Mapping[str, Any]

    @property
    def episodes(self) -> pd.DataFrame:
        """All episodes, one a row, with the columns of ``episodes.csv``."""
        return frame(self.results)

    def table(self) -> pd.DataFrame:
        """Returns a row for each condition and policy.

        Columns: ``episodes``, ``trainings``; ``success`` with its 95 % interval from
        ``success_low`` to ``success_high``; and the medians of the measures, in SI units.
        """
        import pandas as pd

        rows = {
            (condition, policy): {
                "episodes": found["episodes"],
                "trainings": found["trainings"],
                "success": found["success"]["value"],
                "success_low": found["success"]["low"],
                "success_high": found["success"]["high"],
                **{name: found[name]["median"] for name in MEASURES if name in found},
            }
            for condition, entry in self.summary["conditions"].items()
            for policy, found in entry["policies"].items()
        }
        made = pd.DataFrame.from_dict(rows, orient="index")
        return made.rename_axis(["condition", "policy"])

    def plot(self, chart: str = "overview", condition: str | None = None) -> Figure:
        """Returns a chart of the report as a Matplotlib figure.

        Args:
            chart: "overview" of all conditions, or of one condition "profile", "times",
                "failures", "errors" or "goals".
            condition: its name; the first by default.

        Raises:
            ValueError: there is no such condition or chart.
        """
        with svg.look():
            if chart == "overview":
                return charts.overview(self.results, self.summary).figure
            by_name = {one.name: one for one in self.results.suite.conditions}
            name = choice("condition", condition or next(iter(by_name)), by_name)
            drawn = {c.name: c for c in charts.of_condition(self.results, by_name[name], {})}
        return drawn[choice("chart", chart, ["overview", *drawn])].figure

    def film(self, path: Path, policy: str | None = None, condition: str | None = None) -> None:
        """Films the first episode of a policy in a condition, the first of each by default.

        Args:
            path: file that ends in ".gif" or ".mp4".
            policy: its name.
            condition: its name.
        """
        policies = {one.name: one.trainings[0] for one in self.request.policies}
        conditions = {one.name: one.params for one in self.results.suite.conditions}
        make = policies[choice("policy", policy or next(iter(policies)), policies)].make
        params = conditions[choice("condition", condition or next(iter(conditions)), conditions)]
        film.save(path, make, params, self.results.suite.seed)

    def __str__(self) -> str:
        return descriptions.text_table(self.summary)

    def _repr_html_(self) -> str:
        """Returns the table of results as a notebook shows it."""
        import pandas as pd

        shown = descriptions.results(self.summary)
        return pd.DataFrame(shown.rows, columns=shown.titles).to_html(index=False)
