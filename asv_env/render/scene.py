"""What a picture of the world is made of: water, goal, trails, slots, hulls, captions.

Everything is given to a ``Canvas`` as polygons, lines and text in pixels of the frame; widths
are meant for a frame of ``DESIGN`` pixels and scale with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np

from asv_env.geometry import plane, wrap
from asv_env.params import EnvParams, HullParams, WaterParams
from asv_env.physics import water
from asv_env.render.camera import Camera, Trail
from asv_env.types import Complex, Float, State

Colour = tuple[int, int, int]

DESIGN = 800.0
WATER_TOP, WATER_BOTTOM = (25, 92, 122), (13, 60, 92)
WATER, GRID, SHADOW, FLOW = (19, 76, 107), (32, 89, 119), (9, 44, 68), (126, 186, 205)
LAND, QUAY = (40, 52, 60), (150, 162, 168)
HEADER, INK, DIM, GOOD = (9, 34, 52), (240, 246, 248), (165, 196, 210), (130, 240, 170)
DECK, SEAM, FIN, KEEL = (240, 229, 205), (217, 202, 170), (122, 96, 62), (70, 54, 36)
WHITE, EDGE = (252, 252, 250), (8, 30, 46)
FAILED, MARK = (128, 136, 142), (20, 24, 28)
# Okabe and Ito's colours, told apart by colour-blind readers too, as far as they show on blue.
TEAM = (
    (240, 160, 20),
    (105, 195, 245),
    (240, 228, 66),
    (224, 130, 185),
    (40, 190, 140),
    (235, 105, 50),
)

TRAIL_BANDS = 14
"""Steps in which trails fade."""
FADING, FAINTEST = 0.35, 0.35
"""Time in which they do, time limits, and the share of colour that remains."""
FLOW_SPACING, FLOW_LENGTH = 56.0, 44.0
"""Between lines of flow, and their length where the water is fastest, px."""
ROOMY = 440
"""Width from which on all captions have room, px."""
SMALLEST_BOAT = 9.0
"""Length below which boats are drawn enlarged, px."""


class Canvas(Protocol):
    """Where a scene is painted. Points are (n, 2) pixels of the frame, widths px."""

    def fill(self, points: Float, colour: Colour) -> None:
        """A polygon."""

    def lines(self, points: Float, width: float, colour: Colour) -> None:
        """A line through points."""

    def write(self, text: str, where: tuple[float, float], anchor: str, colour: Colour) -> float:
        """A line of text at its "midleft", "center" or "midright"; its width, px."""


def mix(one: Colour, other: Colour, share: float) -> Colour:
    """A colour between two: ``share`` of the other."""
    r, g, b = (round(a + (z - a) * share) for a, z in zip(one, other, strict=True))
    return r, g, b


def boat_colour(boat: int) -> Colour:
    """The colour of a boat by its number."""
    return TEAM[boat % len(TEAM)]


def placed(shape: Complex | Float, pose: Float) -> Complex:
    """Points (..., n) in the world of points (n,) of bodies with poses (..., >= 3)."""
    turn = np.exp(1j * pose[..., 2])
    return (pose[..., 0] + 1j * pose[..., 1])[..., None] + shape * turn[..., None]


def outline(hull: HullParams, pose: Float) -> Float:
    """Corners (..., n, 2) of hulls at poses (..., 3), m."""
    points = placed(np.array(hull.outline) @ np.array([1, 1j]), pose)
    return np.stack([points.real, points.imag], axis=-1)


def round_number(limit: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is at most ``limit`` > 0."""
    decade = 10.0 ** math.floor(math.log10(limit) + 1e-9)
    return next(k * decade for k in (5.0, 2.0, 1.0) if k * decade <= limit * (1 + 1e-9))


