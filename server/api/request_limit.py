"""How many HTTP requests one address may make; a refusal costs next to nothing and closes the connection."""

import orjson

from movingout.server.api.errors import error_json
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.asgi import App, Message, Receive, Send

FILE_COST = 0.25  # of a request: files come from memory
TEXT = "Too many requests come from your address; wait a few seconds."
BODY = orjson.dumps(error_json("too_many_requests", TEXT))
HEADERS = ((b"content-type", b"application/json"), (b"retry-after", b"5"), (b"connection", b"close"))


class RequestLimit:
    """ASGI middleware: so many requests per address (or /64 network), in bursts."""

    def __init__(self, app: App, admission: AdmissionControl) -> None:
        self._app = app
        self._admission = admission

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and not self._allowed(scope):
            await send({"type": "http.response.start", "status": 429, "headers": [*HEADERS]})
            await send({"type": "http.response.body", "body": BODY})
            return
        await self._app(scope, receive, send)

    def _allowed(self, scope: Message) -> bool:
        address = scope["client"][0] if scope.get("client") else ""
        cost = 1.0 if scope["path"].startswith("/api/") else FILE_COST
        return self._admission.may_request(address, cost)
