"""The web application of one `Host`: pages, API and websocket."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI
from starlette.routing import WebSocketRoute
from starlette.types import Lifespan

from movingout.server.api import agent_debug, pages, routes
from movingout.server.api.middleware import BodyLimit, SecureHeaders
from movingout.server.host import Host
from movingout.server.settings import Settings


def create_app(settings: Settings) -> FastAPI:
    """The server as an ASGI application; `app.state.host` is its Host."""
    host = Host(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        yield
        await host.stop()

    return assemble(host, lifespan)


def assemble(host: Host, lifespan: Lifespan[FastAPI], *first: APIRouter) -> FastAPI:
    """The application of a host; routes in `first` take precedence over the usual pages."""
    app = FastAPI(title="Moving Out Live", lifespan=lifespan, docs_url=None, redoc_url=None, openapi_url=None)
    app.state.host = host
    for router in first:
        app.include_router(router)
    routes.install(app, host)
    app.include_router(pages.router)
    app.include_router(agent_debug.routes(host))
    app.mount("/static", pages.StaticModules(directory=pages.WEB))
    app.router.routes.append(WebSocketRoute("/ws", host.endpoint))
    app.add_middleware(BodyLimit, limit=host.settings.limits.body_bytes)
    app.add_middleware(SecureHeaders)
    return app
