"""The websocket endpoint: accepts or refuses a client, and serves its connection from handshake to close.

Written against plain ASGI, because the hot path is one decode and one call. On abuse the connection is dropped without
a close frame: otherwise Uvicorn would go on parsing what the client sends for ten seconds.
"""

import asyncio
from collections.abc import Callable
from functools import partial

from movingout.server import messages as m
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.asgi import WIRE, DirectSocket, Message, Receive, Send, refuse
from movingout.server.connection.client_connection import ClientConnection, Kept
from movingout.server.connection.closing import CloseConnection, no_room, say_goodbye
from movingout.server.connection.hosts import host_refusal
from movingout.server.connection.origin import origin_allowed
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.rooms.room_notices import RESTARTING
from movingout.server.settings import Settings


async def _at_once() -> None:
    """Nothing is kept."""


class SocketEndpoint:
    """The ASGI application behind /ws and /ws/ROOM."""

    def __init__(
        self, settings: Settings, registry: RoomRegistry, admission: AdmissionControl, kept: Kept = _at_once
    ) -> None:
        """`kept` waits until a restart would bring back what rooms are now."""
        self._kept = kept
        self.absence: Callable[[str], CloseConnection] = no_room
        self._settings = settings
        self._registry = registry
        self._admission = admission
        self.stopping = False  # who comes now is told to come back
        self.open: set[ClientConnection] = set()
        self._bytes_sent = 0  # to clients that have left

    def total_bytes_sent(self) -> int:
        return self._bytes_sent + sum(each.client.bytes_sent for each in self.open)

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        await receive()  # websocket.connect
        address = scope["client"][0] if scope.get("client") else ""
        refusal = handshake_refusal(self._settings, scope) or ((503, self._admission.enter(address)))
        if refusal[1]:
            self._admission.refusals["socket"] += 1
            await refuse(send, *refusal)
            return
        wire: DirectSocket = scope["extensions"][WIRE]
        wire.count_until_gone(partial(self._admission.leave, address))  # a client need not hang up after our goodbye
        await send({"type": "websocket.accept", "subprotocol": m.SUBPROTOCOL})
        if self.stopping:
            await say_goodbye(send, CloseConnection(m.CLOSE_SHUTDOWN, RESTARTING))
            return
        connection = ClientConnection(
            self._settings.limits, self._registry, self._admission, wire, address, self.absence, self._kept
        )
        await self._serve(connection, receive, send)

    async def _serve(self, connection: ClientConnection, receive: Receive, send: Send) -> None:
        self.open.add(connection)
        sender = asyncio.create_task(connection.send_all(send))
        listener = asyncio.create_task(connection.listen(receive))
        try:
            await asyncio.wait((sender, listener), return_when=asyncio.FIRST_COMPLETED)
            await connection.end(sender, listener, send)
        finally:
            self._bytes_sent += connection.client.bytes_sent
            self.open.discard(connection)
            connection.leave()


def handshake_refusal(settings: Settings, scope: Message) -> tuple[int, str] | None:
    """The status and the sentence with which a handshake is refused, whatever its address; None for none."""
    if refusal := host_refusal(scope["headers"], settings):
        return refusal
    scheme = "https" if scope["scheme"] == "wss" else "http"
    if not origin_allowed(scope["headers"], scheme, settings.origins):
        return 403, "This page may not talk to this server: its address is not the server's own (see --origin)."
    if m.SUBPROTOCOL not in scope["subprotocols"]:
        return 400, f"This server speaks {m.SUBPROTOCOL}; reload the page, or update the program."
    return None
