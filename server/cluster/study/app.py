"""The web application of a node that serves a study: pages at every node, the study's API where the study is run."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace

from fastapi import FastAPI
from starlette.responses import JSONResponse
from starlette.routing import Route

from movingout.server.api.errors import error_json
from movingout.server.api.routes import shape_errors
from movingout.server.app import assemble
from movingout.server.cluster.app import ShardCheck
from movingout.server.cluster.host import WORKS
from movingout.server.cluster.node_calls import NodeCalls
from movingout.server.cluster.shards import STUDY
from movingout.server.cluster.study.host import StudyNodeHost
from movingout.server.cluster.study.room_works import WORKS as ROOM_CALLS
from movingout.server.connection.asgi import Message, Receive, Send
from movingout.server.settings import Settings
from movingout.server.study.api.app import add_study_errors, study_pages
from movingout.server.study.api.served_study import ServedStudy
from movingout.server.study.arrivals.admission import Admission
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StoreError

log = logging.getLogger(__name__)

ELSEWHERE = "The study is at another machine. It goes on in a few seconds."


class StudyOnThisNode:
    """The study, while this node runs it; an ASGI application for its API. Begun anew at each takeover."""

    def __init__(self, host: StudyNodeHost, folder: StudyFolder, file_text: str, admission: Admission) -> None:
        self._host, self._folder = host, folder
        self._file_text, self._admission = file_text, admission
        self._app: FastAPI | None = None
        self.served: ServedStudy | None = None
        self._ending: set[asyncio.Task[None]] = set()

    async def begin(self, fence: int) -> None:
        """Raises StudyError. Whoever ran it before has lost the right to write by the time this returns."""
        self.let_go()
        await self.end()
        folder = replace(self._folder, fence=fence)
        served = await asyncio.to_thread(self._open, folder)
        self.served = served
        await served.start()
        self._app = self._api(served)

    def _open(self, folder: StudyFolder) -> ServedStudy:
        return ServedStudy(self._host, folder, self._file_text, self._admission, self._host.in_charge)

    def _api(self, served: ServedStudy) -> FastAPI:
        app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        app.state.host = self._host
        shape_errors(app, self._host)
        for router in served.routers:
            app.include_router(router)
        add_study_errors(app, served.running)
        return app

    def let_go(self) -> None:
        self._app, served = None, self.served
        self.served = None
        if served is not None:
            served.detach()
            task = asyncio.create_task(self._stop(served))
            self._ending.add(task)
            task.add_done_callback(self._ending.discard)

    async def _stop(self, served: ServedStudy) -> None:
        try:
            await served.stop()
        except (StoreError, OSError) as error:  # the next node reads what is missing from databases and journals
            log.warning("the study was let go: %s", error)

    async def end(self) -> None:
        await asyncio.gather(*self._ending, return_exceptions=True)

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if self._app is not None and self._host.node.serves(STUDY):
            await self._app(scope, receive, send)
            return
        again = {"retry-after": "1", "cache-control": "no-store"}
        await JSONResponse(error_json("moving", ELSEWHERE), 503, again)(scope, receive, send)


def create_study_node(
    settings: Settings, folder: StudyFolder, file_text: str, admission: Admission, kind: str
) -> FastAPI:
    """The node as an ASGI application; `app.state` has its `host` and `study`.

    Raises ClusterError when the database does not let this node in. Use outside of an event loop.
    """
    host = StudyNodeHost(settings, kind)
    study = StudyOnThisNode(host, folder, file_text, admission)
    host.study = study
    asyncio.run(host.check_cluster())

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        yield
        await host.stop()

    app = assemble(host, host.endpoint, lifespan, study_pages())
    app.state.study = study
    for path in ("/api/study{rest:path}", "/api/experimenter{rest:path}"):
        app.router.routes.insert(0, Route(path, study))
    app.add_middleware(NodeCalls, host=host, run=host.node.who.run, secret=host.secret, works=(*WORKS, *ROOM_CALLS))
    app.add_middleware(ShardCheck, node=host.node)
    return app
