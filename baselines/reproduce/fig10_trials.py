"""Fig. 10 and the table: repeated trials of the experiment, and the paper's own."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.stats import norm

from baselines.evaluate.report import palette
from baselines.paper.paper_numbers import PAPER_HEADING, PAPER_POSITION, PAPER_TRIALS
from baselines.policy import POLICIES
from baselines.reproduce import style
from baselines.reproduce.artefact import Job, cell
from baselines.reproduce.comparison_rows import describe
from baselines.reproduce.paper_environments import SCENARIOS, episodes, experiment

COMPARED = ("paper", "paper-tuned", "scripted")
TIGHT, LOOSE = (5.0, 0.1), (10.0, 0.5)  #: tolerances of position, cm, and of heading, rad
WORLDS: dict[str, dict[str, Any]] = {
    **{scenario: {"scenario": scenario} for scenario in SCENARIOS},
    "tank-calibrated": {"preset": "tank-calibrated"},
}
"""Options of the experiment, by the name of the row."""
SHOWN = ("nominal", "tank-calibrated")  #: worlds of the figure
Episodes = Sequence[dict[str, Any]]  #: rows of ``episodes.csv``


def trials(job: Job) -> dict[str, dict[str, Episodes]]:
    """Returns episodes of the experiment by policy and world."""
    seeds = job.seeds(max(job.trials, job.episodes))
    environments = {world: experiment(**options) for world, options in WORLDS.items()}
    return {
        policy: {
            world: episodes(POLICIES[policy], params, seeds, f"{policy}, {world}")
            for world, params in environments.items()
        }
        for policy in COMPARED
    }


def errors(rows: Episodes, fixed_goal: bool = False) -> tuple[list[float], list[float]]:
    """Returns smallest distances, cm, and heading errors then, rad, of the rows with a goal.

    Those without closure have none, unless the goal is fixed from the beginning.
    """
    found = [row for row in rows if fixed_goal or row["time_to_closure"] is not None]
    distance = [100 * row["min_position_error"] for row in found]
    return distance, [row["heading_error_at_min"] for row in found]


def error_figure(job: Job, study: dict[str, Any]) -> Figure:
    """Smallest distance and heading error at that instant, trial by trial, in simulation.

    Policy "paper"; filled: preset "experiment", undisturbed; open: preset "tank-calibrated", whose
    disturbances were fitted to the tank's errors; solid and dashed lines: their means. Grey: mean
    (dotted) and standard deviation of the paper's twelve trials in its tank; the trials themselves
    are not given there. A trial without closure has no mark.
    """
    figure, axes = style.panels(style.PAGE, 62.0, 1, 2)
    panels = zip(axes, (PAPER_POSITION, PAPER_HEADING), strict=True)
    for column, (panel, (mean, deviation)) in enumerate(panels):
        panel.axhspan(mean - deviation, mean + deviation, color=palette.PALE, lw=0)
        panel.axhline(mean, color=palette.GREY, ls=":", label="tank experiment (paper)")
        for world, fill, line in zip(SHOWN, (palette.BLUE, "white"), ("-", "--"), strict=True):
            rows = study["paper"][world][: job.trials]
            looks = {"mfc": fill, "mec": palette.BLUE, "label": f"simulation, {world}"}
            _draw_trials(panel, rows, column, line, looks)
        panel.set_xlabel("trial")
        panel.set_xlim(0.5, job.trials + 0.5)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0].set_ylabel("smallest distance (cm)")
    axes[0].set_ylim(bottom=0)
    axes[1].set_ylabel("heading error (rad)")
    style.legend(figure, axes[0])
    return figure


def _draw_trials(axes: Axes, rows: Episodes, column: int, line: str, looks: dict[str, Any]) -> None:
    """Draws the trials of a world and their mean."""
    numbers = [k for k, row in enumerate(rows, start=1) if row["time_to_closure"] is not None]
    values = errors(rows)[column]
    axes.plot(numbers, values, "o", ms=4, zorder=3, **looks)
    if values:
        axes.axhline(float(np.mean(values)), color=looks["mec"], ls=line, lw=0.8)


def table(job: Job, study: dict[str, Any]) -> dict[str, Any]:
    """Errors of placement: the paper's tank experiment and the simulation, side by side.

    Smallest distance of the vessel to its goal and signed heading error at that instant, over the
    trials that came to closure; and the shares of all trials in which both were within tolerances
    at that instant.
    """
    names = ("source", "policy", "world", "trials", "closed", "delivered")
    paper = zip(names, ("tank experiment (paper)", "", "", PAPER_TRIALS, None, None), strict=True)
    printed = ({"mean": m, "sd": sd, "median": None} for m, sd in (PAPER_POSITION, PAPER_HEADING))
    accepted = {tolerances: accepted_in_tank(*tolerances)[-1] for tolerances in (TIGHT, LOOSE)}
    rows = [dict(paper) | _in_columns(*printed) | shares(accepted)]
    for policy in COMPARED:
        for world in WORLDS:
            done = study[policy][world][: job.episodes]
            closed = sum(row["time_to_closure"] is not None for row in done) / len(done)
            delivered = sum(row["success"] for row in done) / len(done)
            row = ("simulation", policy, world, len(done), closed, delivered)
            found = _in_columns(*map(describe, errors(done)))
            close = shares({tolerances: within(done, *tolerances) for tolerances in accepted})
            rows.append(dict(zip(names, row, strict=True)) | found | close)
    notes = [
        "Rows of the simulation: preset `experiment`, undisturbed or with the noise of scenario "
        "`noisy`, and preset `tank-calibrated`; goal {0.55 m, -0.95 m, 0.1 rad} from the pose at "
        "closure. Delivered: within 5 cm and 0.1 rad for an instant, slower than 1 cm/s, "
        "and no longer coming nearer. Within: at the instant of smallest distance, at any speed. "
        "Deviations are those of samples; the paper does not say which it gives, nor how many "
        "trials it left out.",
        *map(_acceptance_in_words, accepted),
    ]
    return {"rows": rows, "notes": notes}


def accepted_in_tank(position: float, heading: float) -> tuple[float, float, float]:
    """Returns the shares of the tank's trials that tolerances, cm and rad, would accept.

    They are those by position, by heading and by both, if both errors are normal with the printed
    moments and independent.
    """
    near = float(norm.cdf(position, *PAPER_POSITION))
    low, high = norm.cdf([-heading, heading], *PAPER_HEADING)
    return near, float(high - low), near * float(high - low)


def _acceptance_in_words(tolerances: tuple[float, float]) -> str:
    position, heading = tolerances
    near, turned, both = accepted_in_tank(position, heading)
    return (
        f"Of the tank's own trials, {near:.0%} would be within {position:g} cm, {turned:.0%} "
        f"within {heading:g} rad and {both:.0%} within both, if their errors are normal with the "
        "printed moments and independent."
    )


def within(rows: Episodes, position: float, heading: float, fixed_goal: bool = False) -> float:
    """Returns the share of trials that came within tolerances, cm and rad; all count."""
    distances, headings = map(np.array, errors(rows, fixed_goal))
    found = (distances <= position) & (np.abs(headings) <= heading)
    return float(found.sum() / len(rows))


def shares(found: Mapping[tuple[float, float], float]) -> dict[str, float]:
    """Returns shares of trials by tolerances, cm and rad, with heads for a table."""
    return {f"within {p:g} cm, {h:g} rad": share for (p, h), share in found.items()}


def _in_columns(distance: Mapping[str, Any], heading: Mapping[str, Any]) -> dict[str, Any]:
    columns = {f"distance {key} (cm)": value for key, value in distance.items()}
    return columns | {f"heading {key} (rad)": value for key, value in heading.items()}


def short(table: dict[str, Any]) -> dict[str, Any]:
    """Returns the table with means and deviations in one column, and without the rest."""
    rows = [
        {
            "source": ", ".join(filter(None, (row["source"], row["policy"], row["world"]))),
            "trials": row["trials"],
            "closed": percent(row["closed"]),
            "delivered": percent(row["delivered"]),
            **{n: percent(share) for n, share in row.items() if n.startswith("within")},
            "smallest distance (cm)": _spread(row, "distance", "cm"),
            "heading error then (rad)": _spread(row, "heading", "rad"),
        }
        for row in table["rows"]
    ]
    return {"rows": rows, "notes": table["notes"]}


def percent(fraction: float | None) -> str | None:
    """Returns a share in percent."""
    return None if fraction is None else f"{fraction:.0%}"


def _spread(row: dict[str, Any], name: str, unit: str) -> str:
    """Returns mean and deviation with as many digits as the paper gives."""
    values = (row[f"{name} {kind} ({unit})"] for kind in ("mean", "sd"))
    return " ± ".join(cell(v) if v is None else f"{round(v, 2) + 0.0:g}" for v in values)
