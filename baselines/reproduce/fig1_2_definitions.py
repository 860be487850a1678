"""Figs. 1 and 2: conditional closure, and the quantities that the laws use."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from asv_env.params import EnvParams
from asv_env.presets import make_params
from baselines.evaluate.report import palette
from baselines.paper import two_arc
from baselines.paper.arcs import ArcPath
from baselines.paper.braitenberg import desired_heading, turn_direction
from baselines.paper.paper_numbers import PAPER_GOAL
from baselines.paper.spiral import angular_distance, bearing_offset
from baselines.reproduce import sketch, style
from baselines.reproduce.artefact import Job
from baselines.reproduce.fig3_4_approach import spiral_points

ALPHA1 = 1.0  #: turn of the first arc in the paper, rad
SIGMA = 1.0  #: decay of the spiral in the paper's experiment, rad
EXAMPLE_BOAT = (0.72, -0.26)  #: position of the boat in Fig. 2, m
EXAMPLE_RADIUS = 0.45  #: distance of the centre of rotation of Fig. 1 from the vessel's, m


def closure(job: Job) -> Figure:
    """Conditional closure of the vessel by four boats.

    Blue crosses: slots; red: headings of the boats in them. The boats can push the vessel
    along -n only, and turn it only about centres C on its long axis that lie outside it (solid
    green; |rho| >= S_x/2), not about one within (dotted).
    """
    params = make_params("push")
    figure, (axes,) = style.panels(style.COLUMN, 55.0)
    _draw_closure(axes, params)
    _draw_centres(axes, params.vessel.length / 2)
    sketch.plane(axes)
    axes.set(xlim=(-0.6, 0.6), ylim=(-0.4, 0.32))
    return figure


def _draw_closure(axes: Axes, params: EnvParams) -> None:
    poses = sketch.slots(params, np.zeros(3))
    sketch.hull(axes, params.vessel, np.zeros(3))
    for pose in poses:
        sketch.hull(axes, params.boat, pose, fc="none", lw=0.7)
        bow = sketch.ahead(pose, params.boat.length / 2)
        sketch.arrow(axes, pose[:2], bow, color=palette.VERMILLION, mutation_scale=5.0)
    sketch.crosses(axes, poses[:, :2], palette.BLUE, 5.0)


def _draw_centres(axes: Axes, half: float) -> None:
    """Draws where centres of rotation may lie, and one of them."""
    for side in (-1, 1):
        axes.plot([side * half, side * 0.6], [0, 0], color=palette.GREEN, lw=2.0, zorder=2)
    axes.plot([-half, half], [0, 0], ":", color=palette.VERMILLION, lw=1.2, zorder=4)
    axes.plot(EXAMPLE_RADIUS, 0.0, "o", color=palette.GREEN, ms=3.5, zorder=7)
    sketch.label(axes, (EXAMPLE_RADIUS, 0.06), "C", palette.GREEN)
    arc = ArcPath(np.zeros(3), np.array([1 / EXAMPLE_RADIUS]), np.array([0.6 * EXAMPLE_RADIUS]))
    points = sketch.path_points(arc)
    axes.plot(*points.T, color=palette.GREEN, lw=0.9, zorder=4)
    sketch.arrow(axes, points[-8], points[-1], color=palette.GREEN)
    sketch.arrow(axes, (0, 0), (0, -0.2), color=palette.BLACK)
    sketch.label(axes, (-0.06, -0.2), "-n")
    for x, text in ((half, "S_x/2"), (EXAMPLE_RADIUS, r"\rho")):
        row = -0.3 if x == half else -0.36
        sketch.arrow(axes, (0, row), (x, row), arrowstyle="<|-|>", lw=0.6, mutation_scale=5.0)
        sketch.label(axes, (-0.06, row), text)
        axes.plot([x, x], [row, 0], color=palette.GREY, lw=0.4, zorder=1)


def quantities(job: Job) -> Figure:
    """Quantities of the approach and of the push.

    (a) Approach with T = O, sigma = 1: the boat is at the angle alpha as seen from the target T,
    theta away from the direction pi/2 in which it will stand off; the law of Eq. (3) (with its
    phase corrected) turns it to the heading h, at the angle phi of Eq. (2) from the direction to
    the target. Dashed: the spiral of Eq. (4). (b) Push to the paper's goal {0.55 m, -0.95 m,
    0.1 rad} with alpha_1 = 1: centres C_1 and C_2, signed radii rho_1 and rho_2, switching point.
    """
    figure, (approach, push) = style.panels(style.PAGE, 86.0, 1, 2, width_ratios=(1.2, 1.0))
    params = make_params("push")
    _draw_approach(approach, params)
    _draw_push(push, params)
    sketch.plane(approach)
    sketch.plane(push)
    return figure


def _draw_approach(axes: Axes, params: EnvParams) -> None:
    x, y = EXAMPLE_BOAT
    radius, alpha = float(np.hypot(x, y)), float(np.arctan2(y, x))
    theta, phi = float(angular_distance(alpha, np.pi / 2)), float(bearing_offset(alpha, SIGMA))
    turn = int(turn_direction(x, 0.0))
    heading = float(desired_heading(alpha, turn, phi))
    pose = np.array([x, y, heading])

    sketch.hull(axes, params.vessel, np.zeros(3), zorder=1)
    axes.plot(*spiral_points(radius, theta, SIGMA, turn).T, "--", color=palette.GREY)
    axes.plot([0, x], [0, y], color=palette.BLACK, lw=0.7)
    for ends in ([0, 0.45], [0, 0]), ([0, 0], [0, 0.45]), ([x, x + 0.22], [y, y]):
        axes.plot(*ends, color=palette.GREY, lw=0.5)
    sketch.hull(axes, params.boat, pose, fc=palette.SKY)
    sketch.arrow(axes, pose[:2], sketch.ahead(pose, 0.3), color=palette.VERMILLION)
    sketch.crosses(axes, (0, 0), palette.BLUE, 6.0)
    sketch.label(axes, (-0.05, -0.05), "T", palette.BLUE)
    sketch.angle(axes, (0, 0), 0.0, alpha, 0.33, r"\alpha")
    sketch.angle(axes, (0, 0), np.pi / 2, -theta, 0.25, r"\theta", palette.GREEN)
    sketch.angle(axes, pose[:2], 0.0, heading, 0.13, "h", palette.VERMILLION)
    sketch.angle(axes, pose[:2], alpha + np.pi, heading - alpha - np.pi, 0.2, r"\phi")
    sketch.label(axes, (x + 0.03, y - 0.12), "(x, y)")
    axes.set(xlim=(-0.28, 1.05), ylim=(-0.5, 0.62))


def _draw_push(axes: Axes, params: EnvParams) -> None:
    path = two_arc.plan(np.array(PAPER_GOAL), ALPHA1)
    joints, centres = path.joints, path.centres
    sketch.hull(axes, params.vessel, joints[0])
    sketch.hull(axes, params.vessel, joints[1], fc="none", ec=palette.GREY, lw=0.6)
    sketch.goal(axes, params, joints[2])
    axes.plot(*sketch.path_points(path).T, color=palette.BLUE, lw=1.4, zorder=6)
    sketch.crosses(axes, np.concatenate([centres, joints[1:2, :2]]))
    for k, colour in enumerate((palette.GREEN, palette.PURPLE)):
        radii = np.stack([joints[k, :2], centres[k], joints[k + 1, :2]])
        axes.plot(*radii.T, color=colour, lw=0.7)
        first = radii[0] - radii[1]
        start = float(np.arctan2(first[1], first[0]))
        sketch.angle(axes, centres[k], start, float(path.turn[k]), 0.15, rf"\alpha_{k + 1}", colour)
        outwards = (0.08 * np.sign(path.curvature[k]), 0.0)
        sketch.label(axes, centres[k] + outwards, f"C_{k + 1}", colour)
        normal = np.array([-first[1], first[0]]) * np.sign(path.turn[k]) / np.hypot(*first)
        sketch.label(axes, radii[:2].mean(axis=0) - 0.06 * normal, rf"\rho_{k + 1}", colour)
    sketch.label(axes, joints[1, :2] + (0.29, 0.06), "(x_1, y_1)")
    axes.set(xlim=(-0.35, 0.95), ylim=(-1.2, 0.25))
