"""An HTTP connection counts until it is gone, and has deadlines and limits for what it sends and takes."""

import asyncio
import contextlib
import socket
import ssl
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import pytest
from fastapi import FastAPI
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from movingout.server import uvicorn_server
from movingout.server.app import create_app
from movingout.server.connection.uvicorn_protocols.http_protocol import MOST_PIPELINED
from movingout.server.security.certificate import certificate_in
from movingout.server.settings import Settings
from tests.server.connection.uvicorn_protocols.support import CLOSE_FRAME, NO_JOIN, counts, read_until
from tests.server.live import WAIT_S, Live, handshake, limits, raw_socket, serve, wait_until

LONG = 3_000_000  # more bytes than both ends of a connection keep


def app_with_answers_of(size: int) -> Callable[[Settings], FastAPI]:
    def create(settings: Settings) -> FastAPI:
        app = create_app(settings)
        app.add_api_route("/long", lambda: Response(bytes(size) + b"the end"))
        app.router.routes.insert(0, app.router.routes.pop())
        return app

    return create


def test_over_tls_too_whoever_takes_nothing_of_a_long_answer_is_dropped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(uvicorn_server, "GOODBYE_S", 60.0)  # after an idle connection was closed
    certificate = certificate_in(tmp_path / "tls", "127.0.0.1")
    context = ssl.create_default_context(cafile=str(certificate.certificate))
    with serve(tmp_path, limits(unread_s=0.3), app_with_answers_of(LONG), certificate=certificate) as live:

        def asked() -> ssl.SSLSocket:
            client = context.wrap_socket(raw_socket(live), server_hostname="localhost")
            client.sendall(b"GET /long HTTP/1.1\r\nHost: localhost\r\n\r\n")
            return client

        with asked() as reader:
            while not reader.recv(1_000_000).endswith(b"the end"):
                pass
        with asked():
            wait_until(lambda: counts(live)._total == 1)
            wait_until(lambda: counts(live)._total == 0)


