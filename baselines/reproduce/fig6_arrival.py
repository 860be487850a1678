"""When boats arrive at the vessel: the paper's synchronised arrival at T_goal, and ours."""

from typing import Any

import numpy as np

from asv_env.geometry import direction, plane, wrap
from asv_env.params import EnvParams
from asv_env.tasks import formation, starts
from asv_env.types import Complex, Float
from baselines.paper import braitenberg
from baselines.paper.paper_numbers import GAINS, PaperGains
from baselines.paper.paper_policy import PaperPolicy, arrival_time
from baselines.paper.spiral import angular_distance, approach_speed, arc_length, bearing_offset
from baselines.policy import MakePolicy
from baselines.reproduce.artefact import Job
from baselines.reproduce.paper_environments import run, simulation
from baselines.reproduce.single_runs import NoisyPoses

NEAR = 1.05  #: distance at which a point has arrived, stop radii: Eq. (7) ends at one of them
TIME_LIMIT = 120.0  #: time for the approach, s


def arrivals(job: Job) -> dict[str, Any]:
    """Returns times of arrival by the laws alone, and of closure with the cap and without it.

    Returns:
        ``T_goal``, s; ``asked``, speeds of Eq. (7) at the start, and ``cap``, m/s; ``points``,
        times at which points that obey the laws arrive, s; and, for boats, ``trials`` and the times
        of closure, s, ``capped`` and ``uncapped``.
    """
    params = simulation("approach", time_limit=TIME_LIMIT)
    seeds = job.seeds(job.trials)
    placed = [starts.sample(params, np.random.default_rng(seed)).motion for seed in seeds]
    worlds = [_on_targets(motion, params) for motion in placed]
    capped, free = GAINS, PaperGains(max_speed=params.boat.full_speed)
    times = {
        name: [log.episode.time_to_closure for log in run(_noisy(gains, job), params, seeds, name)]
        for name, gains in (("capped", capped), ("uncapped", free))
    }
    goal_time = arrival_time(params, GAINS)
    return {
        "T_goal": goal_time,
        "asked": [speed for world in worlds for speed in first_speeds(*world, params)],
        "cap": GAINS.max_speed,
        "points": [time for world in worlds for time in point_arrivals(*world, params)],
        "trials": len(placed),
        **{name: [time for time in found if time is not None] for name, found in times.items()},
    }


def _noisy(gains: PaperGains, job: Job) -> MakePolicy:
    """Returns the paper's policy with these gains and the noise of its simulation."""
    return lambda params: NoisyPoses(PaperPolicy(params, gains), job.seed)


def _on_targets(motion: Float, params: EnvParams) -> tuple[Complex, Float]:
    """Returns positions (A,) of boats as seen from their targets, m, and headings (A,), rad."""
    boats = plane(motion)[1:]
    slots = formation.slots(params, params.num_boats)
    return boats - slots[formation.assign(boats, slots)], motion[1:, 2]


def first_speeds(offset: Complex, heading: Float, params: EnvParams) -> list[float]:
    """Returns the speeds of Eq. (7) at the start, m/s, of boats at offsets from their targets."""
    return _speeds(offset, 0.0, params).tolist()


def _speeds(offset: Complex, time: float, params: EnvParams) -> Float:
    theta = angular_distance(np.angle(offset), np.pi / 2)
    length = arc_length(np.abs(offset), theta, GAINS.sigma)
    left = arrival_time(params, GAINS) - time
    return approach_speed(length, left, params.task.slot_distance)


def point_arrivals(offset: Complex, heading: Float, params: EnvParams) -> list[float]:
    """Returns the times, s, at which points arrive that obey Eqs. (2), (3) and (7), nothing else.

    They have neither hulls nor mass, and their speed is not bounded. A point that is not there at
    twice T_goal counts as arriving then.
    """
    offset, heading, dt = offset.copy(), heading.copy(), 1 / params.clock.control
    latched = braitenberg.turn_direction(offset.real, 0.0)
    last = 2 * arrival_time(params, GAINS)
    found = np.full(len(offset), last)
    for tick in range(round(last / dt)):
        there = np.abs(offset) < NEAR * params.task.slot_distance
        found = np.where(there, np.minimum(found, tick * dt), found)
        if there.all():
            break
        alpha = np.angle(offset)
        latched = np.where(offset.imag > 0, braitenberg.turn_direction(offset.real, 0.0), latched)
        wanted = braitenberg.desired_heading(alpha, latched, bearing_offset(alpha, GAINS.sigma))
        heading = heading - GAINS.steering * dt * np.sin(wrap(heading - wanted))
        speed = np.where(there, 0.0, _speeds(offset, tick * dt, params))
        offset = offset + dt * speed * direction(heading)
    return found.tolist()


def in_words(run: dict[str, Any], study: dict[str, Any]) -> str:
    """Returns what the times say, for the caption of Fig. 6."""
    points, asked = np.array(study["points"]), np.array(study["asked"])
    low, high = np.percentile(points, [5, 95])

    def closures(name: str) -> str:
        times = study[name]
        median = f" (median {np.median(times):.0f} s)" if times else ""
        return f"{len(times)} of {study['trials']} trials{median}"

    return (
        f"Arrival: points without hulls and mass that obey Eqs. (2), (3) and (7) alone arrive "
        f"after {np.median(points):.1f} s, 90 % of them between {low:.1f} and {high:.1f} s, as in "
        f"the paper. For that Eq. (7) asks for {100 * np.median(asked):.1f} cm/s, and for up to "
        f"{100 * asked.max():.1f} cm/s of the farthest. With the cap of {100 * study['cap']:g} "
        f"cm/s, boats with hulls in water came to closure in {closures('capped')}, without it in "
        f"{closures('uncapped')}, within {TIME_LIMIT:g} s. So arriving together at T_goal is a "
        "property of the laws; what comes between is not the cap alone, but hulls that skid, touch "
        "each other and nudge the vessel."
    )
