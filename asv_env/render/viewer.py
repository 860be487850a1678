"""Pictures of a world, seen from above: State -> RGB frame.

Nothing here needs a display except ``mode="human"``, and nothing changes the state.
"""

from collections.abc import Sequence

import numpy as np

from asv_env.checks import choice
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.render import MODES, bodies
from asv_env.render.backdrop import paint_backdrop, paint_obstacles
from asv_env.render.camera import Box, Camera, Trail, first_box, next_box
from asv_env.render.canvas import Canvas, pygame
from asv_env.render.captions import paint_gust, paint_header, paint_legend
from asv_env.render.colours import WATER_BOTTOM, WATER_TOP
from asv_env.render.layout import DESIGN, Layout
from asv_env.render.window import Window
from asv_env.types import Float, Frame, State, rows

SMALLEST = 240  #: smallest side of a frame, px
TRAIL_POINTS = 8000  #: points of all trails together


class Viewer:
    """Draws one world of a simulation.

    The view is fixed for an episode; it widens only if a body leaves it. Trails join the
    positions that were drawn; they start again when the tick falls or another world is drawn.

    Args:
        params: parameters of the simulation.
        mode: "rgb_array" gives frames, "human" shows them in a window at the control rate.
        size: (width, height) of the frame, px, both even.

    Raises:
        ValueError: an unknown mode, or a size that is odd or too small.
    """

    camera: Camera  #: the position of the world in the latest frame

    def __init__(
        self, params: EnvParams, mode: str = "rgb_array", size: tuple[int, int] = (800, 800)
    ) -> None:
        self.params, self.size = params, _checked_size(size)
        self.mode = choice("render mode", mode, MODES)
        text = max(12, round(21 * min(self.size) / DESIGN))
        self._band = round(1.6 * text)
        self._still, self._canvas = Canvas(self.size, text), Canvas(self.size, text)
        self._frame = pygame.Surface(self.size, 0, 32)
        self._window = Window(f"asv-env: {params.task.name}", params.clock.control)
        self._last: tuple[int, int, Float] | None = None

    @property
    def closed(self) -> bool:
        """Whether the window was closed; then ``draw`` does nothing any more."""
        return self._window.closed

    @np.errstate(all="ignore")
    def draw(self, state: State, world: int = 0) -> Frame | None:
        """Draws a world of a state, which is only read.

        Returns:
            The frame (height, width, 3), or None in human mode.

        Raises:
            RuntimeError: a window is to be opened where there is no display.
        """
        if self.mode == "human" and self.closed:
            return None
        shown = rows(state, world)
        self._follow(shown, world)
        self._paint(shown)
        pygame.transform.smoothscale(self._canvas.surface, self.size, self._frame)
        if self.mode == "human":
            self._window.show(self._frame)
            return None
        data = pygame.image.tobytes(self._frame, "RGB")
        return np.frombuffer(data, dtype=np.uint8).reshape(*self.size[::-1], 3).copy()

    def close(self) -> None:
        """Closes the window, if there is one. May be called again."""
        self._window.close()

    def _follow(self, state: State, world: int) -> None:
        """Brings trail, camera and backdrop up to date with one world of a state."""
        params = self.params
        goal = state.goal if params.definition.has_goal else None
        if self._begins(state, world):
            limit = min(1500, max(200, TRAIL_POINTS // (1 + params.num_boats)))
            self._trail = Trail(0.02 * params.vessel.size, limit)
            self._look(first_box(params, state.motion, goal, state.obstacle), state.obstacle)
        elif (box := next_box(self._box, params, state.motion, goal)) != self._box:
            self._look(box, state.obstacle)
        self._trail.record(int(state.tick), plane(state.motion))

    def _begins(self, state: State, world: int) -> bool:
        """Returns whether this is another episode than that of the frame before."""
        poses, tick = (
            np.concatenate([state.goal, state.motion.ravel(), state.obstacle.ravel()]),
            int(state.tick),
        )
        last, self._last = self._last, (world, tick, poses)
        if last is None or last[0] != world:
            return True
        return tick < last[1] or (tick == last[1] and not np.array_equal(poses, last[2]))

    def _look(self, box: Box, obstacle: Float) -> None:
        """Points the camera at a box of the world and paints what does not move.

        ``obstacle`` is (M, 5) of the world, as in ``State``.
        """
        width, height = self.size
        self._box = box
        self.camera = Camera.covering(box, 0, self._band, width, height - 2 * self._band)
        self._layout = Layout(self.params, self.camera, self.size, self._band)
        self._still.fill_gradient(WATER_TOP, WATER_BOTTOM)
        paint_backdrop(self._still, self._layout)
        paint_obstacles(self._still, self._layout, obstacle)
        paint_legend(self._still, self._layout)

    def _paint(self, state: State) -> None:
        """Paints what moves, from the water up, and the captions about it."""
        canvas, layout, has_goal = self._canvas, self._layout, self.params.definition.has_goal
        canvas.surface.blit(self._still.surface, (0, 0))
        if has_goal:
            bodies.paint_goal(canvas, layout, state.goal)
        bodies.paint_trails(canvas, layout, state, self._trail)
        bodies.paint_vessel(canvas, layout, state.motion[0])
        if has_goal:
            bodies.outline_goal(canvas, layout, state)
        bodies.paint_slots(canvas, layout, state)
        bodies.paint_boats(canvas, layout, state)
        paint_header(canvas, layout, state)
        paint_gust(canvas, layout, state)


def _checked_size(size: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError) as error:
        raise ValueError(f"size = {size!r}: give (width, height) in pixels") from error
    if min(width, height) < SMALLEST or width % 2 or height % 2:
        raise ValueError(f"size = {size!r}: both must be even and at least {SMALLEST} px")
    return width, height
