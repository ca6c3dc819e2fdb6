"""The web application of a node: that of every server, and what the proxy asks it."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI

from movingout.server.app import assemble
from movingout.server.cluster.host import WORKS, ClusterHost
from movingout.server.cluster.node import ClusterNode
from movingout.server.cluster.node_calls import NodeCalls
from movingout.server.connection.asgi import App, Message, Receive, Send
from movingout.server.settings import Settings

CHECK = "/cluster/rooms/"  # + shard: whether its rooms are here, for health checks of a proxy


def create_cluster_app(settings: Settings) -> FastAPI:
    """The node as an ASGI application; `app.state.host` is its ClusterHost.

    Raises ClusterError when the database does not let this node in. Use outside of an event loop.
    """
    host = ClusterHost(settings)
    asyncio.run(host.check_cluster())

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await host.start()
        yield
        await host.stop()

    app = assemble(host, host.endpoint, lifespan)
    app.add_middleware(NodeCalls, host=host, run=host.node.who.run, secret=host.secret, works=WORKS)
    app.add_middleware(ShardCheck, node=host.node)
    return app


class ShardCheck:
    """ASGI middleware: answers the proxy before anything else does, because it asks for every shard each second."""

    def __init__(self, app: App, node: ClusterNode) -> None:
        self._app = app
        self._node = node

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or not scope["path"].startswith(CHECK):
            await self._app(scope, receive, send)
            return
        here = self._node.serves(scope["path"].removeprefix(CHECK))
        headers = [(b"content-type", b"text/plain"), (b"cache-control", b"no-store")]
        await send({"type": "http.response.start", "status": 200 if here else 404, "headers": headers})
        await send({"type": "http.response.body", "body": b"here\n" if here else b"elsewhere\n"})
