"""The web application of a study: its pages and routes in front of those of every server."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import JSONResponse, RedirectResponse
from starlette.responses import FileResponse

from server import pages
from server.app import assemble
from server.host import Host
from server.settings import Settings
from server.study import experimenter_api, participant_api
from server.study.caretaker import Caretaker
from server.study.dashboard import Dashboard
from server.study.experimenter import Experimenter
from server.study.journey import WrongAnswer
from server.study.reception import Reception
from server.study.running import RunningStudy
from server.study.views import Views
from study.errors import StoreError, StudyError
from study.folder import StudyFolder
from study.questionnaire import AnswerError

log = logging.getLogger(__name__)

NOT_SAVED = "This could not be saved at the moment. Nothing that was saved is lost; the experimenter has been told."
FAULT = "Something went wrong on the server. Please try again; the experimenter has been told."


def create_study_app(
    settings: Settings, folder: StudyFolder, file_text: str, needs_code: bool = False, simulated: bool = False
) -> FastAPI:
    """A server that runs one study; `app.state` has its `host`, `running`, `caretaker` and `reception`.

    Raises StudyError when the databases cannot be used, or when the study is not what it began with.
    """
    host = Host(settings)
    running = RunningStudy(folder, file_text, host, needs_code, simulated)
    caretaker, reception, views = Caretaker(running), Reception(running), Views(running)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        await running.start()
        caretaker.start()
        yield
        await host.suspend()
        await caretaker.stop()
        await running.stop()
        await host.stop()

    app = assemble(
        host,
        lifespan,
        _pages(),
        participant_api.routes(running, reception, views),
        experimenter_api.routes(running, Experimenter(running, reception), Dashboard(running, views)),
    )
    app.state.running, app.state.caretaker, app.state.reception = running, caretaker, reception
    _tell_errors(app, running)
    return app


def _pages() -> APIRouter:
    router = APIRouter(include_in_schema=False)

    @router.get("/")
    async def start(request: Request) -> RedirectResponse:
        query = f"?{request.url.query}" if request.url.query else ""
        return RedirectResponse(f"/study{query}")

    @router.get("/study")
    async def study() -> FileResponse:
        return pages.page("study.html")

    @router.get("/experimenter")
    async def experimenter() -> FileResponse:
        return pages.page("experimenter.html")

    return router


def _tell_errors(app: FastAPI, running: RunningStudy) -> None:
    def told(status: int, code: str, message: str) -> JSONResponse:
        return JSONResponse({"error": {"code": code, "message": message}}, status)

    @app.exception_handler(WrongAnswer)
    async def wrong_answer(request: Request, error: WrongAnswer) -> JSONResponse:
        return told(422, error.code, str(error))

    @app.exception_handler(AnswerError)
    async def answer_error(request: Request, error: AnswerError) -> JSONResponse:
        return told(422, "answer", str(error))

    @app.exception_handler(StoreError)
    async def store_error(request: Request, error: StoreError) -> JSONResponse:
        return told(507, "not_saved", NOT_SAVED)

    @app.exception_handler(StudyError)
    async def study_error(request: Request, error: StudyError) -> JSONResponse:
        return told(409, "study", str(error))

    @app.exception_handler(Exception)
    async def fault(request: Request, error: Exception) -> JSONResponse:
        running.alerts.raise_("fault", f"A request to {request.url.path} failed; the server's log says why.")
        return told(500, "fault", FAULT)
