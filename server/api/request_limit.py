"""How many HTTP requests one address may make; a refusal costs next to nothing and closes the connection."""

import orjson

from movingout.server.api.errors import error_json
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.asgi import App, Message, Receive, Send, refuse

FILE_COST = 0.25  # of a request: files come from memory
TEXT = "Too many requests come from your address; wait a few seconds."
BODY = orjson.dumps(error_json("too_many_requests", TEXT))
HEADERS = ((b"content-type", b"application/json"), (b"retry-after", b"5"), (b"connection", b"close"))


class RequestLimit:
    """ASGI middleware: so many requests per address (or /64 network), in bursts, and so many answers at once.

    The handshake of a websocket is a request, too; open ones are counted elsewhere.
    """

    def __init__(self, app: App, admission: AdmissionControl) -> None:
        self._app = app
        self._admission = admission

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        address = scope["client"][0] if scope.get("client") else ""
        if scope["type"] == "websocket" and not self._admission.may_request(address, 1.0):
            await receive()  # websocket.connect
            await refuse(send, 429, TEXT)
        elif scope["type"] != "http":
            await self._app(scope, receive, send)
        elif not (self._admission.may_request(address, _cost(scope)) and self._admission.begin_answer(address)):
            await send({"type": "http.response.start", "status": 429, "headers": [*HEADERS]})
            await send({"type": "http.response.body", "body": BODY})
        else:
            try:
                await self._app(scope, receive, send)
            finally:
                self._admission.end_answer(address)


def _cost(scope: Message) -> float:
    return 1.0 if scope["path"].startswith("/api/") else FILE_COST
