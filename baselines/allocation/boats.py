"""Boats at and round a hull, as the laws of the policy see them: in the vessel's frame."""

from dataclasses import dataclass

from asv_env.types import Bool, Complex, Float, Int


@dataclass(frozen=True)
class Boats:
    """Motion of boats and where they belong; vectors are in the vessel's frame."""

    position: Complex  #: (W, A) m
    bow: Complex  #: (W, A) directions in which they point
    velocity: Complex  #: (W, A) m/s
    hull: Complex  #: (W, A) velocity of the hull where they are, measured or wanted, m/s
    water: Complex  #: (W, 1) velocity of the water, m/s
    yaw_rate: Float  #: (W, 1) of the hull, measured or wanted, rad/s
    place: Complex  #: (W, A) where they touch the hull, m
    inward: Complex  #: (W, A) directions in which they point there
    number: Int  #: (W, A) numbers of these places in the formation
    working: Bool  #: (W, A) whether they work
    seen: Bool  #: (W, A) whether they are in sight

    @property
    def gap(self) -> Complex:
        """From each boat to its place: ahead, and to the left of the place's direction, m."""
        gap: Complex = (self.place - self.position) / self.inward
        return gap

    @property
    def alignment(self) -> Float:
        """Cosines (W, A) of the angles between the boats and the directions of their places."""
        alignment: Float = (self.bow / self.inward).real
        return alignment
