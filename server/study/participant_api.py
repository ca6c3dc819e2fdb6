"""The routes of a participant's page. Answers are JSON; errors are one sentence with a code for programs."""

import asyncio
from typing import Any

import msgspec
import orjson
from fastapi import APIRouter, Depends, Request
from fastapi.responses import StreamingResponse

from server.api_error import ApiError
from server.callers import address_of, bearer, body_of, own_page
from server.study.arrival import NotWelcome, read_arrival
from server.study.guest import Guest
from server.study.journey import Click, Journey, Said
from server.study.reception import Reception
from server.study.running import RunningStudy
from server.study.streams import event_stream, queued
from server.study.views import View, Views


class ArriveRequest(msgspec.Struct):
    """The body of POST /api/study/arrive."""

    parameters: dict[str, str] = {}
    language: str = ""
    beside: str = ""  # the secret of the first of two at one screen


class StopRequest(msgspec.Struct):
    """The body of POST /api/study/stop."""

    keep: bool


def routes(running: RunningStudy, reception: Reception, views: Views) -> APIRouter:
    router = APIRouter(prefix="/api/study")
    journey, host = Journey(running), running.host

    async def guest_of(request: Request) -> Guest | None:
        """Who asks; None for a page whose place was taken over by another one."""
        known = await reception.of_token(bearer(request))
        if known is None:
            raise ApiError(401, "no_participant", "This page is not known (any more); open your link again.")
        return None if known == "elsewhere" else known

    async def shown(guest: Guest | None) -> View:
        return views.elsewhere() if guest is None else await views.view(guest)

    @router.get("")
    async def study() -> dict[str, Any]:
        told = running.study
        return {
            "title": told.title.text(told.languages[0]),
            "languages": list(told.languages),
            "asks_code": running.needs_code,
            "group": told.group,
            "simulated": running.simulated,
        }

    @router.post("/arrive", dependencies=[Depends(own_page(host))])
    async def arrive(request: Request) -> dict[str, Any]:
        wanted, address = await body_of(request, ArriveRequest), address_of(request)
        if host.gate.locked(address, "seat"):
            raise ApiError(429, "locked", "Too many wrong codes from your address; wait a minute.")
        try:
            arrival = read_arrival(wanted.parameters, running.needs_code)
            token, guest = await reception.arrive(arrival, wanted.language, wanted.beside)
        except NotWelcome as error:
            if error.code == "code_unknown":
                host.gate.wrong_token(address, "seat")
            raise ApiError(403, error.code, str(error)) from None
        return {"token": token, "view": await views.view(guest)}

    @router.get("/view")
    async def view(request: Request, lang: str = "") -> dict[str, View]:
        guest = await guest_of(request)
        if guest is not None and lang:
            await journey.speak(guest, lang)
        return {"view": await shown(guest)}

    @router.post("/next")
    async def go_on(request: Request) -> dict[str, View]:
        guest, said = await guest_of(request), await body_of(request, Said)
        if guest is not None:
            await journey.go_on(guest, said)
        return {"view": await shown(guest)}

    @router.post("/answer")
    async def answer(request: Request) -> dict[str, bool]:
        guest, click = await guest_of(request), await body_of(request, Click)
        if guest is None:
            raise ApiError(409, "elsewhere", "The study was opened in another window; go on there.")
        await journey.answer(guest, click)
        return {"saved": True}

    @router.post("/decline")
    async def decline(request: Request) -> dict[str, View]:
        guest = await guest_of(request)
        if guest is not None:
            await journey.decline(guest)
        return {"view": await shown(guest)}

    @router.post("/stop")
    async def stop(request: Request) -> dict[str, View]:
        guest, wanted = await guest_of(request), await body_of(request, StopRequest)
        if guest is not None:
            await journey.stop(guest, wanted.keep)
        return {"view": await shown(guest)}

    @router.get("/events")
    async def events(request: Request) -> StreamingResponse:
        guest = await guest_of(request)
        queue: asyncio.Queue[str] = asyncio.Queue()
        if guest is None:
            queue.put_nowait(orjson.dumps({"view": views.elsewhere()}).decode())
            return event_stream(queued(host, queue, lambda: None))

        def push(news: dict[str, Any]) -> None:
            queue.put_nowait(orjson.dumps(news).decode())

        def close() -> None:
            guest.heard_at = running.now()
            if push in guest.pushes:
                guest.pushes.remove(push)

        guest.pushes.append(push)
        return event_stream(queued(host, queue, close))

    return router
