"""The web application of a study: its pages and routes, before those of every server."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import JSONResponse, RedirectResponse
from starlette.responses import Response

from movingout.server.api import pages
from movingout.server.api.errors import error_json
from movingout.server.app import assemble
from movingout.server.connection.asgi import App
from movingout.server.notices import ErrorCode
from movingout.server.public_host import PublicHost
from movingout.server.study.api.served_study import ServedStudy
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.participant_actions import StepRefused
from movingout.server.study.running_study import RunningStudy
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StoreError, StudyError
from movingout.study.questionnaire import AnswerError

log = logging.getLogger(__name__)

NOT_SAVED = "This could not be saved at the moment. Nothing that was saved is lost; the experimenter has been told."
FAULT = "Something went wrong on the server. Please try again; the experimenter has been told."


def create_study_app(
    host: PublicHost,
    endpoint: App,
    folder: StudyFolder,
    file_text: str,
    *,
    needs_code: bool = False,
    needs_signature: bool = False,
    any_device: bool = False,
    simulated: bool = False,
) -> FastAPI:
    """A server that runs one study; `app.state` has its `host`, `running`, `monitor` and `session_service`.

    `endpoint` is for the websockets of the host.

    Raises StudyError when the databases cannot be used, or when the study is not what it began with.
    """
    served = ServedStudy(
        host,
        folder,
        file_text,
        Admission(needs_code, needs_signature, any_device, simulated),
    )

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        await served.start()
        yield
        await host.suspend()
        await served.stop()
        await host.stop()

    app = assemble(host, endpoint, lifespan, study_pages(), *served.routers)
    app.state.running, app.state.monitor, app.state.session_service = (
        served.running,
        served.monitor,
        served.session_service,
    )
    add_study_errors(app, served.running)
    return app


def study_pages() -> APIRouter:
    router = APIRouter(include_in_schema=False)

    @router.get("/")
    async def start(request: Request) -> RedirectResponse:
        query = f"?{request.url.query}" if request.url.query else ""
        return RedirectResponse(f"/study{query}")

    @router.get("/study")
    async def study() -> Response:
        page = pages.page("study/study.html")
        page.headers["referrer-policy"] = "strict-origin"  # its address has who takes part, and a link's signature
        return page

    @router.get("/experimenter")
    async def experimenter() -> Response:
        return pages.page("experimenter/experimenter.html")

    return router


def add_study_errors(app: FastAPI, running: RunningStudy) -> None:
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
