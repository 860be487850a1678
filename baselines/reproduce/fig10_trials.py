"""Fig. 10 and the table: repeated trials of the experiment beside the paper's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from baselines.evaluate.report import palette
from baselines.paper.experiment import PAPER_HEADING, PAPER_POSITION, PAPER_TRIALS
from baselines.policy import POLICIES
from baselines.reproduce import style
from baselines.reproduce.comparison_rows import describe, share
from baselines.reproduce.job import Job
from baselines.reproduce.paper_environments import experiment, run

COMPARED = ("paper", "scripted")
SCENARIOS = ("nominal", "noisy")


def trials(job: Job) -> dict[str, dict[str, list[dict[str, Any]]]]:
    """Episodes of the experiment by policy and scenario, as rows of ``episodes.csv``."""
    return {
        policy: {
            scenario: [
                asdict(log.episode)
                for log in run(
                    POLICIES[policy],
                    experiment(scenario=scenario),
                    job.seeds(max(job.trials, job.episodes)),
                    f"{policy}, {scenario}",
                )
            ]
            for scenario in SCENARIOS
        }
        for policy in COMPARED
    }


def errors(rows: Sequence[dict[str, Any]]) -> tuple[list[float], list[float]]:
    """Smallest distance, cm, and heading error at that instant, rad, of the rows with closure.

    Without closure there is no goal yet, as it is given from the pose at closure.
    """
    closed = [row for row in rows if row["time_to_closure"] is not None]
    distance = [100 * row["min_position_error"] for row in closed]
    return distance, [row["heading_error_at_min"] for row in closed]


def figure(job: Job, study: dict[str, Any]) -> Figure:
    """Smallest distance and heading error at that instant, trial by trial, in simulation.

    Policy "paper" in the experiment's preset; filled: exact measurement, open: scenario "noisy";
    solid and dashed lines: their means. Grey: mean (dotted) and standard deviation of the paper's
    twelve trials in its tank; the trials themselves are not given there. A trial without closure
    has no mark.
    """
    drawn, axes = style.panels(style.PAGE, 62.0, 1, 2)
    numbers = np.arange(1, job.trials + 1)
    for panel, column, colour, paper in zip(
        axes,
        (0, 1),
        (palette.VERMILLION, palette.BLUE),
        (PAPER_POSITION, PAPER_HEADING),
        strict=True,
    ):
        mean, deviation = paper
        panel.axhspan(mean - deviation, mean + deviation, color=palette.PALE, lw=0)
        panel.axhline(mean, color=palette.GREY, ls=":", label="tank experiment (paper)")
        for scenario, fill, line in zip(SCENARIOS, (colour, "white"), ("-", "--"), strict=True):
            rows = study["paper"][scenario][: job.trials]
            closed = [row["time_to_closure"] is not None for row in rows]
            values = np.array(errors(rows)[column])
            panel.plot(
                numbers[closed],
                values,
                "o",
                mfc=fill,
                mec=colour,
                ms=4,
                label=f"simulation, {scenario}",
                zorder=3,
            )
            if len(values):
                panel.axhline(values.mean(), color=colour, ls=line, lw=0.8)
        panel.set_xlabel("trial")
        panel.set_xlim(0.5, job.trials + 0.5)
        panel.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0].set_ylabel("smallest distance (cm)")
    axes[0].set_ylim(bottom=0)
    axes[1].set_ylabel("heading error (rad)")
    style.legend(drawn, axes[0])
    return drawn


def table(job: Job, study: dict[str, Any]) -> dict[str, Any]:
    """Errors of placement: the paper's tank experiment beside the simulation.

    Smallest distance of the vessel to its goal and signed heading error at that instant, over the
    trials that came to closure.
    """
    rows = [
        _row(
            "tank experiment (paper)",
            "",
            "",
            PAPER_TRIALS,
            None,
            None,
            _given(PAPER_POSITION),
            _given(PAPER_HEADING),
        )
    ]
    for policy in COMPARED:
        for scenario in SCENARIOS:
            episodes = study[policy][scenario][: job.episodes]
            distance, heading = errors(episodes)
            closed = [row["time_to_closure"] is not None for row in episodes]
            delivered = [row["success"] for row in episodes]
            rows.append(
                _row(
                    "simulation",
                    policy,
                    scenario,
                    len(episodes),
                    share(closed),
                    share(delivered),
                    describe(distance),
                    describe(heading),
                )
            )
    notes = [
        "Rows of the simulation: preset `experiment`, goal {0.55 m, -0.95 m, 0.1 rad} from the "
        "pose at closure. Delivered: within 5 cm and 0.1 rad at rest. Deviations are those of "
        "samples; the paper does not say which it gives, nor how many trials it left out."
    ]
    return {"rows": rows, "notes": notes}


def _given(pair: tuple[float, float]) -> dict[str, float | None]:
    return {"mean": pair[0], "sd": pair[1], "median": None}


def _row(
    source: str,
    policy: str,
    scenario: str,
    number: int,
    closed: float | None,
    delivered: float | None,
    distance: dict[str, float | None],
    heading: dict[str, float | None],
) -> dict[str, Any]:
    return {
        "source": source,
        "policy": policy,
        "scenario": scenario,
        "trials": number,
        "closed": closed,
        "delivered": delivered,
        **{f"distance {key} (cm)": value for key, value in distance.items()},
        **{f"heading {key} (rad)": value for key, value in heading.items()},
    }
