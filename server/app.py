"""The web application of one `Host`: pages, API and websocket."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import APIRouter, FastAPI
from starlette.routing import WebSocketRoute
from starlette.types import Lifespan

from movingout.server.api import agent_debug, pages, routes
from movingout.server.api.middleware import BodyLimit, HeadOfPages, InPieces, KnownHosts, SecureHeaders
from movingout.server.api.request_limit import RequestLimit
from movingout.server.connection.asgi import App
from movingout.server.host import Host
from movingout.server.public_host import PublicHost
from movingout.server.settings import Settings


def create_app(settings: Settings) -> FastAPI:
    """The server as an ASGI application; `app.state.host` is its Host."""
    host = Host(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        yield
        await host.stop()

    return assemble(host, host.endpoint, lifespan)


def assemble(host: PublicHost, endpoint: App, lifespan: Lifespan[FastAPI], *first: APIRouter) -> FastAPI:
    """The application of a host, with `endpoint` for websockets; routes in `first` precede the usual pages."""
    app = FastAPI(title="Moving Out Live", lifespan=lifespan, docs_url=None, redoc_url=None, openapi_url=None)
    app.state.host = host
    for router in first:
        app.include_router(router)
    routes.install(app, host)
    app.include_router(pages.router)
    app.include_router(agent_debug.routes(host))
    app.mount("/static", pages.StaticModules())
    app.router.routes.append(WebSocketRoute("/ws", endpoint))
    app.router.routes.append(WebSocketRoute("/ws/{room}", endpoint))
    app.add_middleware(InPieces)
    app.add_middleware(HeadOfPages)
    app.add_middleware(BodyLimit, limit=host.settings.limits.body_bytes)
    app.add_middleware(RequestLimit, admission=host.admission)
    app.add_middleware(KnownHosts, settings=host.settings)
    # A certificate of one's own, which nobody vouches for, is not worth insisting on: only a proxy has another one.
    app.add_middleware(SecureHeaders, hsts=bool(host.settings.trusted_proxies))
    return app
