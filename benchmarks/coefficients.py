"""Hydrodynamic coefficients of the nominal hulls: ``python benchmarks/coefficients.py``.

Each coefficient is derived from the geometry by strip theory, from a cited drag coefficient, from
published craft, or from one datum of each hull, and rounded: the defaults of ``BoatParams`` and
``VesselParams`` are these numbers. ``docs/physics.md`` explains every line.

The free surface is a rigid lid (the low-frequency limit), so that a hull of draft T has half the
added mass of the double body of height 2 T.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from asv_env.params import BoatParams, VesselParams
from asv_env.params.strips import (
    DENSITY,
    PRISM_DRAG,
    end_factors,
    interpolated,
    rectangle_sway,
)
from asv_env.polygons import gyration
from baselines.evaluate.publish import marks
from baselines.rollout.commands import FilePath, command, say

VISCOSITY = 1.0e-6  #: kinematic, of fresh water at 20 degrees Celsius, m^2/s

BOAT_DRAFT = 0.016  #: m
TOP_SPEED = 0.229  #: of the boat at full thrust of both motors, m/s
BOAT_FORM_DRAG = 0.5
"""Surge drag coefficient of the boat on its frontal area.

Between a blunt prism along the flow (0.87 at four diameters) and a rounded nose (0.2 to 0.3):
White, Fluid Mechanics, table 7.3; Hoerner, Fluid-Dynamic Drag, chapter 3.
"""
LIFT_SPEED = 0.1  #: forward speed at which the lift on the hull is linearised, m/s
YAW_TIME = 0.45  #: yaw time constant of the boat, s: that of CyberShip II at 12 cm
LEVER_ARM = 0.37  #: distance of a motor from the centre line over the beam: that of the Otter

COAST = (0.04, 0.20)  #: the paper's datum: the vessel coasts sideways from m/s over m
PLATE_DRAG = 1.2  #: drag coefficient of a fin across the flow, a plate of few heights (table 7.3)
FIN_DEPTH = 0.02  #: of the two cross fins below the bottom of the vessel, m

PLATE = ((1.0, 0.579), (1.25, 0.642), (1.59, 0.704), (2.0, 0.757), (2.5, 0.801), (3.17, 0.840),
         (4.0, 0.872), (5.0, 0.897), (6.25, 0.917), (8.0, 0.934), (10.0, 0.947))  # fmt: skip
"""Aspect ratio of a plate across the flow, and its added mass over that of strips (table D-2)."""
CROSS_FLOW = (
    (0.99, 0.828), (1.31, 0.760), (1.64, 0.691), (1.86, 0.657), (2.31, 0.631), (2.60, 0.596),
    (3.01, 0.587), (3.45, 0.586), (3.74, 0.560), (4.00, 0.559),
)  # fmt: skip
"""B / 2T of a ship's section, and its cross-flow drag coefficient.

