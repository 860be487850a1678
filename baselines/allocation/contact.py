"""How a boat in contact exerts its force on the hull and keeps its place there.

A boat's autopilot holds its speed over ground with a gain that is known, so a boat that is held
back by the hull pushes with that gain times the speed that it lacks. The speed is that of the
hull's reference motion plus what the wanted force takes: then boats that push against each other
are also a servo of the vessel's velocity, which knows no noise but that of their own logs.

Along the hull a boat has no motor. It moves there by a yaw offset, which turns its force and the
lift of its hull; and friction takes it along, or lets it take the vessel along.
"""

import numpy as np

from asv_env.params import EnvParams
from asv_env.physics.autopilot import bandwidth
from asv_env.types import Bool, Complex, Float
from baselines.allocation.allocation_gains import AllocationGains
from baselines.allocation.boats import Boats

SLACK = 0.02  #: distance along the hull from its place within which a boat stays where it is, m
WIDE_SLACK = 0.04  #: the same while the team carries the vessel sideways, m
TOUCHES = 0.004  #: gap to the hull that is put down to noise, m
WIDEST = 0.03  #: gap beyond which a boat closes in no faster, m
LEAST_FRICTION = 0.01  #: floor of a divisor
LEAST_GRIP = 0.15  #: force below which a yaw offset does little, fractions of full thrust


class Contact:
    """Forces, speeds and headings of boats at their places on the hull."""

    def __init__(self, params: EnvParams, gains: AllocationGains) -> None:
        self._boat, self._gains = params.hulls()[1], gains
        self.thrust = 2 * self._boat.thrust  #: of a boat, N
        #: force on the hull per lack of speed, N s/m
        self.servo = self._boat.masses[0] * bandwidth(self._boat) + self._boat.surge[0]
        self._friction = max(params.water.contact_friction, LEAST_FRICTION)

    def sideways(self, boats: Boats, slides: Bool) -> Float:
        """Returns the forces (W, A) N, to their left, that boats need to keep their places.

        Teams that carry the vessel sideways, in the worlds ``slides`` (W,), leave their boats where
        they are as long as possible: a boat that returns to its place takes the vessel along.
        """
        boat, gains = self._boat, self._gains
        hull, own, drift = (
            each / boats.inward for each in (boats.hull, boats.velocity, boats.water)
        )
        slack = np.where(slides, WIDE_SLACK, SLACK)[:, None]
        beyond = boats.gap.imag - np.clip(boats.gap.imag, -slack, slack)
        wanted = hull.imag + gains.sideways_gain * beyond
        damping = boat.sway[0] + boat.sway[1] * np.abs(own.imag - drift.imag)
        resistance = damping * (wanted - drift.imag)
        change = boat.masses[1] * (wanted - own.imag) / gains.sideways_time
        # The momentum of a boat that goes ahead turns with the hull.
        turning = boat.masses[0] * boats.yaw_rate * hull.real
        force: Float = resistance + change + turning
        return force

    def grip(self, sideways: Float, holds: Bool) -> Float:
        """Returns the forces (W, A) N near which boats are to push, whatever the vessel needs.

        With them friction can hold the boats against the forces ``sideways`` (W, A) N. Teams that
        hold the vessel at its goal, in the worlds ``holds`` (W,), push more.
        """
        gains = self._gains
        needed = gains.min_force * self.thrust + np.abs(sideways) / self._friction
        more = np.where(holds, gains.hold_grip, 0.0)[:, None]
        grip: Float = np.minimum(needed, gains.max_grip * self.thrust) + more * self.thrust
        return grip

    def command(
        self, boats: Boats, force: Float, sideways: Float, holds: Bool
    ) -> tuple[Float, Float]:
        """Returns speeds, m/s, and heading errors, rad, (W, A) of boats that push.

        Args:
            boats: with the hull's velocity as it is wanted.
            force: (W, A) on the hull, N.
            sideways: (W, A) that they need along the hull, N.
            holds: (W,) whether the team holds the vessel: then gaps, which are noisy, do not count.
        """
        gains = self._gains
        ahead = ((boats.hull - boats.water) / boats.inward).real
        # Force and lift point the same way along the hull, but for boats that go astern.
        per_offset = force + self._boat.sway[0] * ahead
        least = LEAST_GRIP * self.thrust
        offset = sideways * per_offset / (per_offset**2 + least**2)
        offset = np.clip(offset, -gains.max_offset, gains.max_offset)
        closing = gains.gap_gain * np.clip(boats.gap.real - TOUCHES, 0.0, WIDEST)
        closing = np.where(holds[:, None], 0.0, closing)
        speed = (boats.hull / boats.bow).real + force / self.servo + closing
        return speed, np.angle(boats.inward * np.exp(1j * offset) / boats.bow)

    def felt(self, boats: Boats, force: Float, moves: Complex) -> Float:
        """Returns the forces (W, A) N that boats exert on a hull that does not move as wanted.

        Args:
            boats: with the hull's velocity as it is wanted.
            force: (W, A) that they are to exert, N.
            moves: (W, A) the hull's velocity where they are, m/s, vessel frame.
        """
        lack = ((boats.hull - moves) / boats.inward).real
        return np.maximum(force + self.servo * lack, 0.0)
