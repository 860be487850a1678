"""What the vessel needs to follow its path: the force and the moment that the boats are to exert.

The path is planned as the vessel sees the water. A current carries vessel and path alike, and the
path is laid so that it has been carried to the goal when the vessel comes to its end. There the
team holds it against the water, where the task wants it held. A vessel that leaves its path or
passes its goal gets a new path. One that obstacles keep from moving is let go of, and one beside
which a clear path begins is slid there along its length before it is let go of.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from asv_env.geometry import direction, wrap, xy
from asv_env.params import NOMINAL_LENGTH, EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, zeros
from baselines.paper.arcs import ArcPath
from baselines.paper.coasting import coasting_distance, drag
from baselines.scripted import clear_paths
from baselines.scripted.clear_planner import ClearPlanner
from baselines.scripted.gains import PushGains, Tolerances
from baselines.scripted.lqr import PreviewLqr
from baselines.scripted.observer import VesselMemory
from baselines.scripted.planner import SEGMENTS, PathPlanner

MAX_CROSS_TRACK = 0.2  #: saturation of the cross-track error, vessel lengths
MAX_HEADING_ERROR = 0.7  #: saturation of the heading error, rad
OFF_PATH = 0.75  #: cross-track error at which a new path is planned, vessel lengths
PATIENCE = 10.0  #: time after which a vessel among obstacles that does not move is let go of, s
STILL = 0.05  #: distance within which it does not move, vessel lengths
STILL_HEADING = 0.1  #: turn within which it does not move, rad
SLID = 0.05  #: cross-track error at which a vessel has been slid to its path, vessel lengths
PAST_GOAL = 0.15
"""Path length beyond the goal at which a new path is planned, vessel lengths: a little more than
the tolerance, within which the vessel may still come to rest."""
HOLD_TIME = 3.0
"""Time before the goal, s, in which the team begins to hold the vessel over ground: that in which
its velocity along the hull follows a force."""
HOLD_GAIN = 0.2  #: speed over ground per distance with which a held vessel returns to its goal, 1/s
HOLD_FIRMNESS = 0.5  #: force per mass and speed error of a held vessel, 1/s
UNCAGED_HEADING = 0.1  #: tolerated heading error where no end boat prevents skidding, rad


@dataclass
class PathMemory:
    """The vessel's path through the water."""

    start: Float  #: (W, 3) pose where it begins; m, m, rad
    curvature: Float  #: (W, SEGMENTS) 1/m
    length: Float  #: (W, SEGMENTS) m; segments that are not needed have length 0
    progress: Float  #: (W,) path length behind the vessel, m
    replan: Bool  #: (W,) whether a new path is needed
    released: Bool  #: (W,) whether the team has let go of the vessel
    cruise: Float  #: (W,) largest speed of the vessel, m/s
    halts: Bool  #: (W,) whether the path ends where the team has to switch to the other side
    switch: Bool  #: (W,) whether the team has to switch to the other side now
    held: Float  #: (W,) to which share the vessel is held over ground
    slides: Bool  #: (W,) whether the vessel is slid along its length to where the path begins
    lets_go: Bool  #: (W,) whether the team has to grasp the vessel again
    mark: Float  #: (W, 3) pose from which the vessel has hardly moved; m, m, rad
    still: Float  #: (W,) time for which it has not, s

    @classmethod
    def empty(cls, worlds: int, among_obstacles: bool = False) -> Self:
        """Returns memory to be filled by ``PathFollower.plan``."""
        segments = worlds, clear_paths.SEGMENTS if among_obstacles else SEGMENTS
        return zeros(cls, (worlds, 3), segments, segments, *[(worlds,)] * 9, (worlds, 3), (worlds,))


