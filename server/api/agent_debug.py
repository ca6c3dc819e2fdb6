"""Decision traces for spectators who ask for them: their candidates or their plan, as server-sent events.

Costs nothing without viewers: the stream reads what the workers' answers carry for the recording anyway.
"""

import asyncio
import json
from collections import Counter
from collections.abc import AsyncIterator, Callable
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from movingout.agents.decision_trace import shown_part
from movingout.server.agent_workers.agent_seat import AgentSeat
from movingout.server.api.authentication import address_of, bearer, in_room
from movingout.server.api.errors import ApiError
from movingout.server.connection.admission import address_group
from movingout.server.public_host import NoRoom, PublicHost
from movingout.server.rooms.room import Room

LOOK_S = 0.05  # half a tick
BEAT_S = 5.0
STREAMS = 30  # at the same time, of the whole server
STREAMS_OF_ADDRESS = 6


class AgentViews:
    """How many there are, by address group."""

    def __init__(self) -> None:
        self._of: Counter[str] = Counter()

    def take(self, group: str) -> None:
        """Count one more, which is to be given back. Raises ApiError when it would be one too many."""
        if self._of[group] >= STREAMS_OF_ADDRESS:
            text = f"{STREAMS_OF_ADDRESS} people at your address look into agents here already; try again later."
            raise ApiError(503, "full", text)
        if self._of.total() >= STREAMS:
            raise ApiError(503, "full", f"{STREAMS} people look into agents here already; try again later.")
        self._of[group] += 1

    def give_back(self, group: str) -> None:
        self._of[group] -= 1
        if not self._of[group]:
            del self._of[group]


class _CountedStream(StreamingResponse):
    """Counted since it was admitted, not since its first byte: many may be asked for in the same moment."""

    def __init__(self, content: AsyncIterator[str], at_end: Callable[[], None]) -> None:
        super().__init__(content, media_type="text/event-stream", headers={"cache-control": "no-store"})
        self._at_end = at_end

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._at_end()


def routes(host: PublicHost) -> APIRouter:
    """GET /api/rooms/{room}/thoughts."""
    router = APIRouter()
    streams = AgentViews()

    @router.get("/api/rooms/{room_id}/thoughts")
    async def decision_traces(room_id: str, request: Request) -> StreamingResponse:
        if await in_room(host, room_id, _of_study) and not host.is_admin(bearer(request)):
            raise ApiError(403, "blinded", "What the partner thinks is not shown in a round of a study.")
        group = address_group(address_of(request))
        streams.take(group)
        return _CountedStream(_stream(host, room_id), lambda: streams.give_back(group))

    return router


async def _stream(host: PublicHost, room_id: str) -> AsyncIterator[str]:
    yield ": open\n\n"
    seen: Seen = {}
    quiet_s = 0.0
    while not host.stopping:
        try:
            traces, seen = await host.ask(room_id, newest, seen)
        except NoRoom:
            return
        told = [event for trace in traces for event in ("data: ", json.dumps(trace, separators=(",", ":")), "\n\n")]
        quiet_s = 0.0 if told else quiet_s + LOOK_S
        if quiet_s >= BEAT_S:
            told, quiet_s = [": beat\n\n"], 0.0
        if told:
            yield "".join(told)
        await asyncio.sleep(LOOK_S)


Seen = dict[int, tuple[int, int]]  # seat to player key and tick


def _of_study(room: Room) -> bool:
    return bool(room.config.study)


def newest(room: Room, seen: Seen) -> tuple[list[dict[str, Any]], Seen]:
    """Decisions with candidates or a plan in words that are not in `seen` yet, and `seen` with them."""
    found, seen = [], dict(seen)
    for seat in room.seats:
        player = seat.player
        if not isinstance(player, AgentSeat):
            continue
        tick, detail = player.decision_trace
        told = shown_part(detail)
        if told and seen.get(seat.index) != (player.key, tick):
            seen[seat.index] = (player.key, tick)
            found.append({"seat": seat.index, "tick": tick, **told})
    return found, seen


def weighs(room: Room) -> bool:
    """Whether an agent here has had candidates or a plan in this round, even if its newest decision has none.

    Never told of a round of a study: it says who the partner is.
    """
    players = [seat.player for seat in room.seats]
    return not room.config.study and any(isinstance(player, AgentSeat) and player.has_weighed for player in players)
