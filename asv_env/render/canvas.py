"""A canvas to paint on, a window that shows it, and pygame, which others import from here."""

import os

import numpy as np

from asv_env.render.colours import Colour, mix
from asv_env.types import Float

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    import pygame
except ImportError as error:
    raise ImportError('rendering needs pygame-ce: pip install "asv-env[eval]"') from error

FINE = 2  #: pixels of a canvas per pixel of the frame: scaling it down smooths every edge


class Canvas:
    """A surface finer than the frame, ``size`` = (width, height) px; letters are ``text`` px high.

    Points are (n, 2) pixels of the frame, widths px.
    """

    def __init__(self, size: tuple[int, int], text: int) -> None:
        pygame.font.init()
        self.surface = pygame.Surface((FINE * size[0], FINE * size[1]), 0, 32)
        self._font = pygame.font.Font(None, FINE * text)

    def fill_gradient(self, top: Colour, bottom: Colour) -> None:
        """Fills the canvas with colours between two."""
        width, height = self.surface.get_size()
        for row in range(height):
            self.surface.fill(mix(top, bottom, row / (height - 1)), (0, row, width, 1))

    def fill(self, points: Float, colour: Colour) -> None:
        """Fills a polygon; pygame's coordinates are those of the centres of pixels."""
        fine = FINE * points - 0.5
        pygame.draw.polygon(self.surface, colour, np.rint(fine).tolist())
        pygame.draw.aalines(self.surface, colour, True, fine.tolist())

    def lines(self, points: Float, width: float, colour: Colour) -> None:
        """Draws a line through points."""
        fine = FINE * points - 0.5
        pygame.draw.lines(self.surface, colour, False, fine.tolist(), max(1, round(FINE * width)))

    def write(self, text: str, where: tuple[float, float], anchor: str, colour: Colour) -> float:
        """Writes a text at its "midleft", "center" or "midright"; returns its width, px."""
        image = self._font.render(text, True, colour)
        box = image.get_rect()
        setattr(box, anchor, (FINE * where[0], FINE * where[1]))
        self.surface.blit(image, box)
        return image.get_width() / FINE


class Window:
    """A window on the screen, opened with the first frame."""

    _surface: pygame.Surface | None = None
    closed = False  #: whether ``close`` was called, or the user closed the window

    def __init__(self, title: str, fps: int) -> None:
        self._title, self._fps, self._clock = title, fps, pygame.time.Clock()

    def show(self, frame: pygame.Surface) -> None:
        """Shows a frame, and waits until it is due.

        Raises:
            RuntimeError: there is no display.
        """
        self._surface = self._surface or self._opened(frame.get_size())
        for event in pygame.event.get():
            escape = event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE
            if event.type == pygame.QUIT or escape:
                self.close()
                return
        self._surface.blit(frame, (0, 0))
        pygame.display.flip()
        self._clock.tick(self._fps)

    def close(self) -> None:
        """Closes the window. May be called again."""
        self.closed = True
        if self._surface is not None:
            self._surface = None
            pygame.display.quit()

    def _opened(self, size: tuple[int, int]) -> pygame.Surface:
        try:
            pygame.display.init()
            surface = pygame.display.set_mode(size)
        except pygame.error as error:
            raise RuntimeError(
                f"no window can be opened ({error}); render_mode='rgb_array' needs no display"
            ) from error
        pygame.display.set_caption(self._title)
        return surface
