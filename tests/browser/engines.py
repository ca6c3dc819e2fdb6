"""Three browser engines behind one small interface: Chromium, Firefox and WebKit (Safari's engine).

Chromium is driven by Playwright, Firefox by WebDriver BiDi over its own socket, WebKit by WebKitWebDriver (W3C
WebDriver over HTTP) on a virtual screen. All draw without a graphics processor, WebKit if wanted with one that Mesa
emulates, which is how WebKitGTK comes.
"""

import itertools
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from playwright.sync_api import Browser, Page, sync_playwright
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from tests.browser.install import NoBrowser, find_chromium
from tests.browser.support import free_port, launch

WIDTH, HEIGHT = 1280, 900
START_S = 60.0
MINIBROWSERS = "/usr/lib/*/webkit2gtk-4.*/MiniBrowser"
PACKAGES = {
    "firefox": ("firefox-esr", ("firefox-esr",)),
    "webkit": ("webkit2gtk-driver xvfb", ("WebKitWebDriver", "Xvfb")),
}
# What --disable-gpu is for Chromium: windows are put together by the processor, not by an emulated graphics processor.
WEBKIT_WITHOUT_GPU = {"WEBKIT_DISABLE_COMPOSITING_MODE": "1"}
KEYS = {
    "Enter": "\ue007",
    "Space": " ",
    "Tab": "\ue004",
    "Shift": "\ue008",
    "ArrowRight": "\ue014",
}  # W3C WebDriver, 17.4.2


T = TypeVar("T")


class Tab(Protocol):
    """One page of one engine, as wide and high as the others."""

    def goto(self, url: str) -> None: ...

    def evaluate(self, expression: str) -> Any:
        """The value of a JavaScript expression; a promise is waited for."""

    def key(self, name: str, down: bool) -> None:
        """`name` is a letter or a key of `KEYS`."""

    def click(self, x: float, y: float) -> None: ...


def missing(engine: str) -> str:
    """What to install before this engine can be driven; empty if it is all there."""
    if engine == "chromium":
        try:
            find_chromium()
        except NoBrowser as error:
            return str(error)
        return ""
    packages, programs = PACKAGES[engine]
    if all(shutil.which(program) for program in programs) and (engine == "firefox" or _minibrowser()):
        return ""
    return f"{engine} is not here; install it with `apt-get install --no-install-recommends {packages}`"


@contextmanager
def open_tab(engine: str, chromium: Browser | None = None, emulated_gpu: bool = False) -> Iterator[Tab]:
    """A tab in a fresh browser, or in `chromium` if one runs already; `emulated_gpu`: of WebKit. Raises NoBrowser."""
    sentence = missing(engine)
    if sentence:
        raise NoBrowser(sentence)
    if engine == "chromium":
        with _chromium(chromium) as tab:
            yield tab
    else:
        with _firefox() if engine == "firefox" else _webkit(emulated_gpu) as tab:
            yield tab


def take_seats(tab: Tab, url: str, room: dict[str, Any], phase: str = "lobby") -> None:
    """Open the game page of a room with the seats that it was made with, as the lobby does, and wait for `phase`."""
    tab.goto(f"{url}/static/theme.js")  # any small page of the same origin
    seats = json.dumps([token for token in room["tokens"] if token])
    tab.evaluate(f"sessionStorage.setItem({json.dumps('movingout.tokens.' + room['room'])}, {json.dumps(seats)})")
    tab.goto(url + room["join_path"])
    wait_until(tab, f"window.__movingout.ready && window.__movingout.phase === '{phase}'")


