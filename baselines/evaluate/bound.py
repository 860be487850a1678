"""A time that no team can beat that moves the vessel across its length and cannot brake it.

The nearest boat goes to the hull at its top speed. From then on all boats push with all their
thrust, at first without any drag; they let go just when the vessel coasts to the edge of the
tolerance at the speed that counts as delivered. Turning takes no time. Boats that went round the
hull and pushed against its motion could gain a little at the end.

``python -m baselines.evaluate.bound`` prints it for the episodes of a suite.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from asv_env.checks import choice
from asv_env.geometry import plane, xy
from asv_env.params import EnvParams
from asv_env.tasks import starts
from asv_env.types import Float, InitialState
from baselines.evaluate.suites import SUITES
from baselines.paper.coasting import coasting_distance

SPEEDS = 1000
"""For which the push is tabled."""


def top_speed(linear: float, quadratic: float, force: float) -> float:
    """Speed in m/s at which a drag (kg/s, kg/m) is as large as a force, N."""
    if quadratic == 0:
        return force / linear
    return float((np.sqrt(linear**2 + 4 * quadratic * force) - linear) / (2 * quadratic))


def boat_speed(params: EnvParams) -> float:
    """Top speed of a boat alone, m/s."""
    boat = params.hulls()[1]
    return top_speed(*boat.surge, 2 * boat.thrust)


def vessel_speed(params: EnvParams) -> float:
    """Top speed of the vessel that all boats push across its length, m/s."""
    (vessel, boat), team = params.hulls(), params.num_boats
    linear, quadratic = np.array(vessel.sway) + team * np.array(boat.surge)
    return top_speed(linear, quadratic, 2 * team * boat.thrust)


@lru_cache(maxsize=8)
def _table(params: EnvParams) -> tuple[Float, Float]:
    """Ways, m, and times, s, of pushes up to each of the speeds from which the vessel coasts."""
    (vessel, boat), team = params.hulls(), params.num_boats
    slow = params.task.speed_tolerance
    speed = np.linspace(slow, max(vessel_speed(params), slow), SPEEDS)
    mass = vessel.total_mass + team * boat.total_mass
    gains = 2 * team * boat.thrust / mass
    linear, quadratic = vessel.sway
    ratio = speed / slow * (linear + quadratic * slow) / (linear + quadratic * speed)
    coasting = vessel.total_mass / linear * np.log(ratio)
    way = (
        speed**2 / (2 * gains) + coasting_distance(vessel, speed) - coasting_distance(vessel, slow)
    )
    return way, speed / gains + coasting


def push_time(params: EnvParams, distance: Float) -> Float:
    """Least time (...) s in which a vessel is delivered over distances (...) in m."""
    way, time = _table(params)
    left = np.maximum(np.asarray(distance) - params.task.position_tolerance, 0.0)
    return np.interp(left, way, time) + np.maximum(left - way[-1], 0.0) / vessel_speed(params)


def least_time(params: EnvParams, start: InitialState) -> float:
    """Least time of one episode, s."""
    boats = plane(start.motion)[1:]
    half = np.array([params.vessel.length, params.vessel.width]) / 2
    beside = np.maximum(np.abs(xy(boats)) - half, 0.0)
    hull = np.hypot(params.boat.length, params.boat.width) / 2
    way = max(0.0, float(np.hypot(*beside.T).min()) - hull)
    distance = float(np.hypot(*(start.goal[:2] - start.motion[0, :2])))
    return way / boat_speed(params) + float(push_time(params, np.array(distance)))


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the median bound of each condition of a suite."""
    parser = argparse.ArgumentParser(prog="python -m baselines.evaluate.bound", description=__doc__)
    parser.add_argument("--suite", default="plane-v1", help=", ".join(SUITES))
    parser.add_argument("--episodes", type=int, default=500, help="of each condition (%(default)s)")
    options = parser.parse_args(arguments)
    try:
        suite = SUITES[choice("suite", options.suite, SUITES)].first(options.episodes)
    except ValueError as error:
        parser.error(str(error))
    for condition in suite.conditions:
        times = [
            least_time(
                condition.params, starts.sample(condition.params, np.random.default_rng(seed))
            )
            for seed in suite.seeds
        ]
        low, middle, high = np.percentile(times, [5, 50, 95])
        print(
            f"{condition.name:14} no sooner than {middle:.1f} s (5 to 95 %: {low:.1f} to {high:.1f})"
        )


if __name__ == "__main__":
    main()
