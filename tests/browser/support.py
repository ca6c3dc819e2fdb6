"""A running server and pages that look at it, for the browser tests and `bench/browser.py`.

Nothing here knows pytest. The server is a process of its own with a port and a data folder of its own, because that
is what a browser meets.
"""

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, ConsoleMessage, Page, Playwright, expect

from tests.browser.install import find_chromium

# Without --disable-gpu a machine without a graphics processor draws at 8 frames per second.
FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-timer-throttling")
START_S = 60.0
DESKTOP = {"width": 1240, "height": 760}
PHONE = {"width": 390, "height": 844}


@dataclass(frozen=True)
class Server:
    """A `movingout play` on a loopback port."""

    url: str
    data: Path
    log: Path

    def request(self, path: str, body: dict[str, Any] | None = None, token: str = "") -> Any:
        """The JSON answer to a GET, or to a POST of `body`."""
        headers = {"Content-Type": "application/json", **({"Authorization": f"Bearer {token}"} if token else {})}
        data = None if body is None else json.dumps(body).encode()
        with urllib.request.urlopen(urllib.request.Request(self.url + path, data, headers), timeout=20) as answer:
            return json.load(answer)

    @property
    def admin_token(self) -> str:
        """Of the file that the server made."""
        return (self.data / "admin-token").read_text(encoding="ascii").strip()

    def post(self, path: str, body: dict[str, Any]) -> dict[str, Any]:
        """As the operator: the 20 rooms a minute of an address are for the pages."""
        for _ in range(60):  # a server that is too busy for another room says so, and has room again soon
            try:
                document: dict[str, Any] = self.request(path, body, self.admin_token)
            except urllib.error.HTTPError as error:
                if error.code != 503:
                    raise
                time.sleep(0.5)
            else:
                return document
        raise AssertionError(f"the server was busy for half a minute: {path}")

    def close_rooms(self, admin_token: str) -> None:
        for room in self.request("/api/admin/state", token=admin_token)["rooms"]:
            self.request(f"/api/admin/rooms/{room['room']}/close", {}, admin_token)

    def make_room(
        self,
        map_name: str,
        blue: str = "here",
        red: str = "link",
        limit_ticks: int = 500,
        maps: tuple[str, ...] = (),
        **more: Any,
    ) -> dict[str, Any]:
        """`blue` and `red`: here, link, or the id of an agent."""
        seats = [_seat(blue), _seat(red)]
        return self.post(
            "/api/rooms", {"maps": list(maps or (map_name,)), "limit_ticks": limit_ticks, "seats": seats, **more}
        )

    def practice(self, red: str = "idle") -> dict[str, Any]:
        """A practice room on `Simple` (a countdown of 1 s) for blue; `red`: here, link, or the id of an agent."""
        return self.post("/api/rooms", {"maps": ["Simple"], "practice": True, "seats": [_seat("here"), _seat(red)]})


def _seat(who: str) -> dict[str, str]:
    return {"kind": who} if who in ("here", "link") else {"kind": "agent", "agent": who}


@contextmanager
def running_server(folder: Path, port: int = 0) -> Iterator[Server]:
    """Start a server (on a free port), wait until it answers, stop it gently."""
    port = port or free_port()
    server = Server(f"http://127.0.0.1:{port}", folder / "data", folder / "server.log")
    process = start_process(server)
    try:
        yield server
    finally:
        stop_process(process)


def start_process(server: Server, *action: str) -> subprocess.Popen[bytes]:
    """The process of a server, once it answers; `action` is "play" or, say, "study", "serve", FILE."""
    port = server.url.rpartition(":")[2]
    action = action or ("play", "--countdown", "1", "--processes", "1")
    command = [sys.executable, "-m", "movingout.server.cli", *action, "--port", port, "--data", str(server.data)]
    with server.log.open("ab") as log:
        process = subprocess.Popen(
            command, stdout=log, stderr=subprocess.STDOUT, env={**os.environ, "PYTHONUNBUFFERED": "1"}
        )
    try:
        _wait_until_up(server, process)
    except BaseException:
        process.kill()
        process.wait()
        raise
    return process


def stop_process(process: subprocess.Popen[bytes]) -> None:
    """Gently, if it lets itself be stopped."""
    process.terminate()
    try:
        process.wait(timeout=20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@contextmanager
def temporary_server() -> Iterator[Server]:
    with tempfile.TemporaryDirectory() as folder, running_server(Path(folder)) as server:
        yield server


def launch(playwright: Playwright, flags: tuple[str, ...] = FLAGS) -> Browser:
    return playwright.chromium.launch(executable_path=str(find_chromium()), args=list(flags))


def seat_tokens_script(room: dict[str, Any]) -> str:
    """What the lobby does before it opens the game: the seats of this tab."""
    tokens = json.dumps([token for token in room["tokens"] if token])
    key = json.dumps(f"movingout.tokens.{room['room']}")
    once = f"if (!sessionStorage.getItem({key})) sessionStorage.setItem({key}, {json.dumps(tokens)});"
    return f"if (location.protocol !== 'about:') {{ {once} }}"  # a blank page has no storage


def complaints(page: Page) -> list[str]:
    """Everything that the page complains about from now on: console errors and warnings, errors nobody caught."""
    heard: list[str] = []

    def console(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            heard.append(f"{message.type}: {message.text}")

    page.on("console", console)
    page.on("pageerror", lambda error: heard.append(f"uncaught: {error}"))
    return heard


def wait_for(page: Page, expression: str, timeout_s: float = 15.0) -> None:
    """Until `expression` over `game` (window.__movingout) is true."""
    page.wait_for_function(
        f"() => {{ const game = window.__movingout; return game?.ready && ({expression}); }}", timeout=timeout_s * 1e3
    )


def start(*pages: Page, tap: bool = False) -> None:
    """Everybody says that they are ready; the 3-2-1 runs."""
    for page in pages:
        buttons = page.get_by_role("button", name="I am ready")
        buttons.first.wait_for()
        waiting = buttons.count()
        if tap:
            buttons.first.tap()
        else:
            buttons.first.click()
        expect(buttons).to_have_count(waiting - 1)  # two at one screen are not the same one twice
    for page in pages:
        wait_for(page, "game.phase === 'playing'")


def robot(page: Page, seat: int) -> dict[str, float]:
    """A robot as drawn: x, y, angle, held."""
    seen: dict[str, float] = page.evaluate("(seat) => window.__movingout.entities().robots[seat]", seat)
    return seen


def frame_gaps(page: Page) -> tuple[float, float]:
    """Median and 99th percentile of the time between two drawn frames, in ms."""
    gaps = sorted(page.evaluate("window.__movingout.gaps"))
    return gaps[len(gaps) // 2], gaps[int(0.99 * (len(gaps) - 1))]


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port: int = listener.getsockname()[1]
        return port


def _wait_until_up(server: Server, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline:
        if process.poll() is not None:
            raise RuntimeError(f"the server ended with {process.returncode}:\n{server.log.read_text()}")
        try:
            with urllib.request.urlopen(f"{server.url}/healthz", timeout=2):
                return
        except (urllib.error.URLError, ConnectionError, TimeoutError):
            time.sleep(0.1)
    raise RuntimeError(f"the server does not answer after {START_S:.0f} s:\n{server.log.read_text()}")


STORAGE_FORBIDDEN = """for (const name of ["localStorage", "sessionStorage"])
  Object.defineProperty(window, name, { get() { throw new DOMException("denied", "SecurityError"); } });"""
