"""Handing connections over to a process that takes none."""

import asyncio
import os
import socket

import pytest

from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.handover import AGENTS, MOST_WAITING, HandingOver, socket_pair


def test_only_so_many_connections_wait_for_a_process_that_takes_none() -> None:
    async def hand_over_all(link: socket.socket, descriptor: int) -> int:
        handing_over = HandingOver(link)
        try:
            with pytest.raises(ProcessGone):
                for _ in range(100_000):
                    handing_over.give(descriptor, b"x" * 1000)
            waiting = len(handing_over._waiting)
            handing_over.give(descriptor, AGENTS)  # the agents of that process: given once
            assert len(handing_over._waiting) == waiting + 1
            return waiting
        finally:
            handing_over.close()

    ours, theirs = socket_pair()
    reading, writing = os.pipe()
    try:
        assert asyncio.run(hand_over_all(ours, reading)) == MOST_WAITING
    finally:
        theirs.close()
        os.close(reading)
        os.close(writing)
