"""The bodies in a picture: vessel and goal, boats and their slots, trails of past positions."""

from itertools import pairwise

import numpy as np

from asv_env.geometry import plane
from asv_env.polygons import crossings, inset, turned
from asv_env.render import colours
from asv_env.render.camera import Trail
from asv_env.render.canvas import Canvas
from asv_env.render.captions import at_goal
from asv_env.render.colours import WATER, WHITE, Colour, boat_colour, mix
from asv_env.render.layout import Layout, bow
from asv_env.types import Float, State

TRAIL_BANDS = 14  #: steps in which trails fade
FADING = 0.35  #: time in which a trail fades, time limits of an episode
FAINTEST = 0.35  #: share of its colour that the oldest part of a trail keeps


def paint_vessel(canvas: Canvas, layout: Layout, pose: Float) -> None:
    """Paints the vessel at a pose (>= 3,)."""
    vessel, unit, scale = layout.params.vessel, layout.unit, layout.camera.scale
    margin = min(max(0.004, 1.2 * unit / scale), layout.room / 3)
    hull = layout.pixels(layout.vessel, pose)
    _cast_shadow(canvas, layout, hull)
    canvas.fill(hull, colours.KEEL)
    canvas.fill(layout.pixels(inset(layout.vessel, margin), pose), colours.DECK)
    if vessel.width * scale > 10 * unit:
        _, _, bottom, top = vessel.extents
        for share in (1 / 3, 2 / 3):
            height = bottom + share * (top - bottom)
            for start, end in crossings(vessel.corners, height).reshape(-1, 2):
                seam = np.array([start, end]) + 0.02 * np.array([1, -1]) * (end - start)
                canvas.lines(layout.pixels(seam + 1j * height, pose), 1.1 * unit, colours.SEAM)
        _paint_fins(canvas, layout, pose)
    _paint_chevron(canvas, layout, pose, colours.KEEL)


def _paint_chevron(canvas: Canvas, layout: Layout, pose: Float, colour: Colour) -> None:
    """Paints an arrow head along the vessel's heading: amidships, or ahead of a tiny vessel."""
    size, place = 0.6 * layout.room, layout.middle
    smallest = 3.5 * layout.unit / layout.camera.scale
    if size < smallest:
        size, place = 1.4 * smallest, layout.params.vessel.extents[1] + 2.5 * smallest
        colour = mix(colour, colours.DECK, 0.8)
    arrow = size * np.array([0.9, -0.5 + 0.8j, -0.15, -0.5 - 0.8j]) + place
    canvas.fill(layout.pixels(arrow, pose), colour)


def _paint_fins(canvas: Canvas, layout: Layout, pose: Float) -> None:
    """Paints the crossed plates below both ends, as they shine through the deck."""
    vessel, breadth = layout.params.vessel, layout.params.vessel.fin_breadth
    stern, bow, _, _ = vessel.extents
    for along in (stern + 0.16 * breadth, bow - 0.16 * breadth):
        for low, high in crossings(turned(vessel.corners), -along).reshape(-1, 2):
            middle, half = along + 1j * (low + high) / 2, 0.42 * min(high - low, breadth)
            for plate in (1j * half, complex(0.1 * breadth)):
                ends = layout.pixels(middle + np.array([-plate, plate]), pose)
                canvas.lines(ends, 0.06 * breadth * layout.camera.scale, colours.FIN)


def _cast_shadow(canvas: Canvas, layout: Layout, hull: Float) -> None:
    """Paints the shadow of a hull (n, 2) px."""
    depth = min(2.4 * layout.unit, 0.2 * layout.params.boat.width * layout.camera.scale)
    canvas.fill(hull + np.array([1.0, 1.5]) * depth, colours.SHADOW)


def paint_goal(canvas: Canvas, layout: Layout, goal: Float) -> None:
    """Paints a pale vessel at the goal (3,)."""
    canvas.fill(layout.pixels(layout.vessel, goal), mix(WATER, WHITE, 0.17))
    _paint_chevron(canvas, layout, goal, mix(WATER, WHITE, 0.6))


def outline_goal(canvas: Canvas, layout: Layout, state: State) -> None:
    """Paints dashes round the goal, green once the vessel has come there."""
    colour = colours.GOOD if at_goal(layout.params, state) else WHITE
    unit, scale = layout.unit, layout.camera.scale
    width = min(max(2.4 * unit, 1.4), layout.room * scale / 2)
    for start, end in zip(layout.vessel, np.roll(layout.vessel, -1), strict=True):
        dashes = 2 * round(abs(end - start) / (9 * unit / scale) / 2) + 1
        ends = layout.pixels(np.linspace(start, end, dashes + 1), state.goal)
        for k in range(0, dashes, 2):
            canvas.lines(ends[k : k + 2], 1.7 * width, colours.EDGE)
            canvas.lines(ends[k : k + 2], width, colour)


