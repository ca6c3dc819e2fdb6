"""One Chromium for many tests, until it no longer answers: then it is killed, and the next test gets a new one.

Most calls of Playwright have no time limit, those that open and close contexts among them.
"""

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

import psutil
from playwright.sync_api import Browser, BrowserContext, Error, Playwright

from tests.browser.support import FLAGS, launch

ANSWERS_S = 30.0
PLAYWRIGHTS = "--remote-debugging-pipe"  # what Playwright starts each Chromium with


class Chromium:
    def __init__(self, playwright: Playwright, flags: tuple[str, ...] = FLAGS) -> None:
        self._playwright = playwright
        self._flags = flags
        self._browser: Browser | None = None

    @contextmanager
    def for_a_test(self) -> Iterator[Browser]:
        """Whatever a test leaves open, as one that fails does, is closed."""
        if self._browser is None or not _answers(self._browser):
            self._browser = launch(self._playwright, self._flags)
        try:
            yield self._browser
        finally:
            close(*self._browser.contexts)

    def close(self) -> None:
        if self._browser is not None:
            close(self._browser)


def close(*opened: Browser | BrowserContext) -> None:
    """Raises Error where Chromium does not answer and so was killed."""
    with _limit(), ExitStack() as stack:
        for one in opened:
            stack.callback(one.close)


def _answers(browser: Browser) -> bool:
    try:
        with _limit():
            browser.new_context().close()
    except Error:
        return False
    return True


@contextmanager
def _limit() -> Iterator[None]:
    timer = threading.Timer(ANSWERS_S, _kill)
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _kill() -> None:
    """What waits for an answer then raises; a signal that Chromium could refuse would change nothing."""
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.Error):
            if PLAYWRIGHTS in process.cmdline():
                process.kill()
