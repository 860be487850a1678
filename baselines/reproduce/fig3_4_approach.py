"""Figs. 3 and 4: the spiral and its heading field, and the swarm of Brownian agents."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from asv_env.params import TaskParams
from asv_env.types import Float
from baselines.evaluate.report import palette
from baselines.paper import brownian
from baselines.paper import spiral as spirals
from baselines.paper.braitenberg import desired_heading, turn_direction
from baselines.reproduce import sketch, style
from baselines.reproduce.artefact import Job

SIGMAS = ((1.0, r"$\sigma = 1$"), (np.sqrt(0.5), r"$\sigma^2 = 1/2$"))
"""Sigma of the paper's experiment and of its Fig. 4, rad, and how it is written."""
SWARM = 10  #: number of agents
DURATION = 10.0  #: time over which Fig. 4 follows the swarm, s; the paper's T
DT = 0.02  #: time step of the model, s
ENSEMBLE = 1000  #: number of swarms in the ensemble with noise
NOISE_R = 0.02  #: noise of the distance in the ensemble, m / sqrt(s); the paper gives none
NOISE_ALPHA = 0.1  #: noise of the angle in the ensemble, rad / sqrt(s); the paper gives none


def radius(theta: Float, sigma: float) -> Float:
    """Returns the radius of the spiral with r_pi = 1 (Eq 4).

    Eq (5) gives r_pi for a radius, to which it is proportional.
    """
    return 1.0 / spirals.asymptotic_radius(1.0, theta, sigma)


def spiral_points(r0: float, theta0: float, sigma: float, turn: int) -> Float:
    """Returns points (n, 2) of the spiral from (r0, theta0) to the target at the origin, m."""
    theta = np.linspace(theta0, 0.0, sketch.STEPS)
    r = radius(theta, sigma) * spirals.asymptotic_radius(r0, theta0, sigma)
    alpha = np.pi / 2 - (2 * turn - 1) * theta
    return np.stack([r * np.cos(alpha), r * np.sin(alpha)], axis=-1)


def spiral(job: Job) -> Figure:
    """The spiral of Eq. (4) and the field of headings.

    (a) Radius of the spiral with r_pi = 1 over theta, the angle from the direction pi/2. (b)
    Arrows: headings of Eqs. (2) and (3), the phase of the latter corrected, round a target at the
    origin, sigma = 1; left of it D = 0 (clockwise), right of it D = 1. Lines: spirals of Eq. (4).
    """
    figure, (shape, field) = style.panels(style.PAGE, 74.0, 1, 2, width_ratios=(1.25, 1.0))
    theta = np.linspace(0.0, np.pi, sketch.STEPS)
    for (sigma, label), colour in zip(SIGMAS, palette.SERIES, strict=False):
        shape.plot(theta, radius(theta, sigma), color=colour, label=label)
    shape.set(xlabel=r"$\theta$ (rad)", ylabel=r"$r / r_\pi$", xlim=(0, np.pi), ylim=(0, 1.05))
    shape.set_xticks([0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"])
    shape.legend(loc="lower right")
    _draw_headings(field, SIGMAS[0][0])
    for theta0 in (1.0, 2.0, 3.0):
        for turn in (0, 1):
            field.plot(*spiral_points(1.0, theta0, SIGMAS[0][0], turn).T, color=palette.BLUE)
    sketch.crosses(field, (0.0, 0.0))
    sketch.plane(field, labels=False)
    field.set(xlabel="$x / r_0$", ylabel="$y / r_0$", xlim=(-1.2, 1.2), ylim=(-1.2, 1.2))
    return figure


def _draw_headings(axes: Axes, sigma: float) -> None:
    grid = np.linspace(-1.1, 1.1, 14)
    x, y = np.meshgrid(grid, grid)
    alpha = np.arctan2(y, x)
    heading = desired_heading(alpha, turn_direction(x, 0.0), spirals.bearing_offset(alpha, sigma))
    axes.quiver(
        x, y, np.cos(heading), np.sin(heading), color=palette.GREY, pivot="mid",
        scale=22.0, width=0.0035, headwidth=4.5,
    )  # fmt: skip


def swarm(job: Job) -> Figure:
    """Brownian swarm of Eq. (8), N = 10, sigma^2 = 1/2, T = 10 s; the model alone, no hulls.

    Speeds by Eq. (7) with T_goal = T. (a) Without noise: starts (open), positions after T
    (filled), paths (solid) and the spirals of Eq. (4) from the same starts (dashed). Eq. (8) as
    printed is slower than S, so that the agents are still on their way at T. (b, c) Positions of
    1000 swarms from these starts, with white noise of 2 cm and 0.1 rad per square root of a
    second on r and alpha, after T/2 and T.
    """
    figure, axes = style.panels(style.PAGE, 68.0, 1, 3, sharex=True, sharey=True)
    rng = np.random.default_rng(job.seed)
    near, far = TaskParams().start_distance
    r0, alpha0 = rng.uniform(near, far, SWARM), rng.uniform(-np.pi, np.pi, SWARM)
    sigma = float(SIGMAS[1][0])
    theta0 = spirals.angular_distance(alpha0, np.pi / 2)
    speed = spirals.approach_speed(spirals.arc_length(r0, theta0, sigma), DURATION)
    settings: dict[str, Any] = {"duration": DURATION, "dt": DT, "rng": rng}
    _, r, alpha = brownian.simulate(r0, alpha0, speed, sigma, **settings)
    _draw_swarm(axes[0], r * np.exp(1j * alpha), sigma)

    crowd = np.broadcast_to(r0, (ENSEMBLE, SWARM))
    times, r, alpha = brownian.simulate(
        crowd, alpha0, speed, sigma, noise_r=NOISE_R, noise_alpha=NOISE_ALPHA, **settings
    )
    looks: dict[str, Any] = {"norm": LogNorm(1, ENSEMBLE), "cmap": style.MAP, "rasterized": True}
    bins, starts = np.linspace(-1.6, 1.6, 81), r0 * np.exp(1j * alpha0)
    for panel, tick in zip(axes[1:], (len(times) // 2, len(times) - 1), strict=True):
        where = (r[tick] * np.exp(1j * alpha[tick])).ravel()
        *_, cells = panel.hist2d(where.real, where.imag, bins=[bins, bins], **looks)
        panel.plot(starts.real, starts.imag, "o", mfc="none", mec=palette.GREY, ms=3)
        panel.text(0.04, 0.93, f"$t$ = {times[tick]:g} s", transform=panel.transAxes)
    figure.colorbar(cells, ax=axes[2], label="agents per cell of 4 cm", shrink=0.8, pad=0.03)
    for panel in axes:
        sketch.plane(panel)
        panel.label_outer()
        sketch.crosses(panel, (0.0, 0.0))
    return figure


def _draw_swarm(axes: Axes, paths: np.ndarray, sigma: float) -> None:
    """Draws paths (T, N) of agents, as complex numbers, and the spirals from their starts."""
    for path, colour in zip(paths.T, style.boat_colours(paths.shape[1]), strict=True):
        start, end = path[0], path[-1]
        theta = float(spirals.angular_distance(np.angle(start), np.pi / 2))
        turn = int(turn_direction(start.real, 0.0))
        spiral = spiral_points(abs(start), theta, sigma, turn)
        axes.plot(*spiral.T, "--", color=palette.GREY, lw=0.6)
        axes.plot(path.real, path.imag, color=colour)
        axes.plot(start.real, start.imag, "o", mfc="white", mec=colour, ms=4)
        axes.plot(end.real, end.imag, "o", color=colour, ms=4)
    axes.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6))
