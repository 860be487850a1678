"""A lower bound of the time in which a team delivers the vessel.

The nearest boat goes to the hull at its top speed. From then on all boats push with all their
thrust across the vessel's length, at first without any drag; they let go just when the vessel
coasts to the edge of the tolerance at the speed that counts for a delivery. There it stays for as
long as it must hold its pose. Turning takes no time.
The bound holds for teams that cannot brake the vessel: boats that went round the hull and pushed
against its motion could gain a little at the end.

``python -m baselines.evaluate.bound`` prints it for the episodes of a suite.
"""

from functools import lru_cache

import numpy as np

from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.polygons import complex_corners, gap_to, outline
from asv_env.tasks import starts
from asv_env.tasks.termination import delivery_ticks
from asv_env.types import Float, InitialState
from baselines.evaluate.suites import SUITES
from baselines.paper.coasting import coasting_distance
from baselines.rollout.commands import command

SPEEDS = 1000  #: number of speeds for which the push is tabulated


def top_speed(linear: float, quadratic: float, force: float) -> float:
    """Returns the speed, m/s, at which a drag (kg/s, kg/m) is as large as a force, N."""
    if quadratic == 0:
        return force / linear
    return float((np.sqrt(linear**2 + 4 * quadratic * force) - linear) / (2 * quadratic))


def boat_speed(params: EnvParams) -> float:
    """Returns the top speed of a boat alone, m/s."""
    boat = params.hulls()[1]
    return top_speed(*boat.surge, 2 * boat.thrust)


def vessel_speed(params: EnvParams) -> float:
    """Returns the top speed of the vessel when all boats push across its length, m/s."""
    (vessel, boat), team = params.hulls(), params.num_boats
    linear, quadratic = np.array(vessel.sway) + team * np.array(boat.surge)
    return top_speed(linear, quadratic, 2 * team * boat.thrust)


def slow_speed(params: EnvParams) -> float:
    """Returns the speed, m/s, below which a vessel at its goal counts, in still water."""
    task = params.task
    return task.speed_tolerance if task.delivery == "holding" else task.passing_speed


@lru_cache(maxsize=8)
def _table(params: EnvParams) -> tuple[Float, Float]:
    """Returns distances, m, and times, s, of pushes up to each speed from which it coasts."""
    (vessel, boat), team = params.hulls(), params.num_boats
    slow = slow_speed(params)
    speed = np.linspace(slow, max(vessel_speed(params), slow), SPEEDS)
    mass = vessel.masses[1] + team * boat.masses[0]
    gains = 2 * team * boat.thrust / mass
    linear, quadratic = vessel.sway
    ratio = speed / slow * (linear + quadratic * slow) / (linear + quadratic * speed)
    coasting = vessel.masses[1] / linear * np.log(ratio)
    pushed = speed**2 / (2 * gains)
    coasted = coasting_distance(vessel, speed) - coasting_distance(vessel, slow)
    return pushed + coasted, speed / gains + coasting


def push_time(params: EnvParams, distance: Float) -> Float:
    """Returns the least times (...), s, of deliveries over distances (...), m."""
    covered, time = _table(params)
    left = np.maximum(np.asarray(distance) - params.task.position_tolerance, 0.0)
    beyond = np.maximum(left - covered[-1], 0.0)
    return np.interp(left, covered, time) + beyond / vessel_speed(params)


def least_time(params: EnvParams, start: InitialState) -> float:
    """Returns the least time of an episode, s, from its initial state."""
    boats = plane(start.motion)[1:]
    hull = outline(complex_corners(params.vessel.corners))
    nearest = min(gap_to(hull, boat) for boat in boats.tolist())
    gap = max(0.0, nearest - params.boat.reach)
    distance = float(np.hypot(*(start.goal[:2] - start.motion[0, :2])))
    held = (delivery_ticks(params) - 1) / params.clock.control
    return gap / boat_speed(params) + float(push_time(params, np.array(distance))) + held


def show(suite: str = "plane-v2", episodes: int = 500) -> None:
    """Print a lower bound of the time to deliver the vessel, for each condition of a suite.

    Args:
        suite: name of the suite, as in python -m baselines.evaluate.
        episodes: number of episodes of each condition.
    """
    chosen = SUITES.find(suite).first(episodes)
    for condition in chosen.conditions:
        params, rngs = condition.params, map(np.random.default_rng, chosen.seeds)
        times = [least_time(params, starts.sample(params, rng)) for rng in rngs]
        low, middle, high = np.percentile(times, [5, 50, 95])
        print(f"{condition.name:14} {middle:.1f} s at least (5 to 95 %: {low:.1f} to {high:.1f})")


main = command(show, "python -m baselines.evaluate.bound")

if __name__ == "__main__":
    main()
