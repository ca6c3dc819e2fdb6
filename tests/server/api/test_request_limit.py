"""How many requests of one address are answered, in a time and at once."""

import asyncio
from typing import Any

from movingout.server.api.request_limit import RequestLimit
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.asgi import Message, Receive, Send
from movingout.server.settings import Limits

NEXT_DOOR, ELSEWHERE = "2001:db8:1:2::9", "192.0.2.1"


def limited(app: Any, **limits: Any) -> tuple[RequestLimit, AdmissionControl]:
    admission = AdmissionControl(Limits(**limits), lambda: 0.0)
    return RequestLimit(app, admission), admission


async def status(limit: RequestLimit, kind: str = "http", address: str = "2001:db8:1:2::1") -> int:
    """Of the answer; 0 where the application says nothing."""
    sent: list[Message] = []

    async def receive() -> Message:
        return {"type": "websocket.connect"}

    async def send(message: Message) -> None:
        sent.append(message)

    await limit({"type": kind, "path": "/api/maps", "client": (address, 1)}, receive, send)
    return sent[0]["status"] if sent else 0


def test_an_address_has_so_many_answers_at_once_also_behind_a_proxy() -> None:
    async def check() -> None:
        go_on = asyncio.Event()

        async def slow(_scope: Message, _receive: Receive, _send: Send) -> None:
            await go_on.wait()
            raise ConnectionError

        limit, admission = limited(slow, connections_per_address=2)
        open_ones = [asyncio.create_task(status(limit)) for _ in range(2)]
        elsewhere = asyncio.create_task(status(limit, address=ELSEWHERE))
        await asyncio.sleep(0)
        assert await asyncio.wait_for(status(limit, address=NEXT_DOOR), 2.0) == 429
        assert admission.refusals["requests"] == 1 and not elsewhere.done()
        open_ones[0].cancel()
        await asyncio.wait(open_ones[:1])
        open_ones.append(asyncio.create_task(status(limit)))
        await asyncio.sleep(0)
        assert not open_ones[-1].done()
        go_on.set()
        await asyncio.wait([*open_ones, elsewhere])
        assert not admission._being_answered

    asyncio.run(check())


def test_the_handshake_of_a_websocket_is_a_request() -> None:
    async def silent(_scope: Message, _receive: Receive, _send: Send) -> None:
        pass

    async def check() -> None:
        limit, admission = limited(silent, requests_per_address_per_s=0.1)
        assert [await status(limit, "websocket") for _ in range(4)] == [0, 0, 0, 429]
        assert await status(limit, "websocket", ELSEWHERE) == 0
        assert admission.refusals["requests"] == 1

    asyncio.run(check())
