"""Server-sent events: one line of JSON per event, and comments that reveal a broken connection."""

import asyncio
from collections.abc import AsyncIterator, Callable

from fastapi.responses import StreamingResponse

from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.running_study import RunningStudy

KEEP_ALIVE_S = 4.0
POLL_S = 1.0  # how soon a stream notices that the server stops
MOST_PER_TOKEN = 3  # a page in several tabs
EventQueue = asyncio.Queue[str | None]  # None ends the stream


class OpenStreams:
    """The streams by token. One more than MOST_PER_TOKEN ends the oldest; its page asks every few seconds instead."""

    def __init__(self) -> None:
        self._queues: dict[str, list[EventQueue]] = {}

    def opened(self, token: str, queue: EventQueue) -> None:
        queues = self._queues.setdefault(token, [])
        queues.append(queue)
        if len(queues) > MOST_PER_TOKEN:
            queues.pop(0).put_nowait(None)

    def closed(self, token: str, queue: EventQueue) -> None:
        queues = self._queues.get(token, [])
        if queue in queues:
            queues.remove(queue)
        if not queues:
            self._queues.pop(token, None)


def event_stream(events: AsyncIterator[str]) -> StreamingResponse:
    return StreamingResponse(events, media_type="text/event-stream", headers={"cache-control": "no-store"})


async def queued_events(running: RunningStudy, queue: EventQueue, close: Callable[[], None]) -> AsyncIterator[str]:
    """The contents of the queue as events; `close` is called when the stream has ended."""
    quiet_s = 0.0
    try:
        yield ": open\n\n"
        while not running.is_over():
            try:
                data = await asyncio.wait_for(queue.get(), POLL_S)
            except TimeoutError:
                quiet_s += POLL_S
                if quiet_s >= KEEP_ALIVE_S:
                    quiet_s = 0.0
                    yield ": beat\n\n"
            else:
                if data is None:
                    return
                quiet_s = 0.0
                yield f"data: {data}\n\n"
    finally:
        close()


async def every_second(running: RunningStudy, dashboard: Dashboard) -> AsyncIterator[str]:
    """The whole state, then once a second what has changed."""
    seen = -1
    while not running.is_over():
        await dashboard.refresh()
        news, seen = dashboard.news(seen), dashboard.version
        for document in news:
            yield f"data: {document}\n\n"
            await asyncio.sleep(0)
        await asyncio.sleep(1.0)
