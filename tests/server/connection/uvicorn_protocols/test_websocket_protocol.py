"""A websocket counts until it is gone: a client need not hang up because the server has said goodbye."""

import asyncio
import contextlib
import socket
import ssl
from pathlib import Path

import pytest
from starlette.types import Receive, Scope, Send
from uvicorn import Config
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState

from movingout.server import messages as m
from movingout.server import uvicorn_server
from movingout.server.connection.uvicorn_protocols import websocket_protocol
from movingout.server.host import Host
from movingout.server.security.certificate import certificate_in
from tests.server.connection.uvicorn_protocols.support import CLOSE_FRAME, NO_JOIN, counts, read_until
from tests.server.live import WAIT_S, Live, handshake, limits, raw_socket, serve, wait_until

MOST = 3


def turned_away(live: Live) -> socket.socket:
    """A websocket that the server has closed, and its client has not."""
    client = raw_socket(live)
    client.sendall(handshake())
    read_until(client, b"\r\n\r\n")
    client.sendall(NO_JOIN)
    read_until(client, CLOSE_FRAME)
    return client


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


async def slow_to_answer(scope: Scope, receive: Receive, send: Send) -> None:
    await asyncio.Event().wait()


@pytest.mark.parametrize("early", [b"\xff" * 10, NO_JOIN, b"\x88\x80" + bytes(4)], ids=["no frame", "text", "close"])
def test_who_speaks_before_the_handshake_is_answered_is_dropped(early: bytes) -> None:
    """A room may be in a process that is just being replaced: what is no frame raised meanwhile."""

    async def story() -> None:
        config = Config(slow_to_answer, ws_per_message_deflate=False, log_config=None)
        config.load()
        transport, protocol = FullTransport(), websocket_protocol.GameWebSocketProtocol(config, ServerState(), {})
        protocol.connection_made(transport)
        protocol.data_received(handshake())
        assert not transport.is_closing()
        protocol.data_received(early)
        assert transport.aborted

    asyncio.run(story())


def test_who_never_hangs_up_is_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket_protocol, "GOODBYE_S", 0.2)
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
    aborted = False

    def write(self, data: bytes | bytearray | memoryview) -> None:
        pass

    def close(self) -> None:
        self.closing = True

    def abort(self) -> None:
        self.closing = self.aborted = True

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
        protocol = websocket_protocol.GameWebSocketProtocol(config, ServerState(), {})
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
