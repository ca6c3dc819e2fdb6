"""A server with several processes for the tests: the front in this process, the rooms in real ones."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

from fastapi import FastAPI

from movingout.server.processes.front import Front
from movingout.server.processes.front_server import create_front_app, front_server
from movingout.server.processes.room_link import RoomLink
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Settings
from tests.server.live import Live, serve


@contextmanager
def cluster(data: Path, processes: int = 2, certificate: Certificate | None = None, **options: Any) -> Iterator[Live]:
    """For one `with` block."""
    lock = os.open(data, os.O_RDONLY)

    def app_of(settings: Settings) -> FastAPI:
        return create_front_app(Front(settings, processes, lock, certificate))

    try:
        with serve(data, app_of=app_of, certificate=certificate, server_of=front_server, **options) as live:
            yield live
    finally:
        os.close(lock)


def links(live: Live) -> list[RoomLink]:
    return cast(Front, live.host).links


def home(live: Live, room: str) -> RoomLink:
    return cast(Front, live.host).link_of(room)
