"""Whoever takes an answer slowly gets it, and whoever takes hardly anything is dropped; by time stepped by hand."""

import asyncio
import socket
from collections.abc import Callable

import pytest

from movingout.server.connection.uvicorn_protocols.reader_deadline import ReaderDeadline
from movingout.server.connection.uvicorn_protocols.taken_bytes import taken_bytes
from movingout.server.settings import Limits


class Timer:
    """The last thing that is to be done later."""

    def __init__(self) -> None:
        self.due: Callable[[], None] | None = None
        self.delay_s = 0.0

    def call_later(self, delay_s: float, work: Callable[[], None]) -> "Timer":
        self.due, self.delay_s = work, delay_s
        return self

    def cancel(self) -> None:
        self.due = None

    def fire(self) -> None:
        due, self.due = self.due, None
        assert due is not None
        due()


class Line:
    """A transport with so many bytes that wait."""

    def __init__(self, waiting: int) -> None:
        self.waiting = waiting
        self.aborted = False

    def get_extra_info(self, name: str) -> None:
        return None

    def get_write_buffer_size(self) -> int:
        return self.waiting

    def abort(self) -> None:
        self.aborted = True


def sending(line: Line, timer: Timer) -> ReaderDeadline:
    """The deadline of a connection on which an answer waits."""
    reader = ReaderDeadline(timer, line, Limits().unread_s)  # type: ignore[arg-type]
    reader.look_anew()
    return reader


@pytest.mark.parametrize(("per_s", "dropped"), [(12_000, False), (1_000, False), (900, True), (0, True)])
def test_an_answer_is_dropped_when_less_than_1_kb_is_taken_per_second(per_s: int, dropped: bool) -> None:
    line, timer = Line(540_000), Timer()
    sending(line, timer)
    assert timer.delay_s == 30.0
    line.waiting -= 30 * per_s
    timer.fire()
    assert line.aborted == dropped


def test_whoever_stops_taking_is_dropped_and_whoever_has_taken_all_is_not() -> None:
    line, timer = Line(540_000), Timer()
    sending(line, timer)
    line.waiting -= 360_000
    timer.fire()
    timer.fire()
    assert line.aborted
    line = Line(540_000)
    sending(line, timer)
    line.waiting = 0
    timer.fire()
    assert not line.aborted and timer.due is None


@pytest.mark.parametrize("waits", ["the rest", "more"])
def test_where_the_system_does_not_count_an_answer_that_flows_is_not_dropped_until_it_stops(waits: str) -> None:
    line, timer = Line(65_000), Timer()
    reader = sending(line, timer)
    for _ in range(3):
        line.waiting = 15_000  # most is taken, and as much is written again
        reader.look_anew()
        line.waiting = 65_000
        reader.look_anew()
    line.waiting = 29_000  # 1.2 KB/s
    timer.fire()
    assert not line.aborted
    if waits == "the rest":
        line.waiting = 15_000
        reader.look_anew()
    timer.fire()
    assert line.aborted, "nothing more was taken"


def test_what_is_taken_of_a_connection_is_counted_by_the_system() -> None:
    async def read_slowly() -> list[int]:
        ours, theirs = await connected()
        transport, _ = await asyncio.get_running_loop().connect_accepted_socket(asyncio.Protocol, ours)
        transport.write(b"x" * 2_000_000)
        counts = [taken_bytes(transport)]
        for _ in range(2):
            await asyncio.get_running_loop().sock_recv(theirs, 100_000)
            await asyncio.sleep(0.05)
            counts.append(taken_bytes(transport))
        transport.abort()
        theirs.close()
        return counts

    first, second, third = asyncio.run(read_slowly())
    assert first <= second <= third and first < third


async def connected() -> tuple[socket.socket, socket.socket]:
    """Both ends of a connection, with small buffers."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 8192)
        client = socket.socket()
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)
        client.connect(listening.getsockname())
        connection, _ = listening.accept()
    for end in (connection, client):
        end.setblocking(False)
    return connection, client
