"""Requests that come to a process with rooms, and belong to the front."""

import asyncio
from typing import Any

import pytest

from movingout.server.connection.asgi import Message
from movingout.server.connection.origin import header
from movingout.server.processes.room_process import _to_the_front


def sent_to(path: str, raw_path: bytes, query: bytes = b"") -> str:
    """The address that a request is sent to."""
    told: list[Message] = []

    async def send(message: Message) -> None:
        told.append(message)

    async def receive() -> Any:
        raise AssertionError("its body is of no interest")

    scope = {"type": "http", "path": path, "raw_path": raw_path, "query_string": query}
    asyncio.run(_to_the_front(scope, receive, send))
    assert told[0]["status"] == 307
    return header(told[0]["headers"], b"location")


@pytest.mark.parametrize(
    ("path", "raw_path", "address"),
    [
        ("/api/maps", b"/api/maps", "/api/maps"),
        ("/api/maps/日本", b"/api/maps/%E6%97%A5%E6%9C%AC", "/api/maps/%E6%97%A5%E6%9C%AC"),
        ("/api/maps/ä", b"/api/maps/\xc3\xa4", "/api/maps/Ã¤"),
        ("/x\r\nset-cookie: a=b", b"/x%0d%0aset-cookie:%20a=b", "/x%0d%0aset-cookie:%20a=b"),
        ("//evil.example/x", b"//evil.example/x", "/evil.example/x"),
        ("/\\evil.example/x", b"/\\evil.example/x", "/evil.example/x"),
    ],
)
def test_a_request_is_sent_to_the_same_path_of_this_server(path: str, raw_path: bytes, address: str) -> None:
    assert sent_to(path, raw_path) == address
    assert sent_to(path, raw_path, b"a=1") == f"{address}?a=1"