@pytest.mark.parametrize("after", [b"1\r\nx\r\n", b"\r\n"], ids=["a body that no route reads", "no request"])
def test_what_comes_after_the_head_of_a_request_has_an_end(live: Live, after: bytes) -> None:
    chunked = b"POST /healthz HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n"
    plain = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
    with raw_socket(live) as client:
        client.sendall(plain if after == b"\r\n" else chunked)
        read_until(client, b"\r\n\r\n")
        with pytest.raises(ConnectionError):
            for _ in range(100):
                client.sendall(after * (16_000 // len(after)))
                time.sleep(0.001)


def test_a_body_as_long_as_it_may_be_in_chunks_of_a_few_bytes_is_read(live: Live) -> None:
    with raw_socket(live) as client:
        client.sendall(b"POST /api/rooms HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n")
        client.sendall(b"10\r\n" + b" " * 16 + b"\r\n")
        client.sendall((b"10\r\n" + b" " * 16 + b"\r\n") * 1_000 + b"0\r\n\r\n")
        assert b" 422 " in read_until(client, b"\r\n")


def test_an_idle_connection_that_sends_what_is_no_request_has_a_deadline_again(tmp_path: Path) -> None:
    with serve(tmp_path, limits(header_s=0.3)) as live, raw_socket(live) as client:
        client.sendall(b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n")
        read_until(client, b"}")
        client.sendall(b"\r\n")
        wait_until(lambda: counts(live)._total == 0)


def test_a_websocket_on_a_connection_that_had_an_answer_before_has_no_deadline(tmp_path: Path) -> None:
    with serve(tmp_path, limits(header_s=0.3)) as live, raw_socket(live) as client:
        client.sendall(b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n")
        read_until(client, b"}")
        client.sendall(handshake())
        read_until(client, b"\r\n\r\n")
        time.sleep(0.6)
        client.sendall(NO_JOIN)
        read_until(client, CLOSE_FRAME)


@pytest.mark.parametrize("closes", [b"", b"Connection: close\r\n"], ids=["stays", "closes"])
def test_the_end_of_answers_that_waits_to_be_read_has_a_deadline_too(tmp_path: Path, closes: bytes) -> None:
    """It is less than what makes the transport say that it is full."""
    with serve(tmp_path, limits(unread_s=0.3), app_with_answers_of(20_000)) as live, socket.socket() as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.connect(("127.0.0.1", live.port))
        ask = b"GET /long HTTP/1.1\r\nHost: x\r\n"
        client.sendall((ask + b"\r\n") * 3 + ask + closes + b"\r\n")
        wait_until(lambda: counts(live)._total == 1)
        wait_until(lambda: counts(live)._total == 0)


def test_the_trailer_of_a_body_adds_no_header(tmp_path: Path) -> None:
    """A proxy sets its headers, and may pass on a trailer as it came: an address in it would be the proxy's word."""

    def create(settings: Settings) -> FastAPI:
        def caller(request: Request) -> str:
            return f"{request.client and request.client.host} {'secret' in request.headers} end"

        app = create_app(settings)
        app.add_api_route("/caller", caller, methods=["POST"])
        app.router.routes.insert(0, app.router.routes.pop())
        return app

    head = b"POST /caller HTTP/1.1\r\nHost: x\r\nX-Forwarded-For: 192.0.2.1\r\nTransfer-Encoding: chunked\r\n\r\n"
    with serve(tmp_path, app_of=create, trusted_proxies=("127.0.0.1",)) as live, raw_socket(live) as client:
        client.sendall(head + b"1\r\nx\r\n0\r\nX-Forwarded-For: 198.51.100.1\r\nSecret: x\r\n\r\n")
        assert b"192.0.2.1 False end" in read_until(client, b" end")


STREAM = b"GET /stream HTTP/1.1\r\nHost: x\r\n\r\n"
PLAIN = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"


def app_with_stream(heard: list[str]) -> Callable[[Settings], FastAPI]:
    """An answer without end at /stream, which notes when it is told that its reader is gone."""

    async def parts() -> AsyncIterator[bytes]:
        try:
            yield b"begun"
            await asyncio.sleep(10 * WAIT_S)
        finally:
            heard.append("gone")

    async def stream() -> Response:
        return StreamingResponse(parts())

    def create(settings: Settings) -> FastAPI:
        app = create_app(settings)
        app.add_api_route("/stream", stream)
        app.router.routes.insert(0, app.router.routes.pop())
        return app

    return create


@pytest.mark.parametrize(
    ("behind", "stays"),
    [
        (b"", True),
        (PLAIN * MOST_PIPELINED, True),
        (PLAIN * (MOST_PIPELINED + 1), False),
        (handshake(), False),
        (PLAIN + handshake(), False),
    ],
    ids=["none", "some", "one too many", "a websocket", "a request and a websocket"],
)
def test_of_requests_behind_one_that_is_not_answered_a_few_may_wait(tmp_path: Path, behind: bytes, stays: bool) -> None:
    """The stream always hears that its reader is gone."""
    heard: list[str] = []
    with serve(tmp_path, app_of=app_with_stream(heard)) as live:
        with raw_socket(live) as client:
            client.sendall(STREAM + behind)
            if stays:
                read_until(client, b"begun")
                assert (counts(live)._total, heard) == (1, [])
            else:
                with contextlib.suppress(ConnectionError):
                    while client.recv(10_000):
                        pass
        wait_until(lambda: counts(live)._total == 0 and bool(heard))
        assert heard == ["gone"]


def test_requests_that_come_together_are_answered_in_order(live: Live) -> None:
    with raw_socket(live) as client:
        client.sendall(PLAIN * (MOST_PIPELINED + 1))
        read = b""
        while read.count(b"HTTP/1.1 200") <= MOST_PIPELINED:
            read += client.recv(10_000)
