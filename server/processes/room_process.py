"""A process with rooms: what the front asks it to do, and what it tells the front."""

import asyncio
import logging
import os
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable, Collection
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Concatenate

from starlette.applications import Starlette
from starlette.responses import Response
from starlette.routing import Mount, WebSocketRoute

from movingout.maps import MapSpec
from movingout.recordings.episode import Outcome
from movingout.server.connection.asgi import App, Message, Receive, Send
from movingout.server.monitoring.logs import log_to
from movingout.server.monitoring.status import room_report
from movingout.server.notices import Notice
from movingout.server.processes import news
from movingout.server.processes.channel import Channel, first_message
from movingout.server.processes.handover import TakingOver
from movingout.server.processes.homes import home_of, new_id_at
from movingout.server.processes.shared_agents import SharedAgents
from movingout.server.public_host import Found, Given
from movingout.server.room_host import RoomHost
from movingout.server.rooms import registry
from movingout.server.rooms.prepared_maps import Variant
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Settings
from movingout.server.uvicorn_server import GameServer, game_server

log = logging.getLogger(__name__)

NEWS_S = 1.0
AGENTS_S = 10.0  # without an agent service the rooms come back all the same, and their agents join later


@dataclass(frozen=True)
class Start:
    """The first message to a new process."""

    settings: Settings
    certificate: Certificate | None
    index: int
    processes: int


class RoomProcess(RoomHost):
    """The rooms whose ids say that they live here."""

    def __init__(self, start: Start, control: socket.socket) -> None:
        self.index, self.processes = start.index, start.processes
        self.shared_agents = SharedAgents(start.settings.slow_agents)
        super().__init__(
            start.settings,
            new_room_id=lambda: new_id_at(start.index, start.processes),
            agents=self.shared_agents,
        )
        self.channel: Channel[RoomProcess, news.Listener] = Channel(control, self)
        self.admission.on_socket = lambda what, address: self.channel.tell(news.socket_changed, what, address)

    async def start(self) -> None:
        await self.shared_agents.joined(AGENTS_S)
        for file in list(self.store.load(self.lives_here)):
            await self.restore(file)
        await self.start_rooms()
        self.background.repeat("telling the front", self.tell_news, NEWS_S)

    async def tell_news(self) -> None:
        self.channel.tell(news.heard, self.process_health())

    async def suspend(self) -> None:
        if not self.stopping:
            self.channel.tell(news.leaving)
        await super().suspend()

    def lives_here(self, room_id: str) -> bool:
        return home_of(room_id, self.processes) == self.index

    def recorded(self, room_id: str, size: int) -> None:
        self.channel.tell(news.recorded, room_id, size)

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        self.channel.tell(news.round_over, room_id, played)

    def finish_journal(self, journal: Path) -> None:
        self.channel.tell(news.finish_journal, journal)

    def room_closed(self, room_id: str) -> None:
        super().room_closed(room_id)
        self.channel.tell(news.room_closed, room_id)


# ---- called by the front ------------------------------------------------------------------------------------------


async def open_room(host: RoomProcess, config: RoomConfig, seats: list[Seat]) -> str:
    """Raises MapError and AgentError."""
    return (await host.open_kept(config, seats)).id


def ask(
    host: RoomProcess,
    room_id: str,
    work: Callable[Concatenate[Room, Given], Found],
    *args: Given.args,
    **kwargs: Given.kwargs,
) -> Found:
    return work(host.room(room_id), *args, **kwargs)


def close_room(host: RoomProcess, room_id: str, code: int, notice: Notice, outcome: Outcome) -> PlayedRound:
    return registry.close(host.registry, host.room(room_id), code, notice, outcome)


def look(host: RoomProcess, rooms: Collection[str]) -> dict[str, RoomView | None]:
    return registry.views(host.registry, rooms)


def study_rooms(host: RoomProcess) -> list[str]:
    return registry.study_rooms(host.registry)


def lateness(host: RoomProcess) -> tuple[dict[int, int], int, float]:
    """As `Lateness.counts` gives it."""
    return host.scheduler.lateness.counts()


def hold_rounds(host: RoomProcess) -> int:
    return host.hold_rounds()


def report(host: RoomProcess) -> dict[str, Any]:
    return room_report(host)


def reset_measurements(host: RoomProcess) -> None:
    host.scheduler.lateness.clear()


def keep_map(host: RoomProcess, variant: Variant, made: MapSpec) -> None:
    """A randomised map, made ahead."""
    host.registry.prepared_maps.keep(variant, made)


def episodes(host: RoomProcess) -> list[str]:
    """The rounds that have begun here: their journals are being written."""
    return host.episodes()


# ---- the process --------------------------------------------------------------------------------------------------


def main(control: socket.socket, handover: socket.socket) -> None:
    """Serve until the front ends, or SIGTERM."""
    start = first_message(control, Start)
    handover.setblocking(False)
    log_to(form="json" if start.settings.log_format == "json" else "text")
    host = RoomProcess(start, control)
    routes = [WebSocketRoute("/ws/{room}", _endpoint(host)), Mount("/", _to_the_front)]
    app = Starlette(routes=routes, lifespan=_lifespan(host, handover))
    app.state.host = host
    server = game_server(app, start.settings, start.certificate, on_ready=lambda: None)
    app.state.server = server
    server.run([])
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.stderr.flush()
    os._exit(0)  # the template's own end is not ours


def _endpoint(host: RoomProcess) -> App:
    class Endpoint:
        """That of every server; the front hears of websockets over TLS, which it expects here."""

        async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
            if scope["scheme"] == "wss" and scope.get("client"):
                host.channel.tell(news.arrived, scope["client"][0])
            await host.endpoint(scope, receive, send)

    return Endpoint()


async def _to_the_front(scope: Message, receive: Receive, send: Send) -> None:
    """A request came on a TLS connection that was expected to be a player's: the same again, on another connection."""
    if scope["type"] == "websocket":
        return
    path = "/" + scope["raw_path"].decode("latin-1").lstrip("/\\")  # two slashes would begin another server's name
    query = f"?{scope['query_string'].decode('latin-1')}" if scope["query_string"] else ""
    headers = {"connection": "close", "location": path + query}
    await Response(status_code=307, headers=headers)(scope, receive, send)


def _lifespan(host: RoomProcess, handover: socket.socket) -> Callable[[Starlette], Any]:
    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        server: GameServer = app.state.server
        connections = TakingOver(handover, server, host.shared_agents.join)
        await host.channel.open()
        serving = asyncio.create_task(_serve(host, server))
        connections.start()
        await host.start()
        host.channel.tell(news.became_ready, {room.id: room.config.owner for room in host.registry.rooms.values()})
        yield
        connections.stop()
        await host.suspend()
        await host.stop_rooms()
        serving.cancel()

    return lifespan


async def _serve(host: RoomProcess, server: GameServer) -> None:
    await host.channel.serve()
    server.should_exit = True  # the front has ended, or wants us to end
