"""What is done before a request reaches its route."""

import asyncio
import logging

import pytest

from movingout.server.api.middleware import FORGOTTEN_PROXY, KnownHosts
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