class Scene:
    """One world as a camera sees it.

    The methods take one world of a ``State``: its arrays without the axis ``W``.

    Args:
        params: of the simulation.
        camera: where in the frame the world is.
        size: (width, height) of the frame, px.
        band: height of the bands for captions above and below the water, px.
    """

    def __init__(
        self, params: EnvParams, camera: Camera, size: tuple[int, int], band: float
    ) -> None:
        self._params = params
        self._camera = camera
        self._size = size
        self._band = band
        self._unit = min(size) / DESIGN
        self._bar = round_number(min(size) / 4.5 / camera.scale)
        self._vessel = _vertices(params.vessel.outline)
        drawn = params.boat.length * camera.scale
        self._enlarged = max(1.0, SMALLEST_BOAT * self._unit / drawn)
        # Grown backwards from the bow, so that the bow of a boat that pushes stays outside.
        shift = (self._enlarged - 1) * params.boat.length / 2
        self._boat = self._enlarged * _vertices(params.boat.outline) - shift
        self._fine_hulls = drawn > 1.6 * SMALLEST_BOAT * self._unit

    def paint_still(self, canvas: Canvas) -> None:
        """What does not move: a grid, the flow, walls, the legend."""
        self._paint_grid(canvas)
        if self._flows:
            spacing, length = FLOW_SPACING * self._unit, FLOW_LENGTH * self._unit
            for line in flow_lines(self._camera, self._params.water, self._size, spacing, length):
                self._paint_flow(canvas, line)
        if self._params.water.walls is not None:
            self._paint_walls(canvas, self._params.water.walls)
        self._paint_legend(canvas)

    def paint(self, canvas: Canvas, state: State, trail: Trail) -> None:
        """What moves, and the captions."""
        if has_goal(self._params):
            self._paint_goal(canvas, state.goal)
        self._paint_trails(canvas, trail, state)
        self._paint_vessel(canvas, state.motion[0])
        if has_goal(self._params):
            self._outline_goal(canvas, state)
        self._paint_slots(canvas, state)
        self._paint_boats(canvas, state)
        self._paint_header(canvas, state)

    def _seen(self, shape: Complex | Float, pose: Float) -> Float:
        """Pixels (..., n, 2) of a shape (n,) of bodies with poses (..., >= 3)."""
        return self._camera.pixels(placed(shape, pose))

    @property
    def _flows(self) -> bool:
        return self._params.water.current != "still" and self._params.water.current_speed > 0

    # ------------------------------------------------------------------ water

    def _paint_grid(self, canvas: Canvas) -> None:
        width, height = self._size
        low, high = self._camera.points(np.array([[0.0, height], [width, 0.0]]))
        for x in np.arange(np.ceil(low.real / self._bar), high.real / self._bar) * self._bar:
            ends = np.array([x + 1j * low.imag, x + 1j * high.imag])
            canvas.lines(self._camera.pixels(ends), 0.8 * self._unit, GRID)
        for y in np.arange(np.ceil(low.imag / self._bar), high.imag / self._bar) * self._bar:
            ends = np.array([low.real + 1j * y, high.real + 1j * y])
            canvas.lines(self._camera.pixels(ends), 0.8 * self._unit, GRID)

    def _paint_flow(self, canvas: Canvas, line: Float, strength: float = 1.0) -> None:
        """A line (n, 2) that brightens downstream and ends in a small head."""
        unit, steps = self._unit, len(line) - 1
        length = np.hypot(*np.diff(line, axis=0).T).sum()
        if length < 4 * unit:
            return
        for k in range(steps):
            share = strength * (0.08 + 0.4 * (k + 1) / steps)
            canvas.lines(line[k : k + 2], 1.4 * unit, mix(WATER, FLOW, share))
        ahead = line[-1] - line[-2]
        ahead = ahead / np.hypot(*ahead) * min(5.5 * unit, 0.45 * length)
        across = 0.55 * np.array([-ahead[1], ahead[0]])
        head = np.stack([line[-1] + ahead, line[-1] - across, line[-1] + across])
        canvas.fill(head, mix(WATER, FLOW, 0.6 * strength))

    def _paint_walls(self, canvas: Canvas, walls: float) -> None:
        """Land beyond the basin, and a quay round it."""
        basin = np.array([-1 - 1j, 1 - 1j, 1 + 1j, -1 + 1j]) * walls
        quay = basin * (1 + 4 * self._unit / self._camera.scale / walls)
        beyond = basin * 100
        for k in range(4):
            for inner, outer, colour in ((quay, beyond, LAND), (basin, quay, QUAY)):
                side = np.array([inner[k], inner[k - 1], outer[k - 1], outer[k]])
                canvas.fill(self._camera.pixels(side), colour)

    # ------------------------------------------------------------------ vessel and goal

    def _paint_goal(self, canvas: Canvas, goal: Float) -> None:
        canvas.fill(self._seen(self._vessel, goal), mix(WATER, WHITE, 0.17))
        self._paint_chevron(canvas, goal, mix(WATER, WHITE, 0.6))

    def _outline_goal(self, canvas: Canvas, state: State) -> None:
        """Dashes round the goal, also above a vessel that has come there."""
        colour = GOOD if there(self._params, state) else WHITE
        scale, beam = self._camera.scale, self._params.vessel.width
        pace = 9 * self._unit / scale
        width = min(max(2.4 * self._unit, 1.4), beam * scale / 4)
        for start, end in zip(self._vessel, np.roll(self._vessel, -1), strict=True):
            dashes = 2 * round(abs(end - start) / pace / 2) + 1
            ends = self._seen(np.linspace(start, end, dashes + 1), state.goal)
            for k in range(0, dashes, 2):
                canvas.lines(ends[k : k + 2], 1.7 * width, EDGE)
                canvas.lines(ends[k : k + 2], width, colour)

    def _paint_chevron(self, canvas: Canvas, pose: Float, colour: Colour) -> None:
        """An arrow head along a vessel's heading: amidships, or ahead of it if it is tiny."""
        size, ahead = 0.3 * self._params.vessel.width, 0.0
        smallest = 3.5 * self._unit / self._camera.scale
        if size < smallest:
            size, ahead = 1.4 * smallest, self._params.vessel.length / 2 + 2.5 * smallest
            colour = mix(colour, DECK, 0.8)
        arrow = size * np.array([0.9, -0.5 + 0.8j, -0.15, -0.5 - 0.8j]) + ahead
        canvas.fill(self._seen(arrow, pose), colour)

    def _paint_vessel(self, canvas: Canvas, pose: Float) -> None:
        vessel, unit = self._params.vessel, self._unit
        margin = min(max(0.004, 1.2 * unit / self._camera.scale), vessel.width / 6)
        self._cast_shadow(canvas, self._seen(self._vessel, pose))
        canvas.fill(self._seen(self._vessel, pose), KEEL)
        canvas.fill(self._seen(_inset(self._vessel, margin), pose), DECK)
        if vessel.width * self._camera.scale > 10 * unit:
            for across in (-1 / 6, 1 / 6):
                reach = np.array([-0.48, 0.48]) * vessel.length
                seam = reach + across * vessel.width * np.array([1j, 1j])
                canvas.lines(self._seen(seam, pose), 1.1 * unit, SEAM)
            self._paint_fins(canvas, pose)
        self._paint_chevron(canvas, pose, KEEL)

    def _paint_fins(self, canvas: Canvas, pose: Float) -> None:
        """The crossed plates below both ends, as they shine through the deck."""
        length, width = self._params.vessel.length, self._params.vessel.width
        for end in (-1, 1):
            root = end * (length / 2 - 0.16 * width)
            for plate in (0.42j, 0.1 + 0j):
                ends = self._seen(root + np.array([-plate, plate]) * width, pose)
                canvas.lines(ends, 0.06 * width * self._camera.scale, FIN)

    def _cast_shadow(self, canvas: Canvas, hull: Float) -> None:
        """Below a hull (n, 2) px."""
        depth = min(2.4 * self._unit, 0.2 * self._params.boat.width * self._camera.scale)
        canvas.fill(hull + np.array([1.0, 1.5]) * depth, SHADOW)

    # ------------------------------------------------------------------ boats

    def _paint_trails(self, canvas: Canvas, trail: Trail, state: State) -> None:
        points = np.concatenate([trail.points, plane(state.motion)[None]])
        ages = np.append(state.tick - trail.ticks, 0)
        fresh = np.maximum(FAINTEST, 1.0 - ages / (FADING * self._params.time_limit_ticks))
        band = np.minimum((fresh * TRAIL_BANDS).astype(int), TRAIL_BANDS - 1)
        edges = np.unique([0, *(np.flatnonzero(np.diff(band)) + 1), len(points) - 1])
        pixels = self._camera.pixels(points.T)
        for start, end in pairwise(edges):
            share = 0.8 * (band[start] + 1) / TRAIL_BANDS
            for body, line in enumerate(pixels):
                width, colour = (3.6, DECK) if body == 0 else (2.7, boat_colour(body - 1))
                part = line[start : end + 1]
                canvas.lines(part, width * self._unit, mix(WATER, colour, share))

    def _paint_slots(self, canvas: Canvas, state: State) -> None:
        """Crosses in the boats' colours where the working boats belong."""
        scale, unit = self._camera.scale, self._unit
        arm = min(max(0.012 * scale, 4.5 * unit), 0.3 * self._params.pitch * scale)
        centres = self._seen(state.slot, state.motion[0])
        for boat in np.flatnonzero(state.working).tolist():
            for way in ((arm, arm), (arm, -arm)):
                ends = np.stack([centres[boat] - way, centres[boat] + way])
                canvas.lines(ends, min(2.2 * unit, 0.6 * arm), boat_colour(boat))

    def _paint_boats(self, canvas: Canvas, state: State) -> None:
        poses = state.motion[1:]
        margin = max(0.0035, 1.1 * self._unit / self._camera.scale) if self._fine_hulls else 0.0
        inner = _inset(self._boat, margin) if self._fine_hulls else self._boat
        outlines, hulls = self._seen(self._boat, poses), self._seen(inner, poses)
        bows = self._seen(_bow(inner, 1.3 * self._enlarged * self._params.boat.bow), poses)
        for hull in outlines:
            self._cast_shadow(canvas, hull)
        for boat, works in enumerate(state.working):
            self._paint_wash(canvas, state.thrust[boat], poses[boat])
            if self._fine_hulls:
                canvas.fill(outlines[boat], EDGE)
            canvas.fill(hulls[boat], boat_colour(boat) if works else FAILED)
            canvas.fill(bows[boat], WHITE if works else mix(FAILED, WHITE, 0.5))
            if not works:
                self._paint_mark(canvas, poses[boat])

    def _paint_wash(self, canvas: Canvas, thrust: Float, pose: Float) -> None:
        """White water astern of the motors (2,) that push, N."""
        boat = self._params.boat
        for share, y in zip(thrust / boat.thrust, (boat.lever_arm, -boat.lever_arm), strict=True):
            if share > 0.05:
                mouth = 0.1 * boat.length + 0.1j * boat.width
                jet = np.array([mouth, -0.6 * share * boat.length, mouth.conjugate()])
                jet = self._enlarged * (jet + 1j * y) + self._boat.real.min()
                canvas.fill(self._seen(jet, pose), mix(WATER, WHITE, 0.5))

    def _paint_mark(self, canvas: Canvas, pose: Float) -> None:
        """The cross on a boat that has failed."""
        arm = 0.3 * self._enlarged * self._params.boat.width
        middle = self._boat.real.min() + 0.42 * np.ptp(self._boat.real)
        for way in (1 + 1j, 1 - 1j):
            ends = self._seen(middle + arm * np.array([-way, way]), pose)
            canvas.lines(ends, 0.4 * arm * self._camera.scale, MARK)

    # ------------------------------------------------------------------ captions

    def _paint_legend(self, canvas: Canvas) -> None:
        """Bands for captions; a scale bar, and the speed of the current if there is one."""
        unit, (width, height) = self._unit, self._size
        for top, bottom in ((-2.0, self._band), (height - self._band, height + 2.0)):
            corners = [(-2.0, top), (width + 2.0, top), (width + 2.0, bottom), (-2.0, bottom)]
            canvas.fill(np.array(corners), HEADER)
        left, right, row = 14 * unit, width - 14 * unit, height - self._band / 2
        end = left + self._bar * self._camera.scale
        canvas.lines(np.array([(left, row), (end, row)]), 2 * unit, INK)
        for x in (left, end):
            canvas.lines(np.array([(x, row - 5 * unit), (x, row + 5 * unit)]), 2 * unit, INK)
        text = f"{self._bar:g} m"
        if self._enlarged > 1:
            text += f"    boats drawn {self._enlarged:.1f} times larger"
        canvas.write(text, (end + 10 * unit, row), "midleft", INK)
        if self._flows:
            speed = self._params.water.current_speed
            shown = round_number(speed)
            text = f"current {100 * shown:g} cm/s"
            right -= canvas.write(text, (right, row), "midright", INK) + 18 * unit
            columns = right + np.linspace(-FLOW_LENGTH * unit * shown / speed, 0, 11)
            self._paint_flow(canvas, np.stack([columns, np.full(11, row)], axis=-1), 1.6)

    def _paint_header(self, canvas: Canvas, state: State) -> None:
        """How the episode stands."""
        params, width = self._params, self._size[0]
        pad, row = 14 * self._unit, self._band / 2
        colour = GOOD if there(params, state) else DIM
        seconds = state.tick / params.clock.control
        canvas.write(f"{seconds:.1f} s", (width - pad, row), "midright", INK)
        if width < ROOMY:
            canvas.write(errors(params, state), (pad, row), "midleft", colour)
        else:
            canvas.write(phase(params, state), (pad, row), "midleft", INK)
            canvas.write(errors(params, state), (0.56 * width, row), "center", colour)


