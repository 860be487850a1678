"""Goals over the whole plane, in simulation: what the paper's laws deliver, and in which time."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from asv_env.presets import make_params
from baselines.evaluate import statistics
from baselines.evaluate.tables import formats
from baselines.policy import POLICIES
from baselines.reproduce.artefact import Job
from baselines.reproduce.fig10_trials import (
    COMPARED,
    LOOSE,
    TIGHT,
    Episodes,
    percent,
    shares,
    within,
)
from baselines.reproduce.paper_environments import SCENARIOS, episodes
from baselines.reproduce.reach import TIME_LIMITS


def study(job: Job) -> list[dict[str, Any]]:
    """Returns episodes of the task by policy, scenario and time limit, s."""
    return [
        {
            "policy": policy,
            "scenario": scenario,
            "limit": limit,
            "episodes": episodes(
                POLICIES[policy],
                make_params(scenario=scenario, time_limit=limit),
                job.seeds(job.episodes),
                f"{policy}, {scenario}, {limit:g} s",
            ),
        }
        for policy in COMPARED
        for scenario in SCENARIOS
        for limit in TIME_LIMITS
    ]


def table(job: Job, study: list[dict[str, Any]]) -> dict[str, Any]:
    """Goals over the plane, driven to in simulation by the paper's policies and by ours."""
    task = make_params().task
    near, far = task.goal_distance
    notes = [
        f"Task `transport`: goals {near:g} to {far:g} m from the vessel with any heading, the same "
        f"in all rows. Delivered: at rest within {100 * task.position_tolerance:g} cm and "
        f"{task.heading_tolerance:g} rad for {task.delivery_time:g} s, with the 95 % interval. "
        "Within: at the instant of smallest distance, at any speed. Closed: all slots were "
        "occupied at once; a team can deliver without that. Shares are of all episodes."
    ]
    return {"rows": [_row(one) for one in study], "notes": notes}


def _row(one: Mapping[str, Any]) -> dict[str, Any]:
    rows: Episodes = one["episodes"]
    delivered = statistics.proportion([[float(row["success"]) for row in rows]])
    near = shares(
        {tolerances: within(rows, *tolerances, fixed_goal=True) for tolerances in (TIGHT, LOOSE)}
    )
    return {
        "policy": one["policy"],
        "scenario": one["scenario"],
        "time limit (s)": one["limit"],
        "episodes": len(rows),
        "closed": percent(sum(row["time_to_closure"] is not None for row in rows) / len(rows)),
        "delivered": formats.share_estimate(asdict(delivered)),
        **{tolerances: percent(share) for tolerances, share in near.items()},
    }
