"""A window on the screen that shows frames at the control rate."""

from asv_env.render.canvas import pygame


class Window:
    """A window of ``size`` px, opened with the first frame.

    Attributes:
        closed: whether ``close`` was called, or the user closed the window.
    """

    def __init__(self, size: tuple[int, int], title: str, fps: int) -> None:
        self._size, self._title, self._fps = size, title, fps
        self._clock = pygame.time.Clock()
        self._surface: pygame.Surface | None = None
        self.closed = False

    def show(self, frame: pygame.Surface) -> None:
        """Shows a frame, and waits until it is due.

        Raises:
            RuntimeError: there is no display.
        """
        if self._surface is None:
            self._surface = self._opened()
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

    def _opened(self) -> pygame.Surface:
        try:
            pygame.display.init()
            surface = pygame.display.set_mode(self._size)
        except pygame.error as error:
            raise RuntimeError(
                f"no window can be opened ({error}); render_mode='rgb_array' needs no display"
            ) from error
        pygame.display.set_caption(self._title)
        return surface
