"""What does not move in a picture: grid, streamlines of the current, walls, obstacles."""

import math

import numpy as np

from asv_env.capsules import POLYGON
from asv_env.params import WaterParams
from asv_env.params.obstacle_params import grouping
from asv_env.physics import water
from asv_env.render.canvas import Canvas
from asv_env.render.colours import (
    FLOW,
    GRID,
    LAND,
    QUAY,
    SHADOW,
    STONE,
    STONE_EDGE,
    WATER,
    mix,
)
from asv_env.render.layout import Layout
from asv_env.types import Complex, Float

CAP = 24  #: points of the round end of an obstacle
FLOW_SPACING = 56.0  #: distance between neighbouring streamlines, px
FLOW_LENGTH = 44.0  #: length of a streamline where the water is fastest, px


def paint_backdrop(canvas: Canvas, layout: Layout) -> None:
    """Paints the grid, and streamlines and walls if there are any."""
    paint_grid(canvas, layout)
    walls, unit = layout.params.water.walls, layout.unit
    if layout.flows:
        for line in streamlines(layout, FLOW_SPACING * unit, FLOW_LENGTH * unit):
            paint_streamline(canvas, line, unit)
    if walls is not None:
        paint_walls(canvas, layout, walls)


def paint_obstacles(canvas: Canvas, layout: Layout, obstacle: Float) -> None:
    """Paints obstacles and their shadows; ``obstacle`` is (M, 5), as in ``State``."""
    groups, walls = grouping(layout.params)
    shown = range(len(groups) - 1 - walls)
    outlines = [_solid(layout, obstacle[groups[g] : groups[g + 1]]) for g in shown]
    unit = layout.unit
    for outline in outlines:
        canvas.fill(outline + np.array([1.5, 2.2]) * unit, SHADOW)
    for outline in outlines:
        canvas.lines(np.concatenate([outline, outline[:1]]), 3.2 * unit, STONE_EDGE)
    for outline in outlines:  # Obstacles that overlap are one to the eye.
        canvas.fill(outline, STONE)


def _solid(layout: Layout, rows: Float) -> Float:
    """Returns the outline (n, 2) px of an obstacle, by its rows (k, 5)."""
    if len(rows) >= POLYGON:
        return layout.camera.pixels(rows[:, 0] + 1j * rows[:, 1])
    ((ax, ay, bx, by, radius),) = rows
    start, end = complex(ax, ay), complex(bx, by)
    along = (end - start) / abs(end - start) if end != start else 1.0
    cap = radius * 1j * along * np.exp(1j * np.linspace(0.0, np.pi, CAP))
    return layout.camera.pixels(np.concatenate([start + cap, end - cap]))


def paint_grid(canvas: Canvas, layout: Layout) -> None:
    """Paints a grid whose spacing is the scale bar's length."""
    (width, height), camera, bar = layout.size, layout.camera, layout.bar
    low, high = camera.points(np.array([[0.0, height], [width, 0.0]]))
    xs = np.arange(np.ceil(low.real / bar), high.real / bar) * bar
    ys = np.arange(np.ceil(low.imag / bar), high.imag / bar) * bar
    lines = [(x + 1j * low.imag, x + 1j * high.imag) for x in xs]
    lines += [(low.real + 1j * y, high.real + 1j * y) for y in ys]
    for ends in lines:
        canvas.lines(camera.pixels(np.array(ends)), 0.8 * layout.unit, GRID)


def paint_streamline(canvas: Canvas, line: Float, unit: float, strength: float = 1.0) -> None:
    """Paints a line (n, 2) px that brightens downstream and ends in a small arrow head."""
    steps = len(line) - 1
    length = np.hypot(*np.diff(line, axis=0).T).sum()
    if length < 4 * unit:
        return
    for k in range(steps):
        share = strength * (0.08 + 0.4 * (k + 1) / steps)
        canvas.lines(line[k : k + 2], 1.4 * unit, mix(WATER, FLOW, share))
    ahead = line[-1] - line[-2]
    ahead = ahead / np.hypot(*ahead) * min(5.5 * unit, 0.45 * length)
    across = 0.55 * np.array([-ahead[1], ahead[0]])
    head = line[-1] + np.stack([ahead, -across, across])
    canvas.fill(head, mix(WATER, FLOW, 0.6 * strength))


def paint_walls(canvas: Canvas, layout: Layout, half_width: float) -> None:
    """Paints the land beyond the basin, and the quay round it."""
    camera = layout.camera
    basin = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j]) * half_width
    quay = basin * (1 + 4 * layout.unit / camera.scale / half_width)
    for k in range(4):
        for inner, outer, colour in ((quay, basin * 100, LAND), (basin, quay, QUAY)):
            side = np.array([inner[k], inner[k - 1], outer[k - 1], outer[k]])
            canvas.fill(camera.pixels(side), colour)


def streamlines(layout: Layout, spacing: float, length: float, steps: int = 10) -> Float:
    """Returns streamlines (n, steps + 1, 2) px all over a frame, as long as the water is fast.

    The middles of neighbours are ``spacing`` px apart; a line is ``length`` px long where the
    water flows at ``current_speed``, and is integrated in some steps.
    """
    camera, params, size = layout.camera, layout.params.water, layout.size
    rows = np.arange(0.0, size[1] + spacing, spacing * math.sqrt(0.75))
    columns = np.arange(0.0, size[0] + spacing, spacing)
    shift = np.where(np.arange(len(rows)) % 2, spacing / 2, 0.0)
    x, y = columns + shift[:, None], np.broadcast_to(rows[:, None], (len(rows), len(columns)))
    middles = np.stack([x, y], axis=-1).reshape(-1, 2)
    dt = length / camera.scale / params.current_speed / steps
    line = [_drifted(params, camera.points(middles), -dt * steps / 2)]
    for _ in range(steps):
        line.append(_drifted(params, line[-1], dt))
    return camera.pixels(np.stack(line, axis=-1))


def _drifted(params: WaterParams, points: Complex, time: float) -> Complex:
    """Returns where the water at these points is after ``time`` s, by the midpoint rule."""
    half = points + time / 2 * water.current(params, points)
    return points + time * water.current(params, half)
