"""A connection counts until it is gone: a client need not hang up because the server has said goodbye."""

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
from starlette.types import Receive, Scope, Send
from uvicorn import Config
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState

from movingout.server import messages as m
from movingout.server import uvicorn_server
from movingout.server.app import create_app
from movingout.server.connection import uvicorn_protocols
from movingout.server.connection.connection_limits import ConnectionLimits
from movingout.server.host import Host
from movingout.server.security.certificate import certificate_in
from movingout.server.settings import Settings
from tests.server.live import WAIT_S, Live, handshake, limits, raw_socket, serve, wait_until

MOST = 3
LONG = 3_000_000  # more bytes than both ends of a connection keep
NO_JOIN = b"\x81\x82" + bytes(4) + b"{}"  # a masked text frame
CLOSE_FRAME = b"\x88\x02"


def read_until(client: socket.socket, end: bytes) -> bytes:
    read = b""
    while end not in read:
        part = client.recv(10_000)
        assert part, read
        read += part
    return read


def turned_away(live: Live) -> socket.socket:
    """A websocket that the server has closed, and its client has not."""
    client = raw_socket(live)
    client.sendall(handshake())
    read_until(client, b"\r\n\r\n")
    client.sendall(NO_JOIN)
    read_until(client, CLOSE_FRAME)
    return client


def counts(live: Live) -> ConnectionLimits:
    assert live.server is not None
    return live.server._connections


def test_a_websocket_that_was_closed_counts_until_its_client_hangs_up_too(tmp_path: Path) -> None:
    with serve(tmp_path, limits(sockets_per_address=MOST)) as live:
        silent = [turned_away(live) for _ in range(MOST)]
        with raw_socket(live) as one_more:
            one_more.sendall(handshake())
            assert f"There are {MOST} connections from your address already".encode() in read_until(one_more, b"close")
        for client in silent:
            client.close()
        wait_until(lambda: live.host.admission.sockets == 0)
        turned_away(live).close()


def test_a_text_that_is_none_after_the_servers_close_is_not_read(live: Live, caplog: pytest.LogCaptureFixture) -> None:
    """It was to be closed once more, which raised: a traceback in the log for each."""
    with turned_away(live) as client:
        client.sendall(b"\x81\x82" + bytes(4) + b"\xff\xff")
        client.sendall(b"\x88\x80" + bytes(4))
        while client.recv(10_000):
            pass
    assert not caplog.records


def test_who_never_hangs_up_is_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uvicorn_protocols, "GOODBYE_S", 0.2)
    with serve(tmp_path) as live, turned_away(live):
        wait_until(lambda: live.host.admission.sockets == 0)