def has_goal(params: EnvParams) -> bool:
    """Whether the task has a goal pose."""
    return params.task.name != "approach"


def phase(params: EnvParams, state: State) -> str:
    """What the boats of one world are doing."""
    team, working = params.num_boats, int(state.working.sum())
    boats = f"{team} boats" if working == team else f"{working} of {team} boats"
    if state.closed:
        return f"{boats} {'pushing' if has_goal(params) else 'holding'}"
    return f"{boats}, grasp lost" if params.task.name == "push" else f"{boats} approaching"


def there(params: EnvParams, state: State) -> bool:
    """Whether the vessel of one world is at its goal, within the tolerances of pose."""
    task, (distance, turn) = params.task, _goal_errors(state)
    near = distance <= task.position_tolerance and abs(turn) <= task.heading_tolerance
    return near and has_goal(params)


def errors(params: EnvParams, state: State) -> str:
    """How far one world is from success."""
    if not has_goal(params):
        away = np.abs(plane(state.motion)[1:] - placed(state.slot, state.motion[0]))
        return f"farthest boat {_distance(away[state.working].max())} from its slot"
    distance, turn = _goal_errors(state)
    return f"position error {_distance(distance)}    heading error {turn:+.2f} rad"


def _goal_errors(state: State) -> tuple[float, float]:
    """Distance m and signed turn rad of the vessel of one world from its goal."""
    error = state.motion[0, :3] - state.goal
    return float(np.hypot(error[0], error[1])), float(wrap(error[2]))


