"""The routes of a participant's page. Responses are JSON; errors have a code and a sentence."""

import asyncio
import time
from typing import Any

import msgspec
import orjson
from fastapi import APIRouter, Depends, Request
from fastapi.responses import StreamingResponse

from movingout.server.api.authentication import address_of, bearer, body_of, limit_answers, own_page
from movingout.server.api.errors import ApiError
from movingout.server.connection.admission import address_group
from movingout.server.study.api.event_stream import EventQueue, OpenStreams, event_stream, queued_events
from movingout.server.study.api.participant_view import ParticipantViews, View
from movingout.server.study.arrivals.arrival_link import Arrival, ArrivalRefused, read_arrival
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.participant_actions import ParticipantActions, StepRequest, StudyAnswerRequest
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy

AT_ONE_SCREEN = 2  # people, and tokens that a browser has from before


class ArriveRequest(msgspec.Struct):
    """The body of POST /api/study/arrive."""

    parameters: dict[str, str] = {}
    language: str = ""
    beside: str = ""  # the token of the first of two at one screen
    known: list[str] = []  # the tokens that this browser has from before


class StopRequest(msgspec.Struct):
    """The body of POST /api/study/stop."""

    keep: bool


def routes(running: RunningStudy, session_service: SessionService, views: ParticipantViews) -> APIRouter:
    api = ParticipantApi(running, session_service, views)
    router = APIRouter(prefix="/api/study")
    for path, get in (("", api.study), ("/view", api.view), ("/events", api.events)):
        router.add_api_route(path, get, methods=["GET"])
    for path, post in (("/next", api.next), ("/answer", api.answer), ("/decline", api.decline), ("/stop", api.stop)):
        router.add_api_route(path, post, methods=["POST"])
    router.add_api_route("/arrive", api.arrive, methods=["POST"], dependencies=[Depends(own_page(running.host))])
    return router


