"""What a picture adds to the hulls: the goal, the boats' slots, trails of past positions."""

from itertools import pairwise

import numpy as np

from asv_env.geometry import plane
from asv_env.render.camera import Trail
from asv_env.render.canvas import Canvas
from asv_env.render.captions import at_goal
from asv_env.render.colours import DECK, EDGE, GOOD, WATER, WHITE, boat_colour, mix
from asv_env.render.hulls import paint_chevron
from asv_env.render.layout import Layout
from asv_env.types import Float, State

TRAIL_BANDS = 14
"""Steps in which trails fade."""
FADING = 0.35
"""Time in which a trail fades, time limits of an episode."""
FAINTEST = 0.35
"""Share of its colour that the oldest part of a trail keeps."""


def paint_goal(canvas: Canvas, layout: Layout, goal: Float) -> None:
    """Paints a pale vessel at the goal (3,)."""
    canvas.fill(layout.pixels(layout.vessel, goal), mix(WATER, WHITE, 0.17))
    paint_chevron(canvas, layout, goal, mix(WATER, WHITE, 0.6))


def outline_goal(canvas: Canvas, layout: Layout, state: State) -> None:
    """Paints dashes round the goal, green once the vessel has come there."""
    colour = GOOD if at_goal(layout.params, state) else WHITE
    scale, beam = layout.camera.scale, layout.params.vessel.width
    dash = 9 * layout.unit / scale
    width = min(max(2.4 * layout.unit, 1.4), beam * scale / 4)
    for start, end in zip(layout.vessel, np.roll(layout.vessel, -1), strict=True):
        dashes = 2 * round(abs(end - start) / dash / 2) + 1
        ends = layout.pixels(np.linspace(start, end, dashes + 1), state.goal)
        for k in range(0, dashes, 2):
            canvas.lines(ends[k : k + 2], 1.7 * width, EDGE)
            canvas.lines(ends[k : k + 2], width, colour)


def paint_slots(canvas: Canvas, layout: Layout, state: State) -> None:
    """Paints crosses in the boats' colours at the slots of the working boats."""
    scale, unit = layout.camera.scale, layout.unit
    reach = min(max(0.012 * scale, 4.5 * unit), 0.3 * layout.params.pitch * scale)
    centres = layout.pixels(state.slot, state.motion[0])
    for boat in np.flatnonzero(state.working).tolist():
        for diagonal in ((reach, reach), (reach, -reach)):
            ends = np.stack([centres[boat] - diagonal, centres[boat] + diagonal])
            canvas.lines(ends, min(2.2 * unit, 0.6 * reach), boat_colour(boat))


def paint_trails(canvas: Canvas, layout: Layout, state: State, trail: Trail) -> None:
    """Paints the past positions of all bodies, fading with age."""
    points = np.concatenate([trail.points, plane(state.motion)[None]])
    ages = np.append(state.tick - trail.ticks, 0)
    fresh = np.maximum(FAINTEST, 1.0 - ages / (FADING * layout.params.time_limit_ticks))
    band = np.minimum((fresh * TRAIL_BANDS).astype(int), TRAIL_BANDS - 1)
    edges = np.unique([0, *(np.flatnonzero(np.diff(band)) + 1), len(points) - 1])
    pixels = layout.camera.pixels(points.T)
    for start, end in pairwise(edges):
        share = 0.8 * (band[start] + 1) / TRAIL_BANDS
        for body, line in enumerate(pixels):
            width, colour = (3.6, DECK) if body == 0 else (2.7, boat_colour(body - 1))
            part = line[start : end + 1]
            canvas.lines(part, width * layout.unit, mix(WATER, colour, share))