class PathFollower:
    """Plans the vessel's path and computes what keeps the vessel on it, and on time."""

    def __init__(
        self,
        params: EnvParams,
        planner: PathPlanner,
        gains: PushGains,
        tolerances: Tolerances,
        among: ClearPlanner | None = None,
    ) -> None:
        vessel, _ = params.hulls()
        self._among, self._dt = among, 1.0 / params.clock.control
        self._vessel, self._planner, self._gains = vessel, planner, gains
        self._holds = params.task.delivery == "holding"
        self._caged = PreviewLqr(vessel, tolerances)
        self._uncaged = PreviewLqr(vessel, replace(tolerances, force=0.0, heading=UNCAGED_HEADING))
        self.preview_times = self._caged.preview_times

    def plan(
        self,
        relations: Relations,
        vessel: VesselMemory,
        memory: PathMemory,
        which: Bool,
        obstacle: Float | None = None,
        can_slide: Bool | None = None,
    ) -> None:
        """Plans paths from where the vessels are, in the worlds ``which`` (W,), into ``memory``.

        They keep clear of obstacles (W, M, 5), for which teams that ``can_slide`` (W,) may slide
        the vessel along its length first. In moving water without any the team switches to the
        other side where a path from there is faster, with the time for going round.
        """
        if not which.any():
            return
        position, heading = relations.position[which, 0], relations.heading[which, 0]
        goal, turn = relations.goal[which], -relations.heading_error[which]
        water, mean = vessel.drift[which] * heading.conj(), vessel.mean[which] * heading.conj()
        path, carried, time = self._planned(goal, turn, water, mean)
        start = position + carried * heading
        pose = np.stack([start.real, start.imag, np.angle(heading)], axis=-1)
        memory.cruise[which] = self._planner.gains.speed
        if self._among is not None and obstacle is not None:
            end = position + goal * heading
            aim = np.stack([end.real, end.imag, np.angle(heading) + turn], axis=-1)
            slide = np.zeros(len(path.length), bool) if can_slide is None else can_slide[which]
            plans = self._among.plan(pose, aim, obstacle[which], path, slide)
            path, memory.switch[which], memory.halts[which], memory.slides[which] = plans
            pose = path.start
            memory.cruise[which] = self._planner.cruise(path)
        elif self._holds:
            *_, other = self._planned(goal.conj(), -turn, water.conj(), mean.conj())
            faster = other + self._planner.gains.turning_time < time
            memory.switch[which] = faster & (np.abs(water) > self._planner.gains.still_water)
        memory.start[which] = pose
        memory.curvature[which], memory.length[which] = path.curvature, path.length
        memory.progress[which], memory.replan[which] = 0.0, False

    def watch(self, relations: Relations, memory: PathMemory, begins: Bool) -> None:
        """Lets go of vessels that obstacles keep from moving, so that their paths are replaced.

        The time counts from where a push ``begins`` (W,). ``memory`` is updated.
        """
        if self._among is None:
            return
        position, heading = relations.position[:, 0], np.angle(relations.heading[:, 0])
        moved = np.hypot(*(xy(position) - memory.mark[:, :2]).T) > STILL * self._vessel.size
        moved |= np.abs(wrap(heading - memory.mark[:, 2])) > STILL_HEADING
        moved |= begins | memory.released
        memory.mark[moved] = np.stack([position.real, position.imag, heading], axis=-1)[moved]
        memory.still = np.where(moved, 0.0, memory.still + self._dt)
        memory.lets_go |= memory.still > PATIENCE

    def _planned(
        self, goal: Complex, turn: Float, water: Complex, mean: Complex
    ) -> tuple[ArcPath, Complex, Float]:
        """Returns paths to goals (n,) m and headings (n,) rad, in the vessel's frame.

        ``water`` (n,) is its velocity in that frame, and ``mean`` (n,) that on the way so far, m/s.

        Returns:
            The paths through the water; how far it carries vessels until they are there (n,), m;
            and when they are there (n,), s.
        """
        run_out = self._run_out(water, turn)
        path, carried = self._planner.plan(goal, turn), 0.0 * goal
        if (water != 0).any():
            for _ in range(2):  # The time depends on the path, and that on the time.
                carried = self._carried(water, mean, path.total_length, run_out)
                path = self._planner.plan(goal - carried, turn)
        return path, carried, self._time(path.total_length, run_out)

    def wrench(
        self, relations: Relations, vessel: VesselMemory, caged: Bool, memory: PathMemory
    ) -> tuple[Float, Float, Float]:
        """Returns what leads the vessel along its path to rest at the goal.

        Args:
            relations: estimated relations.
            vessel: what is known of the vessel and its water.
            caged: (W,) whether end boats can exert the force along the hull.
            memory: the paths; ``progress``, ``replan`` and ``held`` are updated.

        Returns:
            Force (W,) towards -n, N, negative where the vessel is too fast; force (W,) along the
            hull, N; moment (W,), N m.
        """
        drift = vessel.drift
        water = drift * relations.heading[:, 0].conj()
        velocity = relations.velocity[:, 0] * relations.heading[:, 0].conj() - water
        speed, yaw_rate = -velocity.imag, relations.yaw_rate[:, 0]
        run_out = self._run_out(water, -relations.heading_error)
        tracked = self.track(relations, vessel, speed, run_out, memory)
        cross_track, turned, remaining, curvature = tracked
        held = self._held(drift, self._time(remaining, run_out)) * ~memory.halts
        held = np.where(memory.slides, 1.0, held)
        memory.held = held
        stream = held * water.real
        limit = MAX_CROSS_TRACK * self._vessel.size
        cross_track = np.clip(cross_track, -limit, limit)
        turned = np.clip(turned, -MAX_HEADING_ERROR, MAX_HEADING_ERROR)
        deviation = np.stack([cross_track, turned, velocity.real + stream, yaw_rate], axis=-1)
        lqrs = self._caged, self._uncaged
        wrenches = (lqr.wrench(speed, deviation, curvature) for lqr in lqrs)
        along, moment = np.where(caged[:, None], *wrenches).T
        limit = self._gains.max_end_force * self._vessel.size / NOMINAL_LENGTH
        along -= drag(self._vessel.surge, stream)
        slows = np.where(memory.halts, np.inf, remaining + run_out)
        forward = self._planner.force(slows, speed, self._gains.speed_gain, memory.cruise)
        # A vessel that is slid is held where its path begins.
        to_go = remaining - np.where(memory.slides, memory.length.sum(axis=1), 0.0)
        wanted = HOLD_GAIN * to_go + water.imag
        firmness = HOLD_FIRMNESS * self._vessel.masses[1]
        holding = drag(self._vessel.sway, wanted) + firmness * (wanted - speed)
        forward = (1 - held) * forward + held * holding
        return forward, np.clip(along, -limit, limit), moment

    def track(
        self,
        relations: Relations,
        vessel: VesselMemory,
        speed: Float,
        run_out: Float,
        memory: PathMemory,
    ) -> tuple[Float, Float, Float, Float]:
        """Finds the vessel on its path, and updates ``memory.progress`` and ``memory.replan``.

        The path is where the water will have carried it when the vessel reaches the goal, so the
        vessel's position is moved by the drift until then.

        Returns:
            Cross-track error (W,) along the hull, m; heading error (W,), rad; path length (W,)
            to the goal, m; curvature (W, PREVIEW_POINTS) of the path ahead, 1/m.
        """
        path = ArcPath(memory.start, memory.curvature, memory.length)
        total, length = path.total_length, self._vessel.size
        carried = self._carried(vessel.drift, vessel.mean, total - memory.progress, run_out)
        reference = path.pose_at(memory.progress)
        offset = relations.position[:, 0] + carried - (reference[:, 0] + 1j * reference[:, 1])
        offset = offset * direction(-reference[:, 2])
        reached = memory.progress - offset.imag
        slid = memory.slides & (np.abs(offset.real) < SLID * length)
        memory.slides, memory.lets_go = memory.slides & ~slid, slid
        memory.progress = np.where(memory.slides, 0.0, np.clip(reached, 0.0, total))
        heading = path.pose_at(memory.progress)[:, 2]
        off_path = (np.abs(offset.real) > OFF_PATH * length) & ~memory.slides
        memory.replan = off_path | (reached - total > PAST_GOAL * length)
        if memory.halts.any():
            coasts = coasting_distance(self._vessel, np.maximum(speed, 0.0))
            memory.switch |= memory.halts & (total - reached < coasts)
        ahead = np.maximum(speed, 0.0)[:, None] * self.preview_times
        curvature = path[:, None].curvature_at(memory.progress[:, None] + ahead)
        heading_error = wrap(np.angle(relations.heading[:, 0]) - heading)
        return offset.real, heading_error, total - reached, curvature

    def _run_out(self, water: Complex, turn: Float) -> Float:
        """Returns how far (W,) beyond the goal the timetables end, m.

        In still water the vessel comes to rest at the goal. In moving water it passes the goal, or
        is held there: then it still moves through the water, as fast as that comes to meet it.

        Args:
            water: (W,) velocity of the water in the vessel's frame, m/s.
            turn: (W,) heading of the goal in that frame, rad.
        """
        gains = self._planner.gains
        meets = (water * direction(-turn)).imag
        through = np.maximum(meets, gains.held_speed) if self._holds else gains.passing_speed
        moves = np.abs(water) > gains.still_water
        return np.where(moves, self._planner.run_out(through), 0.0)

    def _held(self, drift: Complex, time: Float) -> Float:
        """Returns to which share (W,) vessels are held over ground, at times (W,) from the goal."""
        moves = np.abs(drift) > self._planner.gains.still_water
        return np.exp(-np.maximum(time, 0.0) / HOLD_TIME) * (moves & self._holds)

    def _carried(self, drift: Complex, mean: Complex, remaining: Float, run_out: Float) -> Complex:
        """Returns how far (W,) m water carries vessels on path lengths (W,) m to the goal.

        Its velocity (W,) here, m/s, differs from the ``mean`` (W,) on the way so far, to which it
        returns on the way ahead.
        """
        lasting = self._planner.lasting(remaining + run_out, remaining)
        return mean * self._time(remaining, run_out) + (drift - mean) * lasting

    def _time(self, remaining: Float, run_out: Float) -> Float:
        """Returns the times (W,) to the goal, s, for the path lengths (W,) to it, m."""
        return self._planner.time(remaining + run_out) - self._planner.time(run_out)