def wait_until(tab: Tab, expression: str, timeout_s: float = 60.0) -> None:
    """Until a JavaScript expression is true; a page that is still loading has no answer yet."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        if tab.evaluate(f"(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()"):
            return
        time.sleep(0.1)
    raise AssertionError(f"never true: {expression}")


def click_on(tab: Tab, selector: str) -> None:
    """Click the middle of an element once it is there, scrolled into view."""
    wait_until(tab, f"document.querySelector({json.dumps(selector)})?.checkVisibility()")
    tab.evaluate(f"document.querySelector({json.dumps(selector)}).scrollIntoView({{block: 'center'}})")
    middle = f"""(() => {{
      const box = document.querySelector({json.dumps(selector)}).getBoundingClientRect();
      return [box.x + box.width / 2, box.y + box.height / 2];
    }})()"""
    tab.click(*tab.evaluate(middle))


def press(tab: Tab, name: str, hold_s: float = 0.05) -> None:
    tab.key(name, True)
    time.sleep(hold_s)
    tab.key(name, False)


# ---- Chromium ---------------------------------------------------------------------------------------------------


class _PlaywrightTab:
    def __init__(self, page: Page) -> None:
        self._page = page

    def goto(self, url: str) -> None:
        self._page.goto(url)

    def evaluate(self, expression: str) -> Any:
        return self._page.evaluate(expression)

    def key(self, name: str, down: bool) -> None:
        (self._page.keyboard.down if down else self._page.keyboard.up)(name)

    def click(self, x: float, y: float) -> None:
        self._page.mouse.click(x, y)


@contextmanager
def _chromium(running: Browser | None) -> Iterator[Tab]:
    with ExitStack() as stack:
        browser = running or launch(stack.enter_context(sync_playwright()))
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
        yield _PlaywrightTab(page)
        page.context.close()
        if running is None:
            browser.close()


# ---- Firefox: WebDriver BiDi ------------------------------------------------------------------------------------


class _BidiTab:
    def __init__(self, socket: Connection) -> None:
        self._socket = socket
        self._ids = itertools.count(1)
        self._send("session.new", capabilities={})
        self._context = self._send("browsingContext.getTree")["contexts"][0]["context"]
        size = {"width": WIDTH, "height": HEIGHT}
        self._send("browsingContext.setViewport", context=self._context, viewport=size)

    def _send(self, method: str, **params: Any) -> Any:
        number = next(self._ids)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._socket.recv(START_S))
            if answer.get("id") != number:
                continue  # an event
            if answer["type"] == "error":
                raise AssertionError(f"{method}: {answer['message']}")
            return answer["result"]

    def goto(self, url: str) -> None:
        self._send("browsingContext.navigate", context=self._context, url=url, wait="complete")

    def evaluate(self, expression: str) -> Any:
        answer = self._send(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({expression})) ?? 'null')()",
            target={"context": self._context},
            awaitPromise=True,
        )
        if answer["type"] == "exception":
            raise AssertionError(answer["exceptionDetails"]["text"])
        return json.loads(answer["result"]["value"])

    def _act(self, kind: str, *actions: dict[str, Any]) -> None:
        source = {"type": kind, "id": kind, "actions": list(actions)}
        self._send("input.performActions", context=self._context, actions=[source])

    def key(self, name: str, down: bool) -> None:
        self._act("key", {"type": "keyDown" if down else "keyUp", "value": KEYS.get(name, name)})

    def click(self, x: float, y: float) -> None:
        self._act("pointer", *_click_actions(x, y))


@contextmanager
def _firefox() -> Iterator[Tab]:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = ["firefox-esr", "--headless", "--no-remote", "--remote-debugging-port", "0", "--profile", profile]
        log = Path(profile) / "firefox.log"
        with _process(command, log):
            address = _await(lambda: re.search(r"ws://[\d.:]+", log.read_text(errors="replace")), "Firefox")
            with connect(f"{address.group()}/session", max_size=None) as socket:
                yield _BidiTab(socket)


# ---- WebKit: W3C WebDriver --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _WebDriverTab:
    address: str  # of the session

    def _send(self, path: str, **body: Any) -> Any:
        return _post(f"{self.address}/{path}", body)

    def goto(self, url: str) -> None:
        self._send("url", url=url)

    def evaluate(self, expression: str) -> Any:
        script = f"""const done = arguments[0];
          (async () => done(JSON.stringify(await ({expression})) ?? "null"))().catch((error) => done("!" + error));"""
        answer = str(self._send("execute/async", script=script, args=[]))
        if answer.startswith("!"):
            raise AssertionError(answer[1:])
        return json.loads(answer)

    def _act(self, kind: str, *actions: dict[str, Any]) -> None:
        self._send("actions", actions=[{"type": kind, "id": kind, "actions": list(actions)}])

    def key(self, name: str, down: bool) -> None:
        self._act("key", {"type": "keyDown" if down else "keyUp", "value": KEYS.get(name, name)})

    def click(self, x: float, y: float) -> None:
        self._act("pointer", *_click_actions(x, y))


@contextmanager
def _webkit(emulated_gpu: bool) -> Iterator[Tab]:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True)))
        display = folder / "display"
        screen = f"{WIDTH + 40}x{HEIGHT + 200}x24"
        with display.open("wb") as file:
            shell = f"exec Xvfb -displayfd 1 -nolisten tcp -screen 0 {screen}"
            stack.enter_context(_process(["bash", "-c", shell], folder / "xvfb.log", stdout=file.fileno()))
        number = _await(lambda: re.search(r"\d+(?=\n)", display.read_text()), "Xvfb").group()
        port = free_port()
        surroundings = {"DISPLAY": f":{number}", "XDG_RUNTIME_DIR": str(folder), "GDK_BACKEND": "x11"}
        surroundings |= {} if emulated_gpu else WEBKIT_WITHOUT_GPU
        stack.enter_context(_process(["WebKitWebDriver", f"--port={port}"], folder / "webkit.log", surroundings))
        address = f"http://127.0.0.1:{port}"
        _await(lambda: _answers(f"{address}/status"), "WebKitWebDriver")
        options = {"binary": _minibrowser(), "args": ["--automation"]}
        wanted = {"alwaysMatch": {"webkitgtk:browserOptions": options, "timeouts": {"script": 120_000}}}
        session = _post(f"{address}/session", {"capabilities": wanted})["sessionId"]
        tab = _WebDriverTab(f"{address}/session/{session}")
        tab._send("window/rect", x=0, y=0, width=WIDTH, height=HEIGHT + 100)
        yield tab
        urllib.request.urlopen(urllib.request.Request(tab.address, method="DELETE"), timeout=20).close()


def _minibrowser() -> str:
    found = sorted(Path("/").glob(MINIBROWSERS[1:]))
    return str(found[-1]) if found else ""


def _post(url: str, body: dict[str, Any]) -> Any:
    request = urllib.request.Request(url, json.dumps(body).encode(), {"Content-Type": "application/json"})
    try:
        with urllib.request.urlopen(request, timeout=180) as answer:
            return json.load(answer)["value"]
    except urllib.error.HTTPError as error:
        raise AssertionError(f"{url}: {error.read().decode(errors='replace')[:500]}") from error


# ---- both -------------------------------------------------------------------------------------------------------


def _click_actions(x: float, y: float) -> list[dict[str, Any]]:
    return [
        {"type": "pointerMove", "x": round(x), "y": round(y), "duration": 0},
        {"type": "pointerDown", "button": 0},
        {"type": "pointerUp", "button": 0},
    ]


@contextmanager
def _process(
    command: list[str], log: Path, surroundings: dict[str, str] | None = None, stdout: int | None = None
) -> Iterator[None]:
    with log.open("wb") as file:
        environment = {**os.environ, **(surroundings or {})}
        process = subprocess.Popen(command, stdout=file if stdout is None else stdout, stderr=file, env=environment)
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _await(look: Callable[[], T | None], what: str) -> T:
    """What `look` returns once it is something."""
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline:
        found = look()
        if found:
            return found
        time.sleep(0.1)
    raise AssertionError(f"{what} does not start")


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=2):
            return True
    except (urllib.error.URLError, ConnectionError, TimeoutError):
        return False