def paint_boats(canvas: Canvas, layout: Layout, state: State) -> None:
    """Paints the boats of one world; those that failed are grey and crossed out."""
    poses, shape = state.motion[1:], layout.boat
    size = state.boat_size[:, None]
    margin = max(0.0035, 1.1 * layout.unit / layout.camera.scale)
    inner = inset(shape, margin) if layout.detailed else shape
    outlines, hulls = layout.pixels(size * shape, poses), layout.pixels(size * inner, poses)
    front = bow(inner, 1.3 * layout.enlarged * layout.params.boat.bow)
    bows = layout.pixels(size * front, poses)
    for hull in outlines:
        _cast_shadow(canvas, layout, hull)
    for boat, works in enumerate(state.working):
        _paint_wash(canvas, layout, state.thrust[boat], poses[boat])
        if layout.detailed:
            canvas.fill(outlines[boat], colours.EDGE)
        canvas.fill(hulls[boat], boat_colour(boat) if works else colours.FAILED)
        canvas.fill(bows[boat], WHITE if works else mix(colours.FAILED, WHITE, 0.5))
        if not works:
            _paint_cross(canvas, layout, poses[boat])


def _paint_wash(canvas: Canvas, layout: Layout, thrust: Float, pose: Float) -> None:
    """Paints white water astern of the motors that push; ``thrust`` (2,) N."""
    boat = layout.params.boat
    for share, y in zip(thrust / boat.thrust, (boat.lever_arm, -boat.lever_arm), strict=True):
        if share > 0.05:
            mouth = 0.1 * boat.length + 0.1j * boat.width
            jet = np.array([mouth, -0.6 * share * boat.length, mouth.conjugate()])
            jet = layout.enlarged * (jet + 1j * y) + layout.boat.real.min()
            canvas.fill(layout.pixels(jet, pose), mix(WATER, WHITE, 0.5))


def _paint_cross(canvas: Canvas, layout: Layout, pose: Float) -> None:
    """Paints the cross on a boat that has failed."""
    reach = 0.3 * layout.enlarged * layout.params.boat.width
    middle = layout.boat.real.min() + 0.42 * np.ptp(layout.boat.real)
    for diagonal in (1 + 1j, 1 - 1j):
        ends = layout.pixels(middle + reach * np.array([-diagonal, diagonal]), pose)
        canvas.lines(ends, 0.4 * reach * layout.camera.scale, colours.MARK)


def paint_slots(canvas: Canvas, layout: Layout, state: State) -> None:
    """Paints crosses in the boats' colours at the slots of the working boats."""
    scale, unit = layout.camera.scale, layout.unit
    reach = min(max(0.012 * scale, 4.5 * unit), 0.3 * layout.params.pitch * scale)
    centres = layout.pixels(state.slot, state.motion[0])
    for boat in np.flatnonzero(state.working).tolist():
        for diagonal in ((reach, reach), (reach, -reach)):
            ends = centres[boat] + np.array([[-1], [1]]) * diagonal
            canvas.lines(ends, min(2.2 * unit, 0.6 * reach), boat_colour(boat))


def paint_trails(canvas: Canvas, layout: Layout, state: State, trail: Trail) -> None:
    """Paints the past positions of all bodies, fading with age."""
    points = np.stack([*trail.points, plane(state.motion)])
    ages = state.tick - np.array([*trail.ticks, state.tick])
    fresh = np.maximum(FAINTEST, 1.0 - ages / (FADING * layout.params.time_limit_ticks))
    band = np.minimum((fresh * TRAIL_BANDS).astype(int), TRAIL_BANDS - 1)
    edges = np.unique([0, *(np.flatnonzero(np.diff(band)) + 1), len(points) - 1])
    pixels = layout.camera.pixels(points.T)
    for start, end in pairwise(edges):
        share = 0.8 * (band[start] + 1) / TRAIL_BANDS
        for body, line in enumerate(pixels[:, start : end + 1]):
            width, colour = (3.6, colours.DECK) if body == 0 else (2.7, boat_colour(body - 1))
            canvas.lines(line, width * layout.unit, mix(WATER, colour, share))
