"""The web application of a study: its pages and routes, before those of every server."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import JSONResponse, RedirectResponse
from starlette.responses import FileResponse

from movingout.server.api import pages
from movingout.server.api.errors import error_json
from movingout.server.app import assemble
from movingout.server.host import Host
from movingout.server.notices import ErrorCode
from movingout.server.settings import Settings
from movingout.server.study.api import experimenter, participant
from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.experimenter_actions import ExperimenterActions
from movingout.server.study.monitor import StudyMonitor
from movingout.server.study.participant_actions import StepRefused
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.session_service import SessionService
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StoreError, StudyError
from movingout.study.questionnaire import AnswerError

log = logging.getLogger(__name__)

NOT_SAVED = "This could not be saved at the moment. Nothing that was saved is lost; the experimenter has been told."
FAULT = "Something went wrong on the server. Please try again; the experimenter has been told."


def create_study_app(
    settings: Settings, folder: StudyFolder, file_text: str, needs_code: bool = False, simulated: bool = False
) -> FastAPI:
    """A server that runs one study; `app.state` has its `host`, `running`, `monitor` and `session_service`.

    Raises StudyError when the databases cannot be used, or when the study is not what it began with.
    """
    host = Host(settings)
    running = RunningStudy(folder, file_text, host, needs_code=needs_code, simulated=simulated)
    monitor, session_service, views = StudyMonitor(running), SessionService(running), ParticipantViews(running)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        await running.start()
        monitor.start()
        yield
        await host.suspend()
        await monitor.stop()
        await running.stop()
        await host.stop()

    app = assemble(
        host,
        lifespan,
        _pages(),
        participant.routes(running, session_service, views),
        experimenter.routes(running, ExperimenterActions(running, session_service), Dashboard(running, views)),
    )
    app.state.running, app.state.monitor, app.state.session_service = running, monitor, session_service
    _add_error_handlers(app, running)
    return app


def _pages() -> APIRouter:
    router = APIRouter(include_in_schema=False)

    @router.get("/")
    async def start(request: Request) -> RedirectResponse:
        query = f"?{request.url.query}" if request.url.query else ""
        return RedirectResponse(f"/study{query}")

    @router.get("/study")
    async def study() -> FileResponse:
        return pages.page("study/study.html")

    @router.get("/experimenter")
    async def experimenter() -> FileResponse:
        return pages.page("experimenter/experimenter.html")

    return router


def _add_error_handlers(app: FastAPI, running: RunningStudy) -> None:
    def error_response(status: int, code: ErrorCode, message: str) -> JSONResponse:
        return JSONResponse(error_json(code, message), status)

    @app.exception_handler(StepRefused)
    async def wrong_answer(request: Request, error: StepRefused) -> JSONResponse:
        return error_response(422, error.code, str(error))

    @app.exception_handler(AnswerError)
    async def answer_error(request: Request, error: AnswerError) -> JSONResponse:
        return error_response(422, "answer", str(error))

    @app.exception_handler(StoreError)
    async def store_error(request: Request, error: StoreError) -> JSONResponse:
        return error_response(507, "not_saved", NOT_SAVED)

    @app.exception_handler(StudyError)
    async def study_error(request: Request, error: StudyError) -> JSONResponse:
        return error_response(409, "study", str(error))

    @app.exception_handler(Exception)
    async def fault(request: Request, error: Exception) -> JSONResponse:
        running.alerts.add("fault", "Something went wrong on the server; its log has the details.", request.url.path)
        return error_response(500, "fault", FAULT)
