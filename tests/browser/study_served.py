"""`movingout study serve` as a browser meets it: a process that may be killed and started again."""

import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Page

from tests.browser.chromium import close
from tests.browser.support import DESKTOP, Server, complaints, free_port, start_process, stop_process

# What a browser says by itself when the server is away.
EXPECTED = ("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "ERR_INCOMPLETE_CHUNKED_ENCODING", "ERR_EMPTY_RESPONSE",
            "ERR_SOCKET_NOT_CONNECTED", "WebSocket connection")  # fmt: skip


class StudyServer:
    """A study that is served, and the pages that look at it."""

    def __init__(self, folder: Path, text: str, browser: Browser, processes: int = 1) -> None:
        self._processes = processes
        self.file = folder / "study.yaml"
        self.file.write_text(text, encoding="utf-8")
        self.server = Server(f"http://127.0.0.1:{free_port()}", folder / "data", folder / "server.log")
        self.asked: set[str] = set()  # every address that a page asked for
        self._browser = browser
        self._contexts: list[BrowserContext] = []
        self._heard: list[list[str]] = []
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._process = start_process(
            self.server, "study", "serve", str(self.file), "--processes", str(self._processes)
        )

    def kill(self) -> None:
        """kill -9."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()

    def stop(self) -> None:
        try:
            close(*self._contexts)
        finally:
            if self._process is not None:
                stop_process(self._process)

    @property
    def token(self) -> str:
        """Of the experimenter, as the server printed it last."""
        file = re.findall(r"Token\s+in (.+)", self.server.log.read_text(encoding="utf-8"))[-1]
        return Path(file).read_text(encoding="ascii").strip()

    def page(self, path: str, **options: object) -> Page:
        """A page in a browser of its own."""
        context = self._browser.new_context(base_url=self.server.url, **{"viewport": DESKTOP, **options})  # type: ignore[arg-type]
        page = context.new_page()
        page.on("request", lambda request: self.asked.add(request.url))
        self._contexts.append(context)
        self._heard.append(complaints(page))
        page.goto(path)
        return page

    def third_parties(self) -> set[str]:
        return {url for url in self.asked if not url.startswith((self.server.url, "data:", "blob:"))}

    def complaints(self) -> list[str]:
        """What pages complained about, but for a server that was away."""
        heard = [complaint for page in self._heard for complaint in page]
        return [one for one in heard if not any(words in one for words in EXPECTED)]


@contextmanager
def served_study(folder: Path, text: str, browser: Browser, processes: int = 1) -> Iterator[StudyServer]:
    study = StudyServer(folder, text, browser, processes)
    study.start()
    try:
        yield study
    finally:
        study.stop()
