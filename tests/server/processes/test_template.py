"""The front's view of the process that is copied for each process with rooms."""

import asyncio
import contextlib
import socket
import subprocess
from collections.abc import Iterator

import pytest

from movingout.server.processes import template
from movingout.server.processes.message_sockets import message_sockets
from movingout.server.processes.template import TemplateProcess


class SlowTemplate(TemplateProcess):
    """Answers when the test does so, at `theirs`."""

    theirs: socket.socket

    def start(self) -> None:
        self._link, self.theirs = message_sockets()
        self._link.setblocking(False)
        self._process = subprocess.Popen(["sleep", "60"])


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> Iterator[SlowTemplate]:
    monkeypatch.setattr(template, "COPIES_S", 0.05)
    slow = SlowTemplate(keep=0)
    slow.start()
    yield slow
    if slow._process is not None:
        slow._process.kill()
    slow.close()


def test_the_answer_of_a_copy_that_was_given_up_is_not_that_of_the_next_one(slow: SlowTemplate) -> None:
    """Or each process with rooms has the pid of the one before: a hanging one is killed, and another one ends."""
    first, process = slow.theirs, slow._process
    ours, theirs = message_sockets()
    with ours, theirs, first:
        with pytest.raises(TimeoutError):
            asyncio.run(slow.copy(ours, theirs))
        with contextlib.suppress(OSError):  # nobody reads it any more
            first.send(b"11")
        asyncio.run(_answered(slow, ours, theirs))
    assert process is not None and process.poll() is not None, "the process that was too slow has ended"
    slow.theirs.close()


async def _answered(slow: SlowTemplate, ours: socket.socket, theirs: socket.socket) -> None:
    copy = asyncio.create_task(slow.copy(ours, theirs))
    await asyncio.sleep(0)
    slow.theirs.send(b"22")
    assert await copy == 22
