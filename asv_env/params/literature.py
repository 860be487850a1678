"""Published craft as boats: masses, added masses, damping and thrust, each with its source.

The models are diagonal: the centre of gravity lies amidships and damping couples no axes. Every
boat has a flat bow as wide, for its beam, as the nominal boat's, with which it pushes. Its
autopilot is the nominal one at the craft's scale, as far as its motors can follow it.
"""

import math
from dataclasses import dataclass, replace
from types import MappingProxyType

from asv_env.params.hull_params import BoatParams
from asv_env.params.scaling import scaled


@dataclass(frozen=True)
class Craft:
    """A published craft, and the world in which four of it push a barge."""

    boat: BoatParams  #: its hull and motors, its autopilot
    scale: float  #: Froude scale of the world: how many times longer than the nominal one
    source: str  #: where its numbers stand


def steady(effort: float, drag: tuple[float, float]) -> float:
    """Returns the speed, m/s or rad/s, at which drag balances a force, N, or a moment, N m."""
    linear, quadratic = drag
    if quadratic == 0.0:
        return effort / linear
    return (math.sqrt(linear**2 + 4 * quadratic * effort) - linear) / (2 * quadratic)


def craft(hull: BoatParams, scale: float, source: str) -> Craft:
    """Returns a craft whose boat has a bow and an autopilot for the world of its scale."""
    like, (surge, _, yaw) = scaled(BoatParams(), scale), hull.masses
    force = 2 * hull.thrust
    moment = 2 * hull.astern * hull.thrust * hull.lever_arm
    boat = replace(
        hull,
        bow=like.bow / like.width * hull.width,
        full_speed=min(like.full_speed, steady(force, hull.surge)),
        full_yaw_rate=min(like.full_yaw_rate, steady(moment, hull.yaw)),
        response=like.response,
        acceleration=(
            min(like.acceleration[0], force / surge),
            min(like.acceleration[1], moment / yaw),
        ),
    )
    return Craft(boat, scale, source)


OTTER = craft(
    BoatParams(
        length=2.0,
        width=1.08,
        mass=80.0,  # 55 kg, and 25 kg of payload
        added_mass=(8.0, 120.0),  # 0.1 and 1.5 times the mass
        inertia=20.0,  # radius of gyration 0.25 lengths
        added_inertia=34.0,  # 1.7 times the inertia
        surge=(77.55443234836703, 0.0),  # full thrust, 24.4 kgf, at 6 knots
        sway=(200.0, 0.0),  # time constant 1 s
        yaw=(54.0, 540.0),  # time constant 1 s, and ten times that per rad/s
        thrust=119.682,  # bollard pull of one propeller, 12.2 kgf
        astern=13.6 / 24.4,
        lever_arm=0.395,
        lag=0.1,
        thrust_law="quadratic",
    ),
    scale=2.0 / 0.12,
    source="Maritime Robotics Otter: T. I. Fossen, Marine Systems Simulator (MSS), otter.m; "
    "Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., 2021",
)
HERON = craft(
    BoatParams(
        length=1.35,
        width=0.98,
        mass=28.0,
        added_mass=(0.0, 0.0),
        inertia=10.0,
        added_inertia=0.0,
        surge=(16.44998712, 2.942),
        sway=(15.79776044, 2.7617212),
        yaw=(6.0, 5.0),
        thrust=33.6,
        astern=19.88 / 33.6,
        lever_arm=0.377654,
        lag=0.05,
        thrust_law="linear",  # nearest to the measured curve of eleven points
    ),
    scale=1.35 / 0.12,
    source="Clearpath Heron: the maker's public ROS configuration, github.com/heron/heron, "
    "heron_description/urdf (base, gazebo, snippets and actuators.xacro); length and width "
    "from its data sheet",
)
CYBERSHIP2 = craft(
    BoatParams(
        length=1.255,
        width=0.29,
        mass=23.8,
        added_mass=(2.0, 10.0),
        inertia=1.76,
        added_inertia=1.0,
        # The cubic term, 5.866 kg s/m^2, is taken as quadratic drag at 0.55 m/s, a full action.
        surge=(0.72253, 1.32742 + 5.86643 * 0.55),
        # Measured at rest; 5.17 kg/s are the lift of the hull (draft 0.11 m) at half that speed.
        sway=(0.88965 + 5.17, 36.47287),
        yaw=(1.9, 0.75),
        thrust=4.05,  # 3.65e-3 N s^2 at 33.3 revolutions a second
        astern=1.0,
        # Rudders and bow thruster make 1.5 N m; two motors would make it at this distance.
        lever_arm=1.5 / (2 * 4.05),
        lag=0.1,
        thrust_law="quadratic",
    ),
    scale=(4.05 / 0.010) ** (1 / 3),  # by thrust
    source="CyberShip II: R. Skjetne, O. N. Smogeli and T. I. Fossen, A nonlinear ship "
    "manoeuvering model: identification and adaptive control with experiments for a model ship, "
    "Modeling, Identification and Control 25(1), 2004; yaw moment of 1.5 N m: M. Wondergem et "
    "al., IEEE Transactions on Control Systems Technology 19(2), 2011; 2,000 rpm: a public "
    "simulation of the model, which reaches its 1 m/s",
)
CRAFT = MappingProxyType({"otter": OTTER, "heron": HERON, "cybership2": CYBERSHIP2})
"""Published craft by name."""
