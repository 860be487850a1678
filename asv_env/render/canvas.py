"""A canvas to paint on, and pygame, which others import from here."""

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
        self.surface = pygame.Surface((FINE * size[0], FINE * size[1]), 0, 32)
        self._text, self._font = text, _font(text)

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
        try:
            image = self._font.render(text, True, colour)
        except pygame.error:  # ``pygame.quit`` was called, as ``gymnasium.utils.play`` does
            self._font = _font(self._text)
            image = self._font.render(text, True, colour)
        box = image.get_rect()
        setattr(box, anchor, (FINE * where[0], FINE * where[1]))
        self.surface.blit(image, box)
        return image.get_width() / FINE


def _font(text: int) -> pygame.font.Font:
    pygame.font.init()
    return pygame.font.Font(None, FINE * text)
