"""The routes of a participant's page. Answers are JSON; errors are one sentence with a code for programs."""

import asyncio
from typing import Any

import msgspec
import orjson
from fastapi import APIRouter, Depends, Request
from fastapi.responses import StreamingResponse

from movingout.server.api.authentication import address_of, bearer, body_of, own_page
from movingout.server.api.errors import ApiError
from movingout.server.study.api.event_stream import event_stream, queued
from movingout.server.study.api.participant_view import View, Views
from movingout.server.study.arrival_link import NotWelcome, read_arrival
from movingout.server.study.participant_actions import Click, Journey, Said
from movingout.server.study.participant_session import Guest
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.session_service import Reception


class ArriveRequest(msgspec.Struct):
    """The body of POST /api/study/arrive."""

    parameters: dict[str, str] = {}
    language: str = ""
    beside: str = ""  # the secret of the first of two at one screen


class StopRequest(msgspec.Struct):
    """The body of POST /api/study/stop."""

    keep: bool


def routes(running: RunningStudy, reception: Reception, views: Views) -> APIRouter:
    api = ParticipantApi(running, reception, views)
    router = APIRouter(prefix="/api/study")
    for path, get in (("", api.study), ("/view", api.view), ("/events", api.events)):
        router.add_api_route(path, get, methods=["GET"])
    for path, post in (("/next", api.next), ("/answer", api.answer), ("/decline", api.decline), ("/stop", api.stop)):
        router.add_api_route(path, post, methods=["POST"])
    router.add_api_route("/arrive", api.arrive, methods=["POST"], dependencies=[Depends(own_page(running.host))])
    return router


class ParticipantApi:
    """What a participant's page may ask for."""

    def __init__(self, running: RunningStudy, reception: Reception, views: Views) -> None:
        self._running = running
        self._reception = reception
        self._views = views
        self._journey = Journey(running)

    async def study(self) -> dict[str, Any]:
        told = self._running.study
        return {
            "title": told.title.text(told.languages[0]),
            "languages": list(told.languages),
            "asks_code": self._running.needs_code,
            "group": told.group,
            "simulated": self._running.simulated,
        }

    async def arrive(self, request: Request) -> dict[str, Any]:
        gate, running = self._running.host.gate, self._running
        wanted, address = await body_of(request, ArriveRequest), address_of(request)
        if gate.locked(address, "seat"):
            raise ApiError(429, "locked", "Too many wrong codes from your address; wait a minute.")
        try:
            arrival = read_arrival(wanted.parameters, running.needs_code)
            token, guest = await self._reception.arrive(arrival, wanted.language, wanted.beside)
        except NotWelcome as error:
            if error.code == "code_unknown":
                gate.wrong_token(address, "seat")
            raise ApiError(403, error.code, str(error)) from None
        return {"token": token, "view": await self._views.view(guest)}

    async def view(self, request: Request, lang: str = "") -> dict[str, View]:
        guest = await self._guest(request)
        if guest is not None and lang:
            await self._journey.speak(guest, lang)
        return await self._shown(guest)

    async def next(self, request: Request) -> dict[str, View]:
        guest, said = await self._guest(request), await body_of(request, Said)
        if guest is not None:
            await self._journey.go_on(guest, said)
        return await self._shown(guest)

    async def answer(self, request: Request) -> dict[str, bool]:
        guest, click = await self._guest(request), await body_of(request, Click)
        if guest is None:
            raise ApiError(409, "elsewhere", "The study was opened in another window; go on there.")
        await self._journey.answer(guest, click)
        return {"saved": True}

    async def decline(self, request: Request) -> dict[str, View]:
        guest = await self._guest(request)
        if guest is not None:
            await self._journey.decline(guest)
        return await self._shown(guest)

    async def stop(self, request: Request) -> dict[str, View]:
        guest, wanted = await self._guest(request), await body_of(request, StopRequest)
        if guest is not None:
            await self._journey.stop(guest, wanted.keep)
        return await self._shown(guest)

    async def events(self, request: Request) -> StreamingResponse:
        """The participant's news, for as long as the page is open."""
        guest, host = await self._guest(request), self._running.host
        queue: asyncio.Queue[str] = asyncio.Queue()
        if guest is None:
            queue.put_nowait(orjson.dumps({"view": self._views.elsewhere()}).decode())
            return event_stream(queued(host, queue, lambda: None))

        def push(news: dict[str, Any]) -> None:
            queue.put_nowait(orjson.dumps(news).decode())

        def close() -> None:
            guest.heard_at = self._running.now()
            if push in guest.pushes:
                guest.pushes.remove(push)

        guest.pushes.append(push)
        return event_stream(queued(host, queue, close))

    async def _guest(self, request: Request) -> Guest | None:
        """Who asks; None for a page whose place was taken over by another one."""
        known = await self._reception.of_token(bearer(request))
        if known is None:
            raise ApiError(401, "no_participant", "This page is not known (any more); open your link again.")
        return None if known == "elsewhere" else known

    async def _shown(self, guest: Guest | None) -> dict[str, View]:
        return {"view": self._views.elsewhere() if guest is None else await self._views.view(guest)}
