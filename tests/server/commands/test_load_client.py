"""The client of the load test, without a server."""

import asyncio
from typing import Any, cast

import msgspec
import pytest

from movingout.server import messages as m
from movingout.server.commands.load_client import LoadClient, LoadCounts


class Connection:
    """What is written; after so many writes it is broken."""

    def __init__(self, most: int) -> None:
        self.written: list[bytes] = []
        self.most = most

    def write(self, data: bytes) -> None:
        if len(self.written) == self.most:
            raise RuntimeError("broken")
        self.written.append(data)


async def played(monkeypatch: pytest.MonkeyPatch, inputs_per_s: float, most: int) -> tuple[LoadClient, list[bytes]]:
    """A client that plays without a wait until its connection breaks, and what it has sent."""
    really = asyncio.sleep

    async def at_once(_: float) -> None:
        await really(0)

    bot, connection = LoadClient("r", "play", LoadCounts(), "host", inputs_per_s), Connection(most)
    bot.connection_made(cast(Any, connection))
    with monkeypatch.context() as stepped:
        stepped.setattr(asyncio, "sleep", at_once)
        bot._hear({"type": "welcome", "seats": [{"seat": 0}]})
        for _ in range(2 * most):
            await really(0)
    return bot, connection.written


@pytest.mark.parametrize("inputs_per_s", [0.4, 1.0, 10.0])
def test_it_plays_at_any_rate_and_what_ends_it_is_told(monkeypatch: pytest.MonkeyPatch, inputs_per_s: float) -> None:
    bot, written = asyncio.run(played(monkeypatch, inputs_per_s, 40))
    assert len(written) == 40
    with pytest.raises(RuntimeError, match="broken"):
        bot.check()


def test_it_joins_as_the_program_that_it_is() -> None:
    bot, connection = LoadClient("r", "play", LoadCounts(), "host", inputs_per_s=10.0), Connection(2)
    bot.connection_made(cast(Any, connection))
    bot.data_received(b"HTTP/1.1 101 Switching Protocols\r\n\r\n")
    _, join = connection.written
    assert msgspec.json.decode(join[6:], type=m.Join) == m.Join("r", claim=1, name="bot", program=True)
