"""Plans the vessel's path to its goal, and its speed along it."""

import numpy as np
from numpy.typing import ArrayLike

from asv_env.geometry import direction
from asv_env.params import VesselParams
from asv_env.types import Complex, Float
from baselines.paper import dubins
from baselines.paper.arcs import ArcPath
from baselines.paper.coasting import coasting_distance, coasting_speed, drag
from baselines.scripted.gains import PathGains

SEGMENTS = 4  #: number of segments of a path: three of a Dubins path, and the final straight
CHOICES = 3  #: number of arc radii, and of lengths of the final straight, that are tried
ROUNDING = 1e-9  #: relative, of radii
TINY = 1e-9  #: floor of divisors that are curvatures, 1/m
TIMETABLE_LENGTH = 100.0  #: path length up to which the timetable reaches, lengths of the vessel


class PathPlanner:
    """Plans paths for a vessel, and their timetable.

    Raises:
        ValueError: the vessel has no linear sway drag and would never come to rest.
    """

    def __init__(self, vessel: VesselParams, gains: PathGains) -> None:
        if vessel.sway[0] <= 0:
            raise ValueError(
                f"vessel.sway = {vessel.sway}: without linear drag the vessel never comes to "
                "rest, and the scripted policy cannot stop it; give a value above 0"
            )
        self._vessel, self.gains = vessel, gains
        self._overshoot = coasting_distance(vessel, gains.goal_speed / gains.braking)
        # Near the goal the speed changes within centimetres; far from it, it does not change.
        remaining = TIMETABLE_LENGTH * vessel.size * np.linspace(0.0, 1.0, 5000) ** 2
        slowness = 1.0 / self.speed(remaining)
        steps = np.diff(remaining) * (slowness[1:] + slowness[:-1]) / 2
        self._timetable = remaining, np.concatenate([[0.0], np.cumsum(steps)])
        # Time weighted by how far ahead it is spent: the weight falls by a factor e in ``reach``.
        self._reach = gains.current_length * vessel.size
        lasting, keep = np.zeros(len(remaining)), np.exp(-np.diff(remaining) / self._reach)
        for k, (step, kept) in enumerate(zip(steps, keep, strict=True)):
            lasting[k + 1] = kept * lasting[k] + step
        self._lasting = remaining, lasting

    def plan(self, goal: Complex, heading: Float) -> ArcPath:
        """Returns paths from the origin to goals, at positions (W,) m and headings (W,) rad.

        The candidates are shortest paths of bounded curvature with a final straight, on which
        the vessel recovers from the turn and slows down. Wide arcs and long straights are easier
        to follow, so they make up for some path length in the cost.
        """
        gains, length = self.gains, self._vessel.size
        radii = gains.widest_radius * np.linspace(1.0, gains.tightest_radius, CHOICES)
        straights = gains.final_straight * np.linspace(1.0, 0.0, CHOICES)
        radius, straight = (grid.reshape(-1, 1) for grid in np.meshgrid(radii, straights))
        cost = gains.radius_cost * (gains.widest_radius - radius)
        cost = cost + gains.straight_cost * (gains.final_straight - straight)
        before = goal + 1j * straight * length * direction(heading)
        poses = np.stack(np.broadcast_arrays(before.real, before.imag, heading), axis=-1)
        paths = dubins.shortest(poses, radius * length / 2)
        last = np.broadcast_to(straight * length, before.shape)[..., None]
        lengths = np.concatenate([paths.length, last], axis=-1)
        curvatures = np.concatenate([paths.curvature, np.zeros_like(last)], axis=-1)
        best = np.argmin(lengths.sum(axis=-1) + length * cost, axis=0), np.arange(len(goal))
        return ArcPath(np.zeros(3), curvatures[best], lengths[best])

    def speed(self, remaining: Float, cruise: Float | None = None) -> Float:
        """Returns the speed (...) m/s of the vessel where path lengths (...) in m remain.

        It does not exceed ``cruise`` (...) m/s; None takes the gain.

        Nobody can brake the vessel. It slows down with the water's drag, always at a fraction of
        the speed from which it would coast to rest a little beyond the goal.
        """
        coasting = coasting_speed(self._vessel, np.maximum(remaining + self._overshoot, 0.0))
        fastest = self.gains.speed if cruise is None else cruise
        return np.minimum(fastest, self.gains.braking * coasting)

    def run_out(self, speed: ArrayLike) -> Float:
        """Returns how far (...) beyond the goal timetables end, m, with speeds (...) m/s there."""
        speed = np.asarray(speed) / self.gains.braking
        return coasting_distance(self._vessel, speed) - self._overshoot

    def cruise(self, path: ArcPath) -> Float:
        """Returns the largest speeds (...) m/s on paths (...), so that no arc takes more force.

        On arcs that are tighter than those of open water the vessel is slower.
        """
        gains = self.gains
        widest = 1 / np.maximum(np.abs(path.curvature * (path.length > 0)).max(axis=-1), TINY)
        usual = gains.widest_radius * gains.tightest_radius * self._vessel.size / 2
        narrow = widest < (1 - ROUNDING) * usual
        return gains.speed * np.where(narrow, np.sqrt(widest / usual), 1.0)

    def force(self, remaining: Float, speed: Float, gain: float, cruise: Float) -> Float:
        """Returns forces (...) N that bring a vessel from speeds (...) m/s to its timetable.

        The largest speeds on it are ``cruise`` (...) m/s.
        """
        wanted = self.speed(remaining, cruise)
        resistance = drag(self._vessel.sway, wanted)
        resistance *= np.where(wanted < cruise, 1 - self.gains.braking, 1.0)
        return resistance + gain * self._vessel.masses[1] * (wanted - speed)

    def time(self, remaining: Float) -> Float:
        """Returns the time (...) s that the vessel needs for the path lengths (...) in m left."""
        return np.interp(remaining, *self._timetable)

    def lasting(self, remaining: Float, ahead: Float) -> Float:
        """Returns for how long (...), s, the current that is met now carries the vessel.

        It is that over the next ``ahead`` (...) of the path lengths ``remaining`` (...), m. The
        current is taken to be another one farther on: its share falls by a factor e over
        ``PathGains.current_length``.
        """
        beyond = np.interp(remaining - ahead, *self._lasting)
        fades = np.exp(-np.maximum(ahead, 0.0) / self._reach)
        return np.interp(remaining, *self._lasting) - fades * beyond
