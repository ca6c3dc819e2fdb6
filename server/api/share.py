"""A picture or an animation of a finished round, for its players to send to others; drawn in the other process."""

from collections import OrderedDict
from functools import partial

from fastapi import APIRouter, Request
from fastapi.responses import Response

from movingout.recordings import RecordingError
from movingout.recordings.exports.share import SHARE_KINDS, ShareKind, share_bytes
from movingout.server.api.authentication import address_of, room_of, seat_of_token
from movingout.server.api.errors import ApiError
from movingout.server.host import Host

KEPT = 32  # pictures, each well below a megabyte


def routes(host: Host) -> APIRouter:
    """GET /api/rooms/{room}/rounds/{episode}.{png or gif}."""
    router = APIRouter()
    kept: OrderedDict[tuple[str, str], bytes] = OrderedDict()

    @router.get("/api/rooms/{room_id}/rounds/{episode_id}.{kind}")
    async def picture(room_id: str, episode_id: str, kind: str, request: Request) -> Response:
        seat_of_token(host, room_id, request)
        room = room_of(host, room_id)
        if room.config.study:
            raise ApiError(403, "blinded", "This is not shown in a round of a study.")
        played = {result.recording for result in room.series.results}
        if not episode_id or episode_id not in played or kind not in SHARE_KINDS:
            raise ApiError(404, "no_recording", "There is no such round in this room.")
        if (episode_id, kind) not in kept:
            kept[episode_id, kind] = await drawn(episode_id, kind, request)
            while len(kept) > KEPT:
                kept.popitem(last=False)
        headers = {"cache-control": "private, max-age=3600"}
        return Response(kept[episode_id, kind], media_type=f"image/{kind}", headers=headers)

    async def drawn(episode_id: str, kind: ShareKind, request: Request) -> bytes:
        if not host.admission.may_draw(address_of(request)):
            raise ApiError(429, "too_many_pictures", "Many pictures were asked for; wait a minute.")
        try:
            return await host.recording_service.read(episode_id, partial(share_bytes, kind=kind))
        except RecordingError as error:
            raise ApiError(404, "no_recording", str(error)) from None

    return router
