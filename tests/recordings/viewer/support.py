"""Panels without a browser: on a server's own scene, with a camera that only remembers where it was sent."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from movingout.recordings.viewer.cameras import Camera
from movingout.recordings.viewer.panel import Panel
from movingout.recordings.viewer.recording_cache import RecordingCache
from movingout.recordings.viewer.viewer import close_server, open_server
from tests.recordings.support import record


def recorded(folder: Path, name: str = "episode", ticks: int = 30, **start: object) -> Path:
    """A journal of a short episode; the viewer reads it like a finished file."""
    path, _ = record(folder, ticks, "time", episode_id=name, **start)
    return path


@contextmanager
def panel(*paths: Path) -> Iterator[tuple[Panel, list[Camera]]]:
    """A panel and the views it asked for."""
    server = open_server("127.0.0.1", 0)
    views: list[Camera] = []
    try:
        yield Panel(server.gui, server.scene, RecordingCache(paths), views.append), views
    finally:
        close_server(server)


def put(control: Any, value: object) -> None:
    """What a visitor does with a control. Untyped, because mypy overlooks viser's setter."""
    control.value = value
