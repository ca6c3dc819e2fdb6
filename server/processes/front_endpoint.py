"""Websockets at the front: each goes to the process in which its room lives.

A plain connection is handed over before its handshake. A TLS connection cannot be: it is accepted, noted and closed,
and the next connections from the same address go to that process before a byte of TLS is exchanged, until the websocket
is there. Whatever else comes there meanwhile is sent back; should the websocket miss, the same happens again.
"""

import asyncio
from typing import cast

from movingout.server import messages as m
from movingout.server.connection.asgi import WIRE, Message, Receive, Send, refuse
from movingout.server.connection.closing import CloseConnection, say_goodbye
from movingout.server.connection.endpoint import handshake_refusal
from movingout.server.connection.uvicorn_protocols.websocket_protocol import GameWebSocketProtocol
from movingout.server.notices import Notice
from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.front import Front
from movingout.server.processes.handover import PLAIN
from movingout.server.processes.room_link import RoomLink

TRIES, AGAIN_S = 5, 0.05
NO_ROOM_NAMED = Notice("bad_request", "This server has several processes: connect to /ws/ROOM.")
MOVED = Notice(message="This room is in another process; connect again.")


class FrontEndpoint:
    """The ASGI application behind /ws/ROOM of a server with several processes."""

    def __init__(self, front: Front) -> None:
        self._front = front

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        await receive()  # websocket.connect
        address = scope["client"][0] if scope.get("client") else ""
        refusal = handshake_refusal(self._front.settings, scope)
        if refusal is None and (sentence := self._front.admission.try_socket(address)):
            self._front.admission.refusals["socket"] += 1
            refusal = 503, sentence
        if refusal is not None:
            await refuse(send, *refusal)
            return
        room_id = scope.get("path_params", {}).get("room", "")
        if not room_id:
            await _turn_away(send, m.CLOSE_BAD_MESSAGE, NO_ROOM_NAMED)
            return
        wire = cast(GameWebSocketProtocol, scope["extensions"][WIRE])
        try:
            await self._connect(wire, self._front.link_of(room_id), send)
        except ProcessGone as error:
            await refuse(send, 503, str(error))

    async def _connect(self, wire: GameWebSocketProtocol, link: RoomLink, send: Send) -> None:
        """Raises ProcessGone when the process is not there within a few seconds."""
        for _ in range(TRIES):
            await link.ready()
            try:
                handed_over = wire.hand_over(lambda descriptor, head: link.give(descriptor, PLAIN + head))
            except ProcessGone:  # it has just ended, and the front hears of it in a moment
                await asyncio.sleep(AGAIN_S)
                continue
            if not handed_over:
                self._front.expected.add(wire.client[0] if wire.client else "", link)
                await _turn_away(send, m.CLOSE_RETRY, MOVED)
            return
        raise ProcessGone("the process of this room has ended; try again in a moment")


async def _turn_away(send: Send, code: int, notice: Notice) -> None:
    """Close with a reason; browsers do not tell their pages why a handshake was refused."""
    await send({"type": "websocket.accept", "subprotocol": m.SUBPROTOCOL})
    await say_goodbye(send, CloseConnection(code, notice))
