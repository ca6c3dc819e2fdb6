"""Decision traces for spectators who ask for them: every decision with its candidates, as server-sent events.

Costs nothing without viewers: the stream reads what the workers' answers carry for the recording anyway.
"""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import StreamingResponse

from movingout.server.agent_workers.pool import AgentSeat
from movingout.server.api.authentication import bearer
from movingout.server.api.errors import ApiError
from movingout.server.host import Host
from movingout.server.rooms.room import Room

LOOK_S = 0.05  # half a tick
BEAT_S = 5.0
STREAMS = 30  # at the same time, of the whole server


def routes(host: Host) -> APIRouter:
    """GET /api/rooms/{room}/thoughts."""
    router = APIRouter()
    open_streams: set[object] = set()

    @router.get("/api/rooms/{room_id}/thoughts")
    async def decision_traces(room_id: str, request: Request) -> StreamingResponse:
        room = host.registry.rooms.get(room_id)
        if room is None:
            raise ApiError(404, "no_room", "There is no such game. It may be over.")
        if room.config.study and not host.is_admin(bearer(request)):
            raise ApiError(403, "blinded", "What the partner thinks is not shown in a round of a study.")
        if len(open_streams) >= STREAMS:
            raise ApiError(503, "full", f"{STREAMS} people look into agents here already; try again later.")
        return StreamingResponse(stream(room), media_type="text/event-stream", headers={"cache-control": "no-store"})

    async def stream(room: Room) -> AsyncIterator[str]:
        mark = object()
        open_streams.add(mark)
        try:
            yield ": open\n\n"
            seen: dict[int, tuple[int, int]] = {}
            quiet_s = 0.0
            while not host.stopping and host.registry.rooms.get(room.id) is room:
                told = [
                    event
                    for trace in newest(room, seen)
                    for event in ("data: ", json.dumps(trace, separators=(",", ":")), "\n\n")
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


def newest(room: Room, seen: dict[int, tuple[int, int]]) -> list[dict[str, Any]]:
    """Decisions with candidates that are not in `seen` (seat to player key and tick) yet; adds them to it."""
    found = []
    for seat in room.seats:
        player = seat.player
        if not isinstance(player, AgentSeat):
            continue
        tick, detail = player.decision_trace
        if "candidates" in detail and seen.get(seat.index) != (player.key, tick):
            seen[seat.index] = (player.key, tick)
            found.append({"seat": seat.index, "tick": tick, **detail})
    return found


def weighs(room: Room) -> bool:
    """Whether an agent here has compared candidates. Never told of a round of a study: it says who the partner is."""
    return not room.config.study and bool(newest(room, {}))
