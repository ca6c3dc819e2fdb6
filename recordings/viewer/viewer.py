"""The viewer as a server: a panel per visitor, on loopback unless told otherwise.

viser runs its own HTTP and websocket server in a thread of its own; there is no password, so whoever reaches the port
sees the recordings.
"""

import contextlib
import io
import socket
import time
from types import TracebackType
from typing import Self

import viser

from movingout.recordings.errors import RecordingError
from movingout.recordings.viewer.cameras import Camera
from movingout.recordings.viewer.panel import Panel
from movingout.recordings.viewer.recording_cache import RecordingCache

FRAME_S = 0.05  # how often the play heads move
_LAST_PORT = 65_535


class _Server(viser.ViserServer):
    """A viser server that stays on this machine: its browser client may ask for a public tunnel, and gets none."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        return None


def open_server(host: str, port: int) -> viser.ViserServer:
    """A viser server on exactly this port; 0 takes any free one. RecordingError when it cannot be had.

    viser itself would go on to the next port, or wait for ever where the address is none of this machine's.
    """
    if not 0 <= port <= _LAST_PORT:
        raise RecordingError(f"cannot listen on {host} port {port}: ports go from 0 to {_LAST_PORT}")
    try:
        with socket.create_server((host, port)):
            pass
    except OSError as error:
        raise RecordingError(
            f"cannot listen on {host} port {port}: {error.strerror or error}; "
            "choose another one with --port, or stop the program that has it"
        ) from error
    with _quiet():
        return _Server(host, port, label="Moving Out Live", verbose=False)


def close_server(server: viser.ViserServer) -> None:
    with _quiet():
        server.stop()


def _quiet() -> contextlib.redirect_stdout[io.StringIO]:
    """Standard output is for results: viser prints a banner when it starts and a line when it stops."""
    return contextlib.redirect_stdout(io.StringIO())


class Viewer:
    """Shows the recordings of a cache to everybody who opens its page. Use as a context manager."""

    def __init__(self, cache: RecordingCache, host: str = "127.0.0.1", port: int = 0) -> None:
        for name in cache.shown_first:
            cache.episode(name)  # report a broken file before a page opens
        self._cache = cache
        self._panels: dict[int, Panel] = {}
        self.host = host
        self.server = open_server(host, port)
        self.server.gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium")
        self.server.gui.main_panel.dock_right()
        self.server.on_client_connect(self._welcome)
        self.server.on_client_disconnect(self._dismiss)

    @property
    def url(self) -> str:
        return f"http://{self.host}:{self.server.get_port()}"

    @property
    def panels(self) -> tuple[Panel, ...]:
        """One per visitor."""
        return tuple(self._panels.values())

    def run(self) -> None:
        """Move the play heads until interrupted."""
        before = time.monotonic()
        while True:
            time.sleep(FRAME_S)
            now = time.monotonic()
            self.advance(now - before)
            before = now

    def advance(self, elapsed_s: float) -> None:
        """Let time pass for every visitor."""
        for panel in self.panels:
            panel.advance(elapsed_s)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        close_server(self.server)

    def _welcome(self, client: viser.ClientHandle) -> None:
        def look(camera: Camera) -> None:
            with client.atomic():
                client.camera.up_direction = camera.up
                client.camera.position = camera.position
                client.camera.look_at = camera.look_at

        with client.atomic():
            self._panels[client.client_id] = Panel(client.gui, client.scene, self._cache, look)

    def _dismiss(self, client: viser.ClientHandle) -> None:
        self._panels.pop(client.client_id, None)
