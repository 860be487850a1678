"""A window of its own on the screen, which leaves other windows of the process alone."""

import os
from typing import Any

from asv_env.render.canvas import pygame

INVISIBLE = ("dummy", "offscreen")  #: drivers that SDL takes where there is no display
DRIVER_VARIABLES = ("SDL_VIDEODRIVER", "SDL_VIDEO_DRIVER")  #: by which a user asks for a driver


class Window:
    """A window on the screen, opened with the first frame."""

    closed = False  #: whether ``close`` was called, or the user closed the window
    _open: list[Any] = []  #: the open windows of the process
    _opened_display = False  #: whether the display was opened for them

    def __init__(self, title: str, fps: int) -> None:
        self._title, self._fps, self._clock = title, fps, pygame.time.Clock()
        self._window: Any = None

    def show(self, frame: pygame.Surface) -> None:
        """Shows a frame, and waits until it is due.

        Raises:
            RuntimeError: there is no display.
        """
        if self._window is None:
            self._window = self._opened(frame.get_size())
            Window._open.append(self._window)
        if not self._exists() or self._asked_to_close():
            self.close()
            return
        self._window.get_surface().blit(frame, (0, 0))
        self._window.flip()
        self._clock.tick(self._fps)

    def close(self) -> None:
        """Closes the window. May be called again."""
        self.closed = True
        window, existed, self._window = self._window, self._exists(), None
        if window is None:
            return
        Window._open.remove(window)
        if existed:
            window.destroy()
        else:
            Window._opened_display = False
        if Window._alone() and not Window._open:
            pygame.display.quit()
            Window._opened_display = False

    def _exists(self) -> bool:
        """Returns whether the window is open; ``pygame.quit`` closes windows too."""
        try:
            return bool(pygame.display.get_init() and self._window and self._window.get_surface())
        except pygame.error:
            return False

    def _asked_to_close(self) -> bool:
        """Returns whether the user wants this window closed; events of others stay for them."""
        kinds = (pygame.QUIT, pygame.WINDOWCLOSE, pygame.KEYDOWN)
        asked, others = False, []
        for event in pygame.event.get(kinds):
            escape = event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE
            if event.type == pygame.QUIT:
                asked = True
            elif getattr(event, "window", None) is self._window:
                asked |= escape or event.type == pygame.WINDOWCLOSE
                continue
            others.append(event)
        if Window._alone():
            pygame.event.clear()
            others = [event for event in others if len(Window._open) > 1]
        for event in others:
            pygame.event.post(event)
        return asked

    @classmethod
    def _alone(cls) -> bool:
        """Returns whether nobody but these windows uses the display."""
        return cls._opened_display and pygame.display.get_surface() is None

    def _opened(self, size: tuple[int, int]) -> Any:
        if not hasattr(pygame, "Window"):
            raise RuntimeError(
                f"no window can be opened with pygame {pygame.version.ver}; install pygame-ce "
                "(pip install 'asv-env[eval]'), or use render_mode='rgb_array'"
            )
        try:
            if not pygame.display.get_init():
                pygame.display.init()
                Window._opened_display = True
            driver = pygame.display.get_driver()
            if driver in INVISIBLE and not any(map(os.environ.get, DRIVER_VARIABLES)):
                raise pygame.error(f"there is no display, only the driver {driver!r}")
            return pygame.Window(self._title, size)
        except pygame.error as error:
            if Window._alone() and not Window._open:
                pygame.display.quit()
                Window._opened_display = False
            raise RuntimeError(
                f"no window can be opened ({error}); render_mode='rgb_array' needs no display"
            ) from error
