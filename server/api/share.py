"""A picture or an animation of a finished round, for its players to send to others; drawn in the other process."""

from collections import OrderedDict
from functools import partial

from fastapi import APIRouter, Request
from fastapi.responses import Response

from movingout.recordings import RecordingError
from movingout.recordings.exports.share import SHARE_KINDS, ShareKind, share_bytes
from movingout.recordings.report.words import Words
from movingout.server.api.authentication import address_of, seat_of_token
from movingout.server.api.errors import ApiError, unreadable
from movingout.server.connection.admission import address_group
from movingout.server.public_host import PublicHost

KEPT = 32  # pictures, each well below a megabyte


def routes(host: PublicHost) -> APIRouter:
    """GET /api/rooms/{room}/rounds/{episode}.{png or gif}?language=de."""
    router = APIRouter()
    kept: OrderedDict[tuple[str, str, str], bytes] = OrderedDict()

    @router.get("/api/rooms/{room_id}/rounds/{episode_id}.{kind}")
    async def picture(room_id: str, episode_id: str, kind: str, request: Request, language: str = "en") -> Response:
        holder = await seat_of_token(host, room_id, request)
        if holder.study:
            raise ApiError(403, "blinded", "This is not shown in a round of a study.")
        if episode_id not in holder.recordings or kind not in SHARE_KINDS:
            raise ApiError(404, "no_recording", "There is no such round in this room.")
        await check_there(episode_id, request)  # who played may have asked for the deletion
        spoken = Words(language).language
        if (key := (episode_id, kind, spoken)) not in kept:
            kept[key] = await drawn(episode_id, kind, spoken, request)
            while len(kept) > KEPT:
                kept.popitem(last=False)
        headers = {"cache-control": "private, max-age=3600"}
        return Response(kept[key], media_type=f"image/{kind}", headers=headers)

    async def check_there(episode_id: str, request: Request) -> None:
        try:
            await host.recording_service.path(episode_id, address=address_group(address_of(request)))
        except RecordingError as error:
            raise unreadable(error, 404, "no_recording") from None

    async def drawn(episode_id: str, kind: ShareKind, language: str, request: Request) -> bytes:
        if not host.admission.may_draw(address_of(request)):
            raise ApiError(429, "too_many_pictures", "Many pictures were asked for; wait a minute.")
        try:
            work, address = partial(share_bytes, kind=kind, language=language), address_group(address_of(request))
            return await host.recording_service.read(episode_id, work, address=address)
        except RecordingError as error:
            raise unreadable(error, 404, "no_recording") from None

    return router
