"""A window that shows pictures of an environment, by pygame."""

import importlib
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.world.errors import WorldError


class Window:
    """Opens with the first picture; stays closed when its user has closed it.

    pygame has one window: several environments of a process take turns in it, and it goes with the first that closes.
    """

    def __init__(self, title: str, pictures_per_second: int) -> None:
        """Raises WorldError, which says what to install, without pygame."""
        try:
            self._pygame: Any = importlib.import_module("pygame")
        except ImportError as error:
            raise WorldError(
                "render_mode 'human' shows a window with pygame; install it with: pip install pygame"
            ) from error
        self._title = title
        self._pictures_per_second = pictures_per_second
        self._screen: Any = None
        self._clock = self._pygame.time.Clock()
        self._closed = False

    def show(self, pixels: npt.NDArray[np.uint8]) -> None:
        """Show a picture (H, W, 3), no sooner than its turn. Raises WorldError where there is no display."""
        if self._closed:
            return
        if self._screen is None or self._screen is not self._pygame.display.get_surface():
            self._screen = self._opened(pixels.shape[1], pixels.shape[0])
        self._screen.blit(self._pygame.surfarray.make_surface(pixels.swapaxes(0, 1)), (0, 0))
        self._pygame.display.flip()
        if any(event.type == self._pygame.QUIT for event in self._pygame.event.get()):
            self.close()
            self._closed = True
        self._clock.tick(self._pictures_per_second)

    def close(self) -> None:
        """Close it; the next picture opens it again."""
        if self._screen is not None:
            self._pygame.display.quit()
            self._screen = None

    def _opened(self, width: int, height: int) -> Any:
        try:
            self._pygame.display.init()
            screen = self._pygame.display.set_mode((width, height))
        except self._pygame.error as error:
            raise WorldError(
                f"no window can be opened here ({error}); render_mode='rgb_array' gives the pictures without one"
            ) from error
        self._pygame.display.set_caption(self._title)
        return screen
