"""Decision traces for spectators who ask for them: their candidates or their plan, as server-sent events.

Costs nothing without viewers: the stream reads what the workers' answers carry for the recording anyway.
"""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from movingout.agents.decision_trace import shown_part
from movingout.server.agent_workers.pool import AgentSeat
from movingout.server.api.authentication import bearer, in_room
from movingout.server.api.errors import ApiError
from movingout.server.public_host import NoRoom, PublicHost
from movingout.server.rooms.room import Room

LOOK_S = 0.05  # half a tick
BEAT_S = 5.0
STREAMS = 30  # at the same time, of the whole server


def routes(host: PublicHost) -> APIRouter:
    """GET /api/rooms/{room}/thoughts."""
    router = APIRouter()
    open_streams: set[object] = set()

    @router.get("/api/rooms/{room_id}/thoughts")
    async def decision_traces(room_id: str, request: Request) -> StreamingResponse:
        if await in_room(host, room_id, _of_study) and not host.is_admin(bearer(request)):
            raise ApiError(403, "blinded", "What the partner thinks is not shown in a round of a study.")
        if len(open_streams) >= STREAMS:
            raise ApiError(503, "full", f"{STREAMS} people look into agents here already; try again later.")
        return StreamingResponse(stream(room_id), media_type="text/event-stream", headers={"cache-control": "no-store"})

    async def stream(room_id: str) -> AsyncIterator[str]:
        mark = object()
        open_streams.add(mark)
        try:
            yield ": open\n\n"
            seen: Seen = {}
            quiet_s = 0.0
            while not host.stopping:
                try:
                    traces, seen = await host.ask(room_id, newest, seen)
                except NoRoom:
                    return
                told = [
                    event for trace in traces for event in ("data: ", json.dumps(trace, separators=(",", ":")), "\n\n")
                ]
                quiet_s = 0.0 if told else quiet_s + LOOK_S
                if quiet_s >= BEAT_S:
                    told, quiet_s = [": beat\n\n"], 0.0
                if told:
                    yield "".join(told)
                await asyncio.sleep(LOOK_S)
        finally:
            open_streams.discard(mark)

    return router


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