Hoerner's curve as digitised in Fossen, Handbook, 2nd edition, figure 6.5, and his MSS toolbox.
"""


@dataclass(frozen=True)
class Coefficients:
    """What is derived for a bare hull; the fields are those of ``HullParams``, in SI units."""

    added_mass: tuple[float, float]
    added_inertia: float
    surge: tuple[float, float]
    sway: tuple[float, float]
    yaw: tuple[float, float]


def lewis_sway(beam: float, draft: float, fullness: float) -> float:
    """Returns the added mass in sway of a Lewis section, kg/m.

    The section is the image of a circle under z = M (s + a1 / s + a3 / s^3). The low-frequency
    added mass is that of the double body (Landweber and Macagno 1957; Newman, section 4.13).

    Args:
        beam: m.
        draft: m.
        fullness: area of the section over beam times draft.
    """
    slender = (beam / (2 * draft) - 1) / (beam / (2 * draft) + 1)
    area = 4 * fullness / math.pi
    c = 3 + area + (1 - area) * slender**2
    a3 = (3 - c + math.sqrt(9 - 2 * c)) / c
    a1 = (1 + a3) * slender
    shape = ((1 - a1) ** 2 + 3 * a3**2) / (1 - a1 + a3) ** 2
    return DENSITY * math.pi / 2 * draft**2 * shape


def plate_mass(breadth: float, height: float) -> float:
    """Returns the added mass of a submerged plate across the flow, kg; ``breadth`` is longer."""
    strips = DENSITY * math.pi / 4 * height**2 * breadth
    return strips * interpolated(PLATE, breadth / height)


def friction(length: float, speed: float, area: float) -> float:
    """Returns laminar skin friction over speed, kg/s: Blasius, 1.328 over the root of Reynolds."""
    reynolds = speed * length / VISCOSITY
    return 0.5 * DENSITY * speed * area * 1.328 / math.sqrt(reynolds)


def lift(draft: float, speed: float) -> float:
    """Returns the lift of a hull at a small drift angle over its sway speed, kg/s.

    It is that of a wing of low aspect ratio, the double body (Jones 1946; Newman, chapter 7).
    """
    return DENSITY * math.pi / 2 * draft**2 * speed


def boat(hull: BoatParams) -> Coefficients:
    """Returns the coefficients of a boat of the nominal kind, with its draft and top speed."""
    length, beam, draft = hull.length, hull.width, BOAT_DRAFT
    waterplane = length * beam - hull.bow * (beam - hull.bow) / 2
    fullness = hull.mass / (DENSITY * waterplane * draft)  # Archimedes
    section = lewis_sway(beam, draft, fullness)
    ahead, sway_ends, yaw_ends = end_factors(length, beam, draft)
    added_inertia = yaw_ends * section * length**3 / 12

    form = 0.5 * DENSITY * BOAT_FORM_DRAG * beam * draft
    linear = 2 * hull.thrust / TOP_SPEED - form * TOP_SPEED
    across = 0.5 * DENSITY * interpolated(CROSS_FLOW, beam / (2 * draft)) * draft
    dry = hull.inertia
    if dry is None:
        dry = hull.mass * gyration(hull.corners)
    return Coefficients(
        added_mass=(ahead * hull.mass, sway_ends * section * length),
        added_inertia=added_inertia,
        surge=(linear, form),
        sway=(linear * math.sqrt(length / beam) + lift(draft, LIFT_SPEED), across * length),
        yaw=((dry + added_inertia) / YAW_TIME, across * length**4 / 32),
    )


def yaw_of_strips(hull: BoatParams, speed: float) -> float:
    """Returns the linear yaw damping of a boat's hull by friction and lift alone, N m s.

    Lift acts at the stern, where the flow leaves the hull; pods and propellers are left out.
    """
    derived = boat(hull)
    friction = derived.surge[0] * math.sqrt(hull.length / hull.width) * hull.length**2 / 12
    return friction + lift(BOAT_DRAFT, speed) * (hull.length / 2) ** 2


def turning_on_the_spot(hull: BoatParams) -> float:
    """Returns the yaw rate, rad/s, at which a boat turns with one motor ahead, one astern.

    Both give what a motor can astern.
    """
    linear, quadratic = boat(hull).yaw
    moment = 2 * hull.astern * hull.thrust * hull.lever_arm
    return (math.sqrt(linear**2 + 4 * quadratic * moment) - linear) / (2 * quadratic)


def vessel(hull: VesselParams) -> Coefficients:
    """Returns the coefficients of a plank without its fins; its draft follows from its mass."""
    length, beam = hull.length, hull.width
    draft = hull.mass / (DENSITY * length * beam)
    section = rectangle_sway(beam, draft)
    _, sway_ends, yaw_ends = end_factors(length, beam, draft)
    sway_mass = sway_ends * section * length

    across = 0.5 * DENSITY * PRISM_DRAG * draft
    speed, distance = COAST
    exponent = distance * across * length / (hull.mass + sway_mass)
    linear = speed * across * length / math.expm1(exponent)
    return Coefficients(
        added_mass=(plate_mass(beam, 2 * draft) / 2, sway_mass),
        added_inertia=yaw_ends * section * length**3 / 12,
        surge=(linear * math.sqrt(beam / length), across * beam),
        sway=(linear, across * length),
        yaw=(linear * length**2 / 12, across * length**4 / 32),
    )


def fin_drag(beam: float) -> float:
    """Returns the quadratic surge drag of both fins, kg/m."""
    return 0.5 * DENSITY * PLATE_DRAG * 2 * FIN_DEPTH * beam


def fin_mass(beam: float, draft: float) -> float:
    """Returns the added mass in surge of both fins, on top of the bare hull's, kg.

    The outer faces of both ends together are a plate from the surface to the bottom of the fins,
    mirrored at the surface; the inner faces are the fins, mirrored at the bottom of the hull.
    """
    outer = plate_mass(beam, 2 * (draft + FIN_DEPTH)) / 2
    inner = plate_mass(beam, 2 * FIN_DEPTH) / 2
    return outer + inner - plate_mass(beam, 2 * draft) / 2


def rounded(number: float, digits: int = 2) -> float:
    """Returns a number with so many significant digits."""
    return float(f"{number:.{digits - 1}e}")


def defaults(derived: Coefficients) -> dict[str, float | tuple[float, float]]:
    """Returns the derived coefficients as the parameters have them, with two digits.

    Linear drag in surge and sway is what closes a datum, and has three.
    """
    pairs = {
        name: (rounded(linear, 2 if name == "yaw" else 3), rounded(quadratic))
        for name in ("surge", "sway", "yaw")
        for linear, quadratic in [getattr(derived, name)]
    }
    ahead, across = derived.added_mass
    return {
        "added_mass": (rounded(ahead), rounded(across)),
        "added_inertia": rounded(derived.added_inertia),
        **pairs,
    }


CRAFT = {"CyberShip II": (1.255, 2.76, 1.9), "Heron": (1.35, 10.0, 6.0), "Otter": (2.0, 54.0, 54.0)}
"""Published craft: length, m, inertia with added inertia, kg m^2, linear yaw damping, N m s."""


def yaw_times(length: float) -> dict[str, float]:
    """Returns the linear yaw time constants, s, of published craft scaled by Froude to a length."""
    return {
        name: inertia / damping * math.sqrt(length / size)
        for name, (size, inertia, damping) in CRAFT.items()
    }


START, END = "<!-- coefficients -->", "<!-- end of coefficients -->"


@dataclass(frozen=True)
class Options:
    """Prints the coefficients of the nominal hulls, as derived and as the parameters have them."""

    page: FilePath | None = None  #: page whose table is replaced, such as docs/physics.md


def table() -> str:
    """Returns the derived and the rounded coefficients in Markdown."""
    lines = [
        "| | boat, derived | `BoatParams` | vessel, derived | `VesselParams` |",
        "|---|---|---|---|---|",
    ]
    hulls = boat(BoatParams()), vessel(VesselParams())
    for name, unit in UNITS.items():
        cells = []
        for derived in hulls:
            exact = np.atleast_1d(getattr(derived, name))
            used = np.atleast_1d(defaults(derived)[name])
            cells += [", ".join(f"{number:.3g}" for number in row) for row in (exact, used)]
        lines.append(f"| `{name}` ({unit}) | {' | '.join(cells)} |")
    return "\n".join(lines)


UNITS = {
    "added_mass": "kg, kg",
    "added_inertia": "kg m²",
    "surge": "kg/s, kg/m",
    "sway": "kg/s, kg/m",
    "yaw": "N m s, N m s²",
}


def derive(options: Annotated[Options, tyro.conf.arg(name="")]) -> None:
    """Print the coefficients, and what the yaw damping is compared with."""
    page = options.page
    text = None if page is None else marks.read(page)
    found, hull = table(), BoatParams()
    if page is not None and text is not None:
        Path(page).write_text(marks.replaced(text, START, END, found), encoding="utf-8")
    say(found)
    times = ", ".join(f"{name} {time:.2f} s" for name, time in yaw_times(hull.length).items())
    strips = ", ".join(f"{yaw_of_strips(hull, speed):.2g}" for speed in (0.0, 0.1, 0.2))
    say(f"Yaw time constants of craft scaled to {hull.length:g} m: {times}")
    say(f"Linear yaw damping of strips and lift at 0, 0.1 and 0.2 m/s: {strips} N m s")
    say(f"Yaw rate of turning on the spot: {turning_on_the_spot(hull):.2g} rad/s")
    say(f"Lever arm: {rounded(LEVER_ARM * hull.width):g} m")


main = command(derive, "python benchmarks/coefficients.py")

if __name__ == "__main__":
    main()
