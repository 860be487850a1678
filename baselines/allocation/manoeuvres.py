"""How two boats move a vessel: one manoeuvre after the other, and it coasts in between.

Two boats cannot hold a vessel, and cannot brake what they move. But every pair of contact points
has a cone of wrenches: two boats on one side drive the vessel and steer it by the difference of
their forces, two at opposite corners turn it on the spot, two at one end slide it along its length.
The team pushes until the vessel will come to rest where the manoeuvre is to end (``Pushes``),
leaves it alone, and chooses the next manoeuvre by the pose in which it will rest. While it coasts
the boats go to their next places.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from asv_env.geometry import wrap
from asv_env.params import EnvParams
from asv_env.tasks.formation import Relations
from asv_env.types import Bool, Complex, Float, Int, zeros
from baselines.allocation.allocation_gains import ManoeuvreGains
from baselines.allocation.boats import Boats
from baselines.allocation.contact_points import pairs
from baselines.scripted.gains import PathGains, PushGains
from baselines.scripted.settling import Settling

DRIVE, TURN, SLIDE, REST = 0, 2, 4, 6
"""Numbers of manoeuvres. Odd ones are the opposites: against the axis, or clockwise."""
FAR_FROM_PLACE = 0.08  #: distance to its place beyond which a boat is not at the hull, m

Pose = tuple[Complex, Float]
"""Position of the goal (W,) in the vessel's frame, m, and its heading (W,) in that frame, rad."""


@dataclass
class ManoeuvreMemory:
    """What teams of two are about to do."""

    kind: Int  #: (W,) number of the manoeuvre
    leaving: Bool  #: (W,) whether boats leave the hull after the one before
    doubt: Int  #: (W,) ticks for which another manoeuvre has been better
    lost: Int  #: (W,) ticks for which a boat has been out of place in a push
    touched: Bool  #: (W, A) boats that have touched the hull in the push

    @classmethod
    def empty(cls, worlds: int, team: int) -> Self:
        """Returns memory to be filled when episodes begin."""
        return zeros(cls, *[(worlds,)] * 4, (worlds, team))


class Manoeuvres:
    """Chooses the manoeuvres of teams of two."""

    def __init__(self, params: EnvParams, gains: ManoeuvreGains) -> None:
        self._gains, hz = gains, params.clock.control
        self._position = params.task.position_tolerance
        self._heading = params.task.heading_tolerance
        self._doubt, self._lost = gains.doubt_time * hz, gains.lost_time * hz
        self.pairs = pairs(*params.hulls())
        self._settling = Settling(params, PushGains(), PathGains.still_water)

    def rest(self, relations: Relations, drift: Complex) -> Pose:
        """Returns the goal as it will lie when the vessel has come to rest.

        Args:
            relations: estimated relations.
            drift: (W,) velocity of the water, m/s, world frame.
        """
        still = np.abs(drift) <= PathGains.still_water  # Then its drift is an error.
        goal, error = self._settling.rest(relations, np.where(still, 0.0, drift))
        return goal, -wrap(error)

    def update(
        self, boats: Boats, memory: ManoeuvreMemory, rest: Pose, begins: Bool, grasped: Bool
    ) -> Bool:
        """Updates manoeuvres, in place; returns the worlds (W,) whose boats get new places.

        A manoeuvre is chosen when an episode ``begins`` (W,), when the boats have left the hull,
        and where another has been better for some time before the team has ``grasped`` (W,).
        """
        wanted = self.choose(rest, (memory.kind == REST) & ~begins)
        gap = boats.gap
        clear = (gap.real > self._gains.clearance) | (np.abs(gap) > FAR_FROM_PLACE)
        left = memory.leaving & (clear | ~boats.working).all(axis=1)
        waits = ~(begins | grasped | memory.leaving)
        doubted = waits & (wanted != memory.kind) & ~self.useful(memory.kind, rest)
        memory.doubt = np.where(doubted, memory.doubt + 1, 0)
        drops = memory.doubt > self._doubt
        chooses = left | begins
        memory.leaving = (memory.leaving | drops) & ~chooses
        memory.kind = np.where(chooses, wanted, memory.kind)
        memory.doubt[drops] = 0
        return chooses & (begins | (memory.kind != REST))

    def release(self, memory: ManoeuvreMemory, done: Bool, lost: Bool) -> Bool:
        """Returns where (W,) boats let go: where a push is done, or boats are lost for too long.

        Args:
            memory: updated in place.
            done: (W,) whether the vessel will come to rest where the push is to end.
            lost: (W,) whether boats are out of their places in a push.
        """
        memory.lost = np.where(lost, memory.lost + 1, 0)
        free = done | (memory.lost > self._lost)
        memory.leaving |= free
        return free

    def choose(self, rest: Pose, resting: Bool) -> Int:
        """Returns the manoeuvres (W,) for vessels that will come to rest so.

        Far from its goal the vessel is driven there, and turned towards it first. Near the goal
        the largest error is taken away, until all are small. Where the boats leave the vessel alone
        already (``resting``, (W,)) larger ones are tolerated.
        """
        goal, turn = rest
        bearing, against = self.bearing(rest)
        turned = np.abs(bearing) <= self._gains.turn_bearing
        far = np.where(turned, DRIVE + against, TURN + (bearing < 0))
        along, aside, angle = self._errors(rest)
        options = TURN + (turn < 0), DRIVE + (along < 0), SLIDE + (aside < 0)
        near = np.choose(np.abs([angle, along, aside]).argmax(axis=0), options)
        error = np.maximum(np.hypot(along, aside), np.abs(angle))
        good = error < np.where(resting, self._gains.leave_error, self._gains.rest_error)
        return np.where(self.far(goal), far, np.where(good, REST, near))

    def useful(self, kind: Int, rest: Pose) -> Bool:
        """Returns where (W,) manoeuvres still take an error away."""
        sign, far = np.where(kind % 2 == 0, 1.0, -1.0), self.far(rest[0])
        bearing, against = self.bearing(rest)
        turned = np.abs(bearing) <= self._gains.turn_bearing
        errors = [sign * error > self._gains.useful_error for error in self._errors(rest)]
        drives = np.where(far, turned & (against == kind), errors[0])
        turns = np.where(far, sign * bearing > self._gains.turned_bearing, errors[2])
        slides = errors[1] & ~far
        return np.select([kind < TURN, kind < SLIDE, kind < REST], [drives, turns, slides], False)

    def far(self, goal: Complex) -> Bool:
        """Returns where (W,) the goal (W,) is so far that the vessel turns towards it."""
        return np.asarray(np.abs(goal) > self._gains.far * self._position)

    def bearing(self, pose: Pose) -> tuple[Float, Int]:
        """Returns the bearing (W,) of the goal, rad, and whether it is against the axis (W,).

        It is that from the end of the axis with which the vessel has to turn less.
        """
        goal, turn = pose
        along = np.angle(goal / self.pairs.axis)
        against = wrap(along + np.pi)
        turning, other = (np.abs(b) + np.abs(wrap(turn - b)) for b in (along, against))
        backwards = other < turning
        return np.where(backwards, against, along), backwards.astype(np.int64)

    def _errors(self, pose: Pose) -> tuple[Float, Float, Float]:
        """Returns the errors (W,) along the axis, to its left, and of the heading, tolerances."""
        offset = pose[0] / self.pairs.axis / self._position
        return offset.real, offset.imag, pose[1] / self._heading
