"""Calls between nodes: what arrives on the other side, and who is not listened to."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import msgspec
import pytest

from movingout.agents.errors import AgentError, AgentsBusyError
from movingout.server.cluster import node_calls
from movingout.server.cluster.node_calls import CALL, NodeCaller, NodeCalls, NodeError, Numbers, signature
from movingout.server.notices import Notice
from movingout.server.public_host import Away, NoRoom

SECRET, RUN = "a secret of the cluster", "run of b"
Stranger = Callable[[bytes, dict[str, str]], Awaitable[int]]


class Host:
    def __init__(self) -> None:
        self.done: list[Any] = []


def note(host: Host, notice: Notice, seats: dict[int, bytes]) -> Notice:
    host.done.append((notice, seats))
    return notice


def refuse(host: Host, kind: str) -> None:
    host.done.append(kind)
    kinds = {"room": NoRoom, "busy": AgentsBusyError, "agent": AgentError, "fault": RuntimeError}
    raise kinds[kind]("it is not possible")


async def nothing_here(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 418, "headers": []})
    await send({"type": "http.response.body", "body": b""})


class Node:
    """An application that is called without a network."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, secret: str = SECRET) -> None:
        self.host = Host()
        self.app = NodeCalls(nothing_here, self.host, RUN, lambda: secret, (note, refuse))
        self.sent: list[bytes] = []
        self.headers: list[tuple[bytes, bytes]] = []  # of the newest answer
        monkeypatch.setattr(node_calls, "_exchange", self.exchange)

    async def exchange(self, address: str, request: bytes) -> bytes:
        self.sent.append(request)
        status, body = await self.request(request)
        if status != 200:
            raise ValueError(f"HTTP {status}")
        return body

    async def request(self, request: bytes) -> tuple[int, bytes]:
        head, _, body = request.partition(b"\r\n\r\n")
        first, *lines = head.split(b"\r\n")
        headers = [(name.lower(), value) for name, value in (line.split(b": ", 1) for line in lines)]
        answer: list[Any] = []

        async def receive() -> Any:
            return {"type": "http.request", "body": body, "more_body": False}

        async def send(message: Any) -> None:
            answer.append(message)

        await self.app({"type": "http", "path": first.split(b" ")[1].decode(), "headers": headers}, receive, send)
        self.headers = answer[0]["headers"]
        return answer[0]["status"], answer[1]["body"]


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Node:
    return Node(monkeypatch)


def call(work: Any, *args: Any, secret: str = SECRET, run: str = RUN) -> Any:
    return asyncio.run(NodeCaller("run of a", lambda: secret).call("b:1", run, work, *args))


def test_values_arrive_as_they_were(node: Node) -> None:
    notice, seats = Notice("moving", "A room moves.", {"rooms": 2}), {0: b"\x00\xff", 1: b""}
    assert call(note, notice, seats) == notice
    assert node.host.done == [(notice, seats)]


@pytest.mark.parametrize(
    ("kind", "raised"),
    [("room", NoRoom), ("busy", AgentsBusyError), ("agent", AgentError), ("fault", NodeError)],
)
def test_an_error_is_raised_where_the_call_was_made(node: Node, kind: str, raised: type[Exception]) -> None:
    with pytest.raises(raised):
        call(refuse, kind)


def test_a_stranger_and_a_call_for_another_run_are_not_listened_to(node: Node) -> None:
    for given in ({"secret": "guessed"}, {"run": "an earlier run of b"}):
        with pytest.raises(Away, match="404"):
            call(refuse, "room", **given)
    assert node.host.done == []


def test_before_a_node_knows_the_secret_it_listens_to_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    node = Node(monkeypatch, secret="")
    with pytest.raises(Away):
        call(refuse, "room", secret="")
    assert node.host.done == []


def test_a_call_that_was_overheard_cannot_be_repeated_or_changed(node: Node) -> None:
    call(note, Notice(), {})
    (overheard,) = node.sent
    changed = overheard.replace(b"/note ", b"/refuse ")
    later = overheard.replace(b"x-number: 1\r", b"x-number: 2\r")
    for request in (overheard, changed, later):
        assert asyncio.run(node.request(request))[0] == 404
    assert len(node.host.done) == 1


def test_what_does_not_fit_is_an_error_and_no_call(node: Node) -> None:
    body = msgspec.msgpack.encode([{"code": "moving"}, "no seats"])
    sign = signature(SECRET, RUN, "a", 7, "note", body)
    head = f"POST {CALL}note HTTP/1.1\r\nx-caller: a\r\nx-number: 7\r\nx-signature: {sign}\r\n\r\n"
    status, answer = asyncio.run(node.request(head.encode() + body))
    assert status == 200 and msgspec.msgpack.decode(answer)["error"] == "error"
    assert node.host.done == []
    for wrong in (b"x-number: -1\r", b"x-number: \xb2\r", b"x-number: " + b"9" * 5000 + b"\r"):
        assert asyncio.run(node.request(head.encode().replace(b"x-number: 7\r", wrong) + body))[0] == 404


def test_each_call_costs_a_connection_of_which_an_address_has_few(node: Node) -> None:
    asyncio.run(node.request(f"POST {CALL}note HTTP/1.1\r\nx-number: 1\r\n\r\n".encode() + bytes(1000)))
    assert (b"connection", b"close") in node.headers


def test_a_body_without_end_is_refused(node: Node) -> None:
    async def flood() -> int:
        answer: list[Any] = []
        taken = 0

        async def receive() -> Any:
            nonlocal taken
            taken += 1
            return {"type": "http.request", "body": b"x" * 64 * 1024, "more_body": True}

        async def send(message: Any) -> None:
            answer.append(message)

        await node.app({"type": "http", "path": f"{CALL}note", "headers": []}, receive, send)
        return taken if answer[0]["status"] == 404 else 0

    assert asyncio.run(flood()) <= 5


def test_numbers_may_overtake_each_other_but_come_once() -> None:
    numbers = Numbers()
    assert [numbers.is_new("a", each) for each in (2, 1, 2, 3, 1)] == [True, True, False, True, False]
    assert numbers.is_new("b", 2)
    for each in range(4, 4 + 2 * node_calls.WINDOW):
        assert numbers.is_new("a", each)
    assert not numbers.is_new("a", 3), "too old to be known, so it is refused"