class ParticipantApi:
    """The requests of participants' pages. They raise ApiError for a page that is not known, and for too many."""

    def __init__(self, running: RunningStudy, session_service: SessionService, views: ParticipantViews) -> None:
        self._running = running
        self._session_service = session_service
        self._views = views
        self._actions = ParticipantActions(running)
        self._streams = OpenStreams()

    async def study(self) -> dict[str, Any]:
        study = self._running.study
        return {
            "title": study.title.text(study.languages[0]),
            "titles": {language: study.title.text(language) for language in study.languages},
            "languages": list(study.languages),
            "asks_code": self._running.admission.needs_code,
            "group": study.group,
            "one_screen": study.group == 2 and study.pairing.one_screen == "on",
            "pays": study.pay is not None,
            "simulated": self._running.admission.simulated,
        }

    async def arrive(self, request: Request) -> dict[str, Any]:
        gate, running = self._running.host.admission, self._running
        codes, signed = running.admission.needs_code, running.admission.needs_signature
        wanted, address = await body_of(request, ArriveRequest), address_of(request)
        if not gate.may_arrive(address):
            raise _too_many()
        known = wanted.known[:AT_ONE_SCREEN]
        self._limit_unknown(address, *known, *([wanted.beside] if wanted.beside else []))
        try:
            arrival = await self._guest(wanted) or read_arrival(
                wanted.parameters, codes, running.signer, needs_signature=signed
            )
            group = address_group(address)
            done = await self._session_service.arrive(arrival, wanted.language, wanted.beside, known, group)
        except ArrivalRefused as error:
            if error.code == "code_unknown" and await gate.guesses_too_often(address, "seat"):
                raise ApiError(429, "locked", "Too many wrong codes from your address; wait a minute.") from None
            raise ApiError(403, error.code, str(error)) from None
        return {
            "token": done.token,
            **await self._shown(done.session),
            "replaces": done.replaces,
            "was_here": done.was_here,
        }

    async def _guest(self, wanted: ArriveRequest) -> Arrival | None:
        """The second person at one screen, who has no link, where only links and codes of the experimenter admit."""
        admission = self._running.admission
        invites = admission.needs_signature and not admission.needs_code
        if not invites or not wanted.beside or wanted.parameters:
            return None
        return await self._session_service.arrival_beside(wanted.beside)

    async def view(self, request: Request, lang: str = "") -> dict[str, View]:
        session = await self._session(request)
        if session is not None and lang and lang != session.record.language:
            self._limit_changes(session)
            await self._actions.set_language(session, lang)
        return await self._shown(session)

    async def next(self, request: Request) -> dict[str, View]:
        session, done = await self._session(request), await body_of(request, StepRequest)
        gate = self._running.host.admission
        if session is not None:
            self._limit_changes(session)
            address = address_of(request)
            if not await self._actions.complete_step(session, done, lambda: gate.may_consent(address)):
                raise _too_many()
        return await self._shown(session)

    async def answer(self, request: Request) -> dict[str, bool]:
        session, given = await self._session(request), await body_of(request, StudyAnswerRequest)
        if session is None:
            raise ApiError(409, "elsewhere", "The study was opened in another window; go on there.")
        if not self._running.host.admission.may_save_answer(session.pid):
            raise _too_often()
        await limit_answers(self._running.host, request)
        await self._actions.answer(session, given)
        return {"saved": True}

    async def decline(self, request: Request) -> dict[str, View]:
        session = await self._session(request)
        if session is not None:
            self._limit_changes(session)
            await self._actions.decline(session)
        return await self._shown(session)

    async def stop(self, request: Request) -> dict[str, View]:
        session, wanted = await self._session(request), await body_of(request, StopRequest)
        if session is not None:
            self._limit_changes(session)
            await self._actions.stop(session, wanted.keep)
        return await self._shown(session)

    async def events(self, request: Request) -> StreamingResponse:
        """The participant's event stream, for as long as the page is open."""
        session, running = await self._session(request), self._running
        queue: EventQueue = asyncio.Queue()
        self._streams.opened(bearer(request), queue)
        if session is None:
            queue.put_nowait(orjson.dumps({"view": self._views.elsewhere()}).decode())
            return event_stream(queued_events(running, queue, lambda: self._streams.closed(bearer(request), queue)))

        def push(news: dict[str, Any]) -> None:
            queue.put_nowait(orjson.dumps(news).decode())

        def close() -> None:
            self._streams.closed(bearer(request), queue)
            session.seen(time.monotonic(), running.progress.is_paused(session))
            if push in session.listeners:
                session.listeners.remove(push)

        session.listeners.append(push)
        return event_stream(queued_events(running, queue, close))

    async def _session(self, request: Request) -> ParticipantSession | None:
        """The participant of a request; None for a page that was superseded by another one."""
        token = bearer(request)
        self._limit_unknown(address_of(request), token)
        known = await self._session_service.of_token(token)
        if known is None:
            raise ApiError(401, "no_participant", "This page is not known (any more); open your link again.")
        return None if known == "elsewhere" else known

    def _limit_unknown(self, address: str, *tokens: str) -> None:
        """Each of these tokens that is not remembered is looked up in the database. Raises ApiError."""
        for token in tokens:
            if not (self._session_service.remembers(token) or self._running.host.admission.may_try_token(address)):
                text = "Too many requests come from your address; wait a few seconds."
                raise ApiError(429, "too_many_requests", text, retry_s=5)

    def _limit_changes(self, session: ParticipantSession) -> None:
        """Changes are made one after another: nobody keeps all others waiting. Raises ApiError."""
        if not self._running.host.admission.may_change(session.pid):
            raise _too_often()

    async def _shown(self, session: ParticipantSession | None) -> dict[str, View]:
        if session is None:
            return {"view": self._views.elsewhere()}
        await self._actions.skip_unplayable(session)
        return {"view": await self._views.view(session)}


def _too_many() -> ApiError:
    text = "Many people are opening this study from your network; wait a minute, then try again."
    return ApiError(429, "too_many_arrivals", text)


def _too_often() -> ApiError:
    return ApiError(429, "too_many_requests", "Too many requests from this page; wait a second.", retry_s=1)