def _distance(metres: float) -> str:
    return f"{100 * metres:.1f} cm" if metres < 10 else f"{metres:.2f} m"


def flow_lines(
    camera: Camera,
    params: WaterParams,
    size: tuple[int, int],
    spacing: float,
    length: float,
    steps: int = 10,
) -> Float:
    """Short stretches of streamlines all over a frame, as long as the water is fast.

    Args:
        camera: of the frame.
        params: with a current.
        size: (width, height) of the frame, px.
        spacing: between the middles of neighbouring lines, px.
        length: of a line where the water flows at ``current_speed``, px.
        steps: of the integration.

    Returns:
        (n, steps + 1, 2) pixels, downstream.
    """
    rows = np.arange(0.0, size[1] + spacing, spacing * math.sqrt(0.75))
    columns = np.arange(0.0, size[0] + spacing, spacing)
    grid = np.empty((len(rows), len(columns), 2))
    grid[..., 0] = columns + np.where(np.arange(len(rows)) % 2, spacing / 2, 0.0)[:, None]
    grid[..., 1] = rows[:, None]
    dt = length / camera.scale / params.current_speed / steps
    line = [_drifted(params, camera.points(grid.reshape(-1, 2)), -dt * steps / 2)]
    for _ in range(steps):
        line.append(_drifted(params, line[-1], dt))
    return camera.pixels(np.stack(line, axis=-1))


def _drifted(params: WaterParams, points: Complex, time: float) -> Complex:
    """Where water at these points is after a time in s, by the midpoint rule."""
    half = points + time / 2 * water.current(params, points)
    return points + time * water.current(params, half)


def _vertices(outline: Sequence[tuple[float, float]]) -> Complex:
    corners = np.array(outline)
    return corners[:, 0] + 1j * corners[:, 1]


def _inset(outline: Complex, margin: float) -> Complex:
    """A hull about ``margin`` m smaller on all sides."""
    middle = (outline.real.max() + outline.real.min()) / 2
    x, y = np.ptp(outline.real) / 2, np.ptp(outline.imag) / 2
    along = middle + (outline.real - middle) * (1 - margin / x)
    inset: Complex = along + 1j * outline.imag * (1 - margin / y)
    return inset


def _bow(outline: Complex, taper: float) -> Complex:
    """The front ``taper`` m of a hull ordered as ``geometry.boat_hull`` does."""
    shoulder, tip = outline[4], outline[3]
    corners = np.array([tip.real - taper + 1j * shoulder.imag, shoulder, tip])
    return np.concatenate([corners, corners[::-1].conj()])
