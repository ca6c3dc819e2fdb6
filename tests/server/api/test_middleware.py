"""What is done before a request reaches its route."""

import asyncio
import logging

import pytest

from movingout.server.api.middleware import FORGOTTEN_PROXY, PIECE_BYTES, InPieces, KnownHosts
from movingout.server.connection.asgi import Message, Receive, Send
from movingout.server.settings import Settings


async def _nothing(_scope: Message, _receive: Receive, _send: Send) -> None:
    """The application behind it."""


@pytest.mark.parametrize(("proxies", "told"), [((), 1), (("127.0.0.1",), 0)])
def test_a_forgotten_proxy_is_told_once(proxies: tuple[str, ...], told: int, caplog: pytest.LogCaptureFixture) -> None:
    """By default nginx sends a Host of its own, which is answered: nobody noticed that all shared one address."""
    known = KnownHosts(_nothing, Settings(trusted_proxies=proxies))

    async def receive() -> Message:
        return {}

    async def send(_message: Message) -> None:
        pass

    def asked(*more: tuple[bytes, bytes]) -> None:
        scope = {"type": "http", "headers": [(b"host", b"127.0.0.1:8000"), *more]}
        asyncio.run(known(scope, receive, send))

    with caplog.at_level(logging.WARNING):
        asked()
        assert not caplog.records
        for _ in range(3):
            asked((b"x-forwarded-for", b"203.0.113.9"))
    assert [record.getMessage() for record in caplog.records] == [FORGOTTEN_PROXY] * told


@pytest.mark.parametrize("more", [False, True])
@pytest.mark.parametrize("size", [0, 1, PIECE_BYTES, PIECE_BYTES + 1, 3 * PIECE_BYTES])
def test_a_long_body_is_sent_in_pieces(size: int, more: bool) -> None:
    body = bytes(index % 251 for index in range(size))
    sent: list[Message] = []

    async def answer(_scope: Message, _receive: Receive, send: Send) -> None:
        await send({"type": "http.response.start", "status": 200})
        await send({"type": "http.response.body", "body": body, "more_body": more})

    async def send(message: Message) -> None:
        sent.append(message)

    asyncio.run(InPieces(answer)({"type": "http"}, None, send))  # type: ignore[arg-type]
    start, *pieces = sent
    assert start == {"type": "http.response.start", "status": 200}
    assert b"".join(piece["body"] for piece in pieces) == body
    assert all(len(piece["body"]) <= PIECE_BYTES for piece in pieces)
    assert [piece["more_body"] for piece in pieces] == [True] * (len(pieces) - 1) + [more]
