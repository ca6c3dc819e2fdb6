"""Of every response: security headers, and pieces sent one by one; the limit on the size of request bodies."""

import logging
import re

import orjson

from movingout.server.api.errors import error_json
from movingout.server.connection.asgi import App, Message, Receive, Send
from movingout.server.connection.hosts import host_refusal
from movingout.server.connection.origin import header
from movingout.server.connection.security_headers import FIXED, NO_STORE, REFERRER
from movingout.server.settings import Settings

log = logging.getLogger(__name__)
_HOST = re.compile(r"[A-Za-z0-9.\-]+(:\d+)?|\[[0-9A-Fa-f:]+\](:\d+)?")
_LONGEST_HOST = 253 + len(":65535")  # characters of a name in DNS, and a port


def content_security_policy(host: str) -> str:
    """Everything from this origin only; sockets are listed because older browsers do not count them as 'self'."""
    sockets = f" ws://{host} wss://{host}" if len(host) <= _LONGEST_HOST and _HOST.fullmatch(host) else ""
    return (
        f"default-src 'self'; connect-src 'self'{sockets}; img-src 'self' data:; object-src 'none'; base-uri 'none'; "
        "form-action 'self'; frame-ancestors 'none'"
    )


class SecureHeaders:
    """ASGI middleware: the security headers on every HTTP response; `hsts` where https is for good.

    What does not say how long it may be kept is kept nowhere; what has a referrer policy of its own keeps that.
    """

    def __init__(self, app: App, hsts: bool = False) -> None:
        self._app = app
        self._hsts = hsts

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        fixed = (*FIXED, HSTS) if self._hsts and scope["scheme"] == "https" else FIXED
        policy = content_security_policy(header(scope["headers"], b"host")).encode("latin-1")

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                unsaid = [one for one in (NO_STORE, REFERRER) if not header(message["headers"], one[0])]
                message["headers"] = [*message["headers"], *fixed, *unsaid, (b"content-security-policy", policy)]
            await send(message)

        await self._app(scope, receive, send_with_headers)


HSTS = (b"strict-transport-security", b"max-age=31536000")


PIECE_BYTES = 16 * 1024


class InPieces:
    """ASGI middleware: hands a long body on in pieces, each when the connection has taken the one before.

    Of one long piece TLS would encrypt everything at once, and nobody would hear that its reader takes nothing.
    """

    def __init__(self, app: App) -> None:
        self._app = app

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        async def send_in_pieces(message: Message) -> None:
            body = message.get("body", b"")
            for end in range(PIECE_BYTES, len(body), PIECE_BYTES):
                await send({**message, "body": body[end - PIECE_BYTES : end], "more_body": True})
            if len(body) > PIECE_BYTES:
                message = {**message, "body": body[(len(body) - 1) // PIECE_BYTES * PIECE_BYTES :]}
            await send(message)

        await self._app(scope, receive, send_in_pieces if scope["type"] == "http" else send)


class HeadOfPages:
    """ASGI middleware: HEAD as GET, whose body Uvicorn leaves out; a stream of the API would go on for nobody."""

    def __init__(self, app: App) -> None:
        self._app = app

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and scope["method"] == "HEAD" and not scope["path"].startswith("/api/"):
            scope = {**scope, "method": "GET"}
        await self._app(scope, receive, send)


FORGOTTEN_PROXY = (
    "requests come through a proxy that no --proxy names: everybody behind it shares the limits of one address; "
    "name the proxy, as in --proxy 127.0.0.1"
)


class KnownHosts:
    """ASGI middleware: refuses requests for another site's name; websockets are refused at their handshake.

    Says once in the log that a proxy was forgotten, which the name need not tell: by default nginx sends its own.
    """

    def __init__(self, app: App, settings: Settings) -> None:
        self._app = app
        self._settings = settings
        self._tells_of_proxy = not settings.trusted_proxies

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if self._tells_of_proxy and scope["type"] == "http" and header(scope["headers"], b"x-forwarded-for"):
            self._tells_of_proxy = False
            log.warning(FORGOTTEN_PROXY)
        refusal = host_refusal(scope["headers"], self._settings) if scope["type"] == "http" else None
        if refusal is not None:
            status, sentence = refusal
            headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close")]
            await send({"type": "http.response.start", "status": status, "headers": headers})
            await send({"type": "http.response.body", "body": f"{sentence}\n".encode()})
            return
        await self._app(scope, receive, send)


class BodyTooLarge(Exception):
    """A request carries more than the limit."""


class BodyLimit:
    """ASGI middleware: refuses a body above the limit, whether declared in the header or streamed."""

    def __init__(self, app: App, limit: int) -> None:
        self._app = app
        self._limit = limit

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        announced = header(scope["headers"], b"content-length")
        if announced and int(announced) > self._limit:
            await _too_large(send, self._limit)
            return
        taken = 0

        async def receive_counted() -> Message:
            nonlocal taken
            message = await receive()
            taken += len(message.get("body", b""))
            if taken > self._limit:
                raise BodyTooLarge
            return message

        try:
            await self._app(scope, receive_counted, send)
        except BodyTooLarge:
            await _too_large(send, self._limit)


async def _too_large(send: Send, limit: int) -> None:
    body = orjson.dumps(error_json("too_large", f"a request carries at most {limit} bytes"))
    headers = [(b"content-type", b"application/json"), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": 413, "headers": headers})
    await send({"type": "http.response.body", "body": body})
