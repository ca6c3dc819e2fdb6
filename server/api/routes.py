"""The HTTP API: maps, rooms, questionnaire, recordings, administration. Responses are JSON."""

import asyncio
import io
from functools import lru_cache
from typing import Any

import msgspec
import segno
from fastapi import APIRouter, Depends, FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, JSONResponse, Response

from movingout.recordings import RecordingError
from movingout.server import messages as m
from movingout.server.api import agent_debug, findings, pages, share
from movingout.server.api.authentication import (
    address_of,
    admin,
    bearer,
    body_of,
    close_room,
    close_rooms_beside,
    in_room,
    limit_answers,
    limit_replays,
    own_page,
    seat_of_token,
)
from movingout.server.api.errors import ApiError, error_json, unreadable
from movingout.server.api.health import health_routes
from movingout.server.api.map_routes import map_routes
from movingout.server.api.offered_agents import OfferedAgents
from movingout.server.api.room_places import RoomPlaces
from movingout.server.api.room_requests import RoomRequest, open_room
from movingout.server.connection.admission import address_group
from movingout.server.notices import Notice
from movingout.server.own_maps.solving import TooSlow
from movingout.server.own_maps.workers import Busy as MapsBusy
from movingout.server.persistence.answer_log import TooManyAnswers
from movingout.server.persistence.recording_service import ReplayFiles
from movingout.server.persistence.work_process import ReadersBusy
from movingout.server.public_host import Away, PublicHost
from movingout.server.rooms.room import Room
from movingout.study.design.instruments import instrument
from movingout.study.questionnaire import PAPER, AnswerError

CLOSED_BY_OPERATOR = Notice("closed_by_operator", "This room was closed by the person who runs the server.")

REFUSED = (401, 403, 429, 503, 507)  # answers that are counted by their code


class AnswerRequest(msgspec.Struct, forbid_unknown_fields=True):
    """The body of POST /api/rooms/{room}/answers."""

    question: str
    value: int
    text: str = ""
    elapsed_ms: float = 0.0


def install(app: FastAPI, host: PublicHost) -> None:
    """Add the routes and the shape of errors."""
    shape_errors(app, host)
    app.include_router(health_routes(host))
    app.include_router(_play_routes(host))
    app.include_router(map_routes(host))
    app.include_router(_answer_routes(host))
    app.include_router(_recording_routes(host))
    app.include_router(findings.routes(host))
    app.include_router(share.routes(host))
    app.include_router(_admin_routes(host))


def shape_errors(app: FastAPI, host: PublicHost) -> None:
    """Give every refusal as JSON with a code, and the page for unknown addresses to browsers."""

    @app.exception_handler(ApiError)
    async def api_error(request: Request, error: ApiError) -> JSONResponse:
        if error.status in REFUSED:
            host.admission.refusals[error.code] += 1
        return JSONResponse(error.as_json(), error.status, error.headers)

    @app.exception_handler(Away)
    async def away(request: Request, error: Away) -> JSONResponse:
        return JSONResponse(error_json(error.code, str(error)), 503)

    @app.exception_handler(ReadersBusy)
    async def busy(request: Request, error: ReadersBusy) -> JSONResponse:
        return await api_error(request, unreadable(error, 503, "readers_busy"))

    @app.exception_handler(MapsBusy)
    @app.exception_handler(TooSlow)
    async def maps_busy(request: Request, error: Exception) -> JSONResponse:
        return await api_error(request, ApiError(503, "map_busy", f"This map cannot be had now: {error}.", retry_s=10))

    @app.exception_handler(404)
    async def not_found(request: Request, error: Exception) -> Response:
        if not request.url.path.startswith(("/api/", "/static/")):
            return pages.missing()
        return JSONResponse(error_json("not_found", "There is nothing at this address."), 404)

    @app.exception_handler(405)
    async def wrong_method(request: Request, error: Exception) -> Response:
        text = f"This address does not answer to {request.method}."
        return JSONResponse(error_json("bad_request", text), 405, getattr(error, "headers", None))

    @app.exception_handler(RequestValidationError)
    async def wrong_parameters(request: Request, error: RequestValidationError) -> JSONResponse:
        wrong = ", ".join(sorted({str(one["loc"][-1]) for one in error.errors()}))
        return JSONResponse(error_json("bad_request", f"Missing or wrong in this address: {wrong}."), 422)


# ---- rooms ----------------------------------------------------------------------------------------------------


def _play_routes(host: PublicHost) -> APIRouter:
    router = APIRouter()

    offered = OfferedAgents(host.settings)

    @router.get("/api/agents")
    async def agents() -> Response:
        return Response(offered.document(), media_type="application/json")

    @router.post("/api/rooms", dependencies=[Depends(own_page(host))])
    async def new_room(request: Request) -> dict[str, Any]:
        if not host.settings.lobby and not host.is_admin(bearer(request)):
            raise ApiError(403, "study", "This server runs a study, which opens its rooms by itself.")
        address = "" if host.is_admin(bearer(request)) else address_of(request)
        wanted = await body_of(request, RoomRequest)
        if not address:
            return await open_room(host, wanted, address)
        if refusal := await RoomPlaces(host).begin_opening(address):
            raise ApiError(429, refusal.code, refusal.message, **refusal.values)
        try:
            return await open_room(host, wanted, address)
        finally:
            host.admission.opening_ended(address)

    @router.get("/api/rooms/{room_id}")
    async def room(room_id: str) -> dict[str, Any]:
        return await in_room(host, room_id, _room_view)

    @router.get("/api/rooms/{room_id}/qr.svg")
    async def qr(room_id: str, request: Request) -> Response:
        address = str(request.base_url).rstrip("/") + f"/play/{await in_room(host, room_id, _id)}"
        return Response(_qr_code(address), media_type="image/svg+xml", headers={"cache-control": "no-store"})

    return router


