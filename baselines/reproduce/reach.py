"""Which goals over the plane are within reach in time, by the paper's laws: geometry alone."""

from typing import Any

import numpy as np

from asv_env.params import EnvParams
from asv_env.presets import make_params
from asv_env.tasks import starts
from asv_env.types import Bool, Float
from baselines.paper import two_arc
from baselines.paper.arc_following import two_arcs
from baselines.paper.paper_numbers import GAINS, PaperGains
from baselines.paper.paper_policy import arrival_time, longest_path, push_speed
from baselines.paper.tuned import tuned_gains
from baselines.reproduce.artefact import Job

GOALS = 20_000  #: number of goals
TIME_LIMITS = (180.0, 600.0)  #: of the environment, and of the suite of the paper's tasks, s


def choices() -> dict[str, PaperGains]:
    """Returns free parameters of the paper's controller, by what is chosen."""
    by_goal = PaperGains(alpha1=None)
    return {"as printed": GAINS, "first turn by goal": by_goal, "`paper-tuned`": tuned_gains()}


def table(job: Job) -> dict[str, Any]:
    """Goals over the plane that two arcs reach in time.

    Legal: both radii are large enough, and no arc is driven backwards. In time: the path is short
    enough to be driven at the speed of the push, and the vessel to come to rest, in what T_goal
    leaves of the time limit.
    """
    params = make_params()
    goals = sampled_goals(params, job.seeds(GOALS))
    rows = [
        {
            "parameters": name,
            "least radius (m)": gains.min_radius * params.vessel.length / 2,
            "speed (cm/s)": 100 * push_speed(params, gains),
            "T_goal (s)": arrival_time(params, gains),
            "legal": f"{np.isfinite(lengths(goals, params, gains, np.inf)).mean():.1%}",
            **{
                f"in time, {limit:g} s": f"{in_time(goals, params, gains, limit).mean():.1%}"
                for limit in TIME_LIMITS
            },
        }
        for name, gains in choices().items()
    ]
    near, far = params.task.goal_distance
    notes = [
        f"{GOALS:,} goals drawn as in the task `transport`: {near:g} to {far:g} m from the "
        "vessel, any heading. Nothing is simulated."
    ]
    return {"rows": rows, "notes": notes}


def sampled_goals(params: EnvParams, seeds: range) -> Float:
    """Returns the goals (n, 3) of episodes, m, m, rad."""
    return np.array([starts.sample(params, np.random.default_rng(seed)).goal for seed in seeds])


def lengths(goals: Float, params: EnvParams, gains: PaperGains, longest: float) -> Float:
    """Returns the lengths (n,) of the paths to goals (n, 3), m; infinite where none is legal.

    Paths with wide arcs are planned where they are no longer than ``longest``, m.
    """
    half_length = params.vessel.length / 2
    path = two_arcs(goals, half_length, longest, gains)
    legal = two_arc.feasible(path, half_length)
    return np.where(legal, path.total_length, np.inf)


def in_time(goals: Float, params: EnvParams, gains: PaperGains, time_limit: float) -> Bool:
    """Returns which paths (n,) can be driven in what T_goal leaves of a time limit, s."""
    longest = float(longest_path(params, gains, time_limit - arrival_time(params, gains)))
    enough: Bool = lengths(goals, params, gains, longest) <= longest
    return enough
