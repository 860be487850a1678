"""Pictures of a world, seen from above: State -> RGB frame. The only file that imports pygame.

Nothing here needs a display except ``mode="human"``, and nothing changes the state.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from asv_env.checks import choice
from asv_env.geometry import plane
from asv_env.params import EnvParams
from asv_env.render.camera import Camera, Trail, first_box, next_box
from asv_env.render.scene import DESIGN, WATER_BOTTOM, WATER_TOP, Colour, Scene, has_goal, mix
from asv_env.types import Float, State, rows

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame
except ImportError as error:
    raise ImportError('rendering needs pygame-ce: pip install "asv-env[eval]"') from error

Frame = NDArray[np.uint8]

MODES = ("rgb_array", "human")
SMALLEST = 240
"""Smallest side of a frame, px."""
TRAIL_POINTS = 8000
"""Points of all trails together."""


class Viewer:
    """Draws one world of a simulation.

    The view is fixed for an episode; it widens only if a body leaves it. Trails are made of
    what was drawn; they start afresh when the tick falls or another world is drawn.

    Args:
        params: of the simulation.
        mode: "rgb_array" gives frames, "human" shows them in a window at the control rate.
        size: (width, height) of the frame, px, both even.

    Attributes:
        params, mode, size: as given.
        camera: where in the frame the world is; of the latest frame.
        closed: whether ``close`` was called, or the user closed the window. A closed window
            stays closed and ``draw`` does nothing any more.

    Raises:
        ValueError: an unknown mode, or a size that is odd or too small.
    """

    camera: Camera

    def __init__(
        self, params: EnvParams, mode: str = "rgb_array", size: tuple[int, int] = (800, 800)
    ) -> None:
        self.params = params
        self.mode = choice("render mode", mode, MODES)
        self.size = _checked_size(size)
        self.closed = False
        text = max(12, round(21 * min(self.size) / DESIGN))
        self._band = round(1.6 * text)
        self._water = _Sheet(self.size, text)
        self._water.fill_gradient(WATER_TOP, WATER_BOTTOM)
        self._still, self._sheet = _Sheet(self.size, text), _Sheet(self.size, text)
        self._frame = pygame.Surface(self.size, 0, 32)
        self._window: pygame.Surface | None = None
        self._last: tuple[int, int, Float] | None = None

    def draw(self, state: State, world: int = 0) -> Frame | None:
        """Draws one world.

        Args:
            state: of the simulation; only read.
            world: which of its worlds.

        Returns:
            The frame (height, width, 3), or None in human mode.

        Raises:
            RuntimeError: a window is to be opened where there is no display.
        """
        if self.mode == "human" and self.closed:
            return None
        one = rows(state, world)
        self._follow(one, world)
        self._sheet.copy(self._still)
        self._scene.paint(self._sheet, one, self._trail)
        pygame.transform.smoothscale(self._sheet.surface, self.size, self._frame)
        if self.mode == "human":
            self._show()
            return None
        return self._pixels()

    def close(self) -> None:
        """Closes the window, if there is one. May be called again."""
        self.closed = True
        if self._window is not None:
            self._window = None
            pygame.display.quit()

    def _follow(self, state: State, world: int) -> None:
        """Brings trail, camera and scenery up to one world of a state."""
        params = self.params
        goal = state.goal if has_goal(params) else None
        if self._begins(state, world):
            bodies = 1 + params.num_boats
            limit = min(1500, max(200, TRAIL_POINTS // bodies))
            self._trail = Trail(bodies, 0.02 * params.vessel.length, limit)
            self._look(first_box(params, state.motion, goal))
        else:
            box = next_box(self._box, params, state.motion, goal)
            if box != self._box:
                self._look(box)
        self._trail.record(int(state.tick), plane(state.motion))
        self._last = world, int(state.tick), _arrangement(state)

    def _begins(self, state: State, world: int) -> bool:
        """Whether this is another episode than that of the frame before."""
        if self._last is None:
            return True
        last_world, last_tick, arrangement = self._last
        again = state.tick == last_tick and not np.array_equal(_arrangement(state), arrangement)
        return world != last_world or bool(state.tick < last_tick) or again

    def _look(self, box: tuple[complex, complex]) -> None:
        """Points the camera at a box of the world and paints what does not move."""
        width, height = self.size
        self._box = box
        self.camera = Camera.covering(box, 0, self._band, width, height - 2 * self._band)
        self._scene = Scene(self.params, self.camera, self.size, self._band)
        self._still.copy(self._water)
        self._scene.paint_still(self._still)

    def _pixels(self) -> Frame:
        width, height = self.size
        data = pygame.image.tobytes(self._frame, "RGB")
        return np.frombuffer(data, dtype=np.uint8).reshape(height, width, 3).copy()

    def _show(self) -> None:
        if self._window is None:
            self._window = self._opened()
        for event in pygame.event.get():
            escape = event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE
            if event.type == pygame.QUIT or escape:
                self.close()
                return
        self._window.blit(self._frame, (0, 0))
        pygame.display.flip()
        self._clock.tick(self.params.clock.control)

    def _opened(self) -> pygame.Surface:
        try:
            pygame.display.init()
            window = pygame.display.set_mode(self.size)
        except pygame.error as error:
            raise RuntimeError(
                f"no window can be opened ({error}); render_mode='rgb_array' needs no display"
            ) from error
        pygame.display.set_caption(f"asv-env: {self.params.task.name}")
        self._clock = pygame.time.Clock()
        return window


class _Sheet:
    """A ``scene.Canvas``, twice as fine as the frame: scaling it down smooths every edge.

    Args:
        size: (width, height) of the frame, px.
        text: height of the letters, px.
    """

    FINE = 2

    def __init__(self, size: tuple[int, int], text: int) -> None:
        pygame.font.init()
        self.surface = pygame.Surface((self.FINE * size[0], self.FINE * size[1]), 0, 32)
        self._font = pygame.font.Font(None, self.FINE * text)

    def copy(self, other: _Sheet) -> None:
        self.surface.blit(other.surface, (0, 0))

    def fill_gradient(self, top: Colour, bottom: Colour) -> None:
        width, height = self.surface.get_size()
        for row in range(height):
            self.surface.fill(mix(top, bottom, row / (height - 1)), (0, row, width, 1))

    def fill(self, points: Float, colour: Colour) -> None:
        # Pygame's coordinates are those of the pixels' centres.
        fine = self.FINE * points - 0.5
        pygame.draw.polygon(self.surface, colour, np.rint(fine).tolist())
        pygame.draw.aalines(self.surface, colour, True, fine.tolist())

    def lines(self, points: Float, width: float, colour: Colour) -> None:
        fine = self.FINE * points - 0.5
        thick = max(1, round(self.FINE * width))
        pygame.draw.lines(self.surface, colour, False, fine.tolist(), thick)

    def write(self, text: str, where: tuple[float, float], anchor: str, colour: Colour) -> float:
        image = self._font.render(text, True, colour)
        box = image.get_rect()
        setattr(box, anchor, (self.FINE * where[0], self.FINE * where[1]))
        self.surface.blit(image, box)
        return image.get_width() / self.FINE


def _arrangement(state: State) -> Float:
    """What tells one world of a state from others at the same tick: its goal and motion."""
    return np.concatenate([state.goal, state.motion.ravel()])


def _checked_size(size: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError) as error:
        raise ValueError(f"size = {size!r}: give (width, height) in pixels") from error
    if min(width, height) < SMALLEST or width % 2 or height % 2:
        raise ValueError(f"size = {size!r}: both must be even and at least {SMALLEST} px")
    return width, height