@lru_cache(256)
def _qr_code(address: str) -> bytes:
    picture = io.BytesIO()  # with its namespace: the page shows it in an <img>
    segno.make(address, error="m").save(picture, kind="svg", border=2, scale=4, dark="#000", light="#fff")
    return picture.getvalue()


def _id(room: Room) -> str:
    return room.id


def _room_view(room: Room) -> dict[str, Any]:
    state = room.state()
    return {
        "room": room.id,
        "phase": state.phase,
        "map": room.round.map.name,
        "study": bool(room.config.study),
        "seats": msgspec.to_builtins(state.seats),
        "weighs": agent_debug.weighs(room),
        "subprotocol": m.SUBPROTOCOL,  # a handshake that is refused tells a page nothing
    }


# ---- questionnaire --------------------------------------------------------------------------------------------


def _answer_routes(host: PublicHost) -> APIRouter:
    router = APIRouter()

    @router.get("/api/questionnaire")
    async def questionnaire(language: str = "en") -> dict[str, object]:
        return instrument(PAPER.id, language).as_json()

    @router.post("/api/rooms/{room_id}/answers")
    async def save_answer(room_id: str, request: Request) -> dict[str, bool]:
        holder = await seat_of_token(host, room_id, request)
        answer = await body_of(request, AnswerRequest)
        await limit_answers(host, request)
        if holder.study:  # it would be kept beside the study, where `forget` does not find it
            raise ApiError(409, "study", "This game belongs to a study, which asks its own questions.")
        try:
            PAPER.check_answer(answer.question, answer.value, answer.text)
        except AnswerError as error:
            raise ApiError(422, "answer", str(error)) from None
        try:
            given = answer.question, answer.value, answer.text, answer.elapsed_ms
            await asyncio.to_thread(host.answer_log.save, room_id, holder.seat, *given)
        except TooManyAnswers:
            raise ApiError(429, "too_many_requests", "Too much was answered at this seat.") from None
        except OSError as error:
            raise ApiError(507, "not_saved", f"The answer could not be saved: {error.strerror}.") from None
        return {"saved": True}

    @router.get("/api/rooms/{room_id}/answers")
    async def answers(room_id: str, request: Request) -> dict[str, Any]:
        holder = await seat_of_token(host, room_id, request)
        return {"answers": await asyncio.to_thread(host.answer_log.of, room_id, holder.seat)}

    return router


# ---- recordings -----------------------------------------------------------------------------------------------


async def _replay_of(host: PublicHost, episode_id: str, request: Request) -> ReplayFiles:
    """The replay of a recording. Raises ApiError if it is missing, or if this address asked for too many replays."""
    if not (host.recording_service.has_replay(episode_id) or host.is_admin(bearer(request))):
        limit_replays(host, address_of(request))
    try:
        return await host.recording_service.replay(episode_id, address_group(address_of(request)))
    except RecordingError as error:
        raise unreadable(error, 404, "no_recording") from None


def _recording_routes(host: PublicHost) -> APIRouter:
    blinded = [] if host.settings.lobby else [Depends(admin(host))]  # a recording says who the partner was
    router = APIRouter(dependencies=blinded)

    @router.get("/api/recordings", dependencies=[Depends(admin(host))])
    async def recordings() -> Response:
        try:
            document = await host.recording_service.listing()
        except RecordingError as error:
            raise unreadable(error, 503, "no_recordings") from None
        return Response(document, media_type="application/json")

    @router.get("/api/recordings/{episode_id}")
    async def recording(episode_id: str, request: Request) -> Response:
        return Response((await _replay_of(host, episode_id, request)).summary, media_type="application/json")

    @router.get("/api/recordings/{episode_id}/poses")
    async def poses(episode_id: str, request: Request) -> Response:
        return Response((await _replay_of(host, episode_id, request)).poses, media_type="application/octet-stream")

    @router.get("/api/recordings/{episode_id}/thoughts")
    async def decision_traces(episode_id: str, request: Request) -> Response:
        return Response((await _replay_of(host, episode_id, request)).decision_traces, media_type="application/json")

    @router.get("/api/recordings/{episode_id}/file")
    async def file(episode_id: str, request: Request) -> Response:
        if not host.is_admin(bearer(request)):
            limit_replays(host, address_of(request))
        try:
            path = await host.recording_service.path(episode_id, address=address_group(address_of(request)))
        except RecordingError as error:
            raise unreadable(error, 404, "no_recording") from None
        return FileResponse(path, media_type="application/octet-stream", filename=path.name)

    return router


# ---- administration -------------------------------------------------------------------------------------------


def _admin_routes(host: PublicHost) -> APIRouter:
    router = APIRouter(prefix="/api/admin", dependencies=[Depends(admin(host))])

    @router.get("/state")
    async def state() -> dict[str, Any]:
        return await host.report()

    @router.post("/rooms/{room_id}/close")
    async def close(room_id: str) -> dict[str, bool]:
        await close_room(host, room_id, m.CLOSE_KICKED, CLOSED_BY_OPERATOR)
        return {"closed": True}

    @router.post("/rooms/{room_id}/close-address")
    async def close_address(room_id: str) -> dict[str, int]:
        return {"closed": await close_rooms_beside(host, room_id, m.CLOSE_KICKED, CLOSED_BY_OPERATOR)}

    @router.post("/measurements/reset")
    async def reset() -> dict[str, bool]:
        await host.reset_measurements()
        return {"reset": True}

    return router