@pytest.mark.slow
def test_a_refused_websocket_counts_until_it_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over TLS its client can keep it open, by not answering the end of TLS."""
    monkeypatch.setattr(uvicorn_server, "GOODBYE_S", 2.0)
    certificate = certificate_in(tmp_path / "tls", "127.0.0.1")
    context = ssl.create_default_context(cafile=str(certificate.certificate))
    with (
        serve(tmp_path, certificate=certificate) as live,
        context.wrap_socket(raw_socket(live), server_hostname="localhost") as client,
    ):
        client.sendall(handshake(protocol="chat"))
        read_until(client, b"movingout.v1")
        assert counts(live)._total == 1
        wait_until(lambda: counts(live)._total == 0)


def test_a_connection_that_was_handed_over_counts_from_then_on(tmp_path: Path) -> None:
    with serve(tmp_path) as live, socket.create_server(("127.0.0.1", 0)) as elsewhere:
        assert live.server is not None

        def handed_over() -> socket.socket:
            client = socket.create_connection(elsewhere.getsockname(), WAIT_S)
            connection, _ = elsewhere.accept()
            connection.setblocking(False)
            adopting = live.server.adopt_request(connection, handshake())  # type: ignore[union-attr]
            asyncio.run_coroutine_threadsafe(adopting, live.loop).result(WAIT_S)
            return client

        with handed_over() as client:
            read_until(client, b"\r\n\r\n")
            assert (live.host.admission.sockets, counts(live)._total) == (1, 0)
        wait_until(lambda: live.host.admission.sockets == 0)
        counts(live).most = 0
        with handed_over() as client:
            assert client.recv(100) == b""
        wait_until(lambda: counts(live)._total == 0)


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
        (PLAIN * uvicorn_protocols.MOST_PIPELINED, True),
        (PLAIN * (uvicorn_protocols.MOST_PIPELINED + 1), False),
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
        client.sendall(PLAIN * (uvicorn_protocols.MOST_PIPELINED + 1))
        read = b""
        while read.count(b"HTTP/1.1 200") <= uvicorn_protocols.MOST_PIPELINED:
            read += client.recv(10_000)


WRONG_HEADS = {
    "subprotocol": handshake().replace(m.SUBPROTOCOL.encode(), b"\xe4"),
    "version": handshake().replace(b": 13", b": 13\xff"),
    "key": handshake().replace(b"dGhl", b"dGh\x80"),
    "connection": handshake().replace(b"upgrade: w", b"connection: \xc3\xa4\r\nupgrade: w"),
}


@pytest.mark.parametrize("head", WRONG_HEADS.values(), ids=WRONG_HEADS.keys())
def test_a_handshake_that_is_not_ascii_is_answered_and_leaves_nothing(
    live: Live, caplog: pytest.LogCaptureFixture, head: bytes
) -> None:
    """It was never answered, kept for ever, and at its end the server stumbled over it and did nothing else."""
    server = live.server
    assert server is not None
    with raw_socket(live) as client:
        client.sendall(head)
        answer = b"".join(iter(lambda: client.recv(10_000), b""))
    assert answer.startswith(b"HTTP/1.1 400") and answer.endswith(b"not the handshake of a websocket.\n"), answer
    wait_until(lambda: not any(one.transport.is_closing() for one in {*server.server_state.connections}))
    assert not caplog.records


def test_a_cookie_of_a_handshake_need_not_be_ascii(live: Live) -> None:
    with raw_socket(live) as client:
        client.sendall(handshake().replace(b"upgrade: w", b"cookie: name=J\xfcrgen\r\nupgrade: w"))
        assert read_until(client, b"\r\n\r\n").startswith(b"HTTP/1.1 101")


def test_a_connection_that_cannot_be_closed_keeps_the_server_from_nothing_at_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    closed: list[object] = []
    stopped: list[bool] = []

    def shutdown(protocol: WebSocketsSansIOProtocol) -> None:
        closed.append(protocol)
        raise RuntimeError("the handler is closed")

    async def stop(host: Host) -> None:
        await stopping(host)
        stopped.append(True)

    stopping = Host.stop
    monkeypatch.setattr(WebSocketsSansIOProtocol, "shutdown", shutdown)
    monkeypatch.setattr(Host, "stop", stop)
    with contextlib.ExitStack() as clients, serve(tmp_path) as live:
        for _ in range(2):
            client = clients.enter_context(raw_socket(live))
            client.sendall(handshake())
            read_until(client, b"\r\n\r\n")
    assert len(closed) == 2 and closed[0] is not closed[1] and stopped == [True]
    assert [record.getMessage() for record in caplog.records] == ["a websocket could not be closed in order"] * 2


class FullTransport(asyncio.Transport):
    """One whose client takes nothing: once it is closing, it stays so."""

    closing = False

    def write(self, data: bytes | bytearray | memoryview) -> None:
        pass

    def close(self) -> None:
        self.closing = True

    def is_closing(self) -> bool:
        return self.closing


def test_a_client_that_said_goodbye_and_takes_none_is_not_told_again(caplog: pytest.LogCaptureFixture) -> None:
    """Saying so raised, at which the server ended without keeping what it had."""

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        await send({"type": "websocket.accept"})
        while (await receive())["type"] != "websocket.disconnect":
            pass

    async def end() -> None:
        config = Config(app, ws_per_message_deflate=False, log_config=None)
        config.load()
        protocol = uvicorn_protocols.GameWebSocketProtocol(config, ServerState(), {})
        protocol.connection_made(FullTransport())
        protocol.data_received(handshake())
        await asyncio.sleep(0)
        protocol.data_received(CLOSE_FRAME[:1] + b"\x80" + bytes(4))
        assert protocol.transport.is_closing() and not protocol.close_sent
        protocol.shutdown()
        await asyncio.gather(*protocol.tasks)
        protocol.connection_lost(None)

    asyncio.run(end())
    assert not caplog.records
