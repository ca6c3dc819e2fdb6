"""A queue that is fair to addresses: they take turns, so that whoever asks for much waits, and nobody else does."""

import asyncio
from collections import Counter, deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager


class FairQueue:
    """One turn at a time. An address is given as limits know it (`address_group`), empty for the server itself."""

    def __init__(self) -> None:
        self._asked: Counter[str] = Counter()  # waiting or working
        self._waiting: dict[str, deque[asyncio.Future[None]]] = {}  # whose turn comes next is first
        self._taken = False

    def has_place(self, who: str, most: int, most_of_one: int) -> bool:
        """Whether one more may wait for this address where so many may in all; as many again for who has none yet."""
        asked, total = self._asked[who], self._asked.total()
        return total < most * (1 if asked else 2) and asked < most_of_one

    @asynccontextmanager
    async def turn(self, who: str = "") -> AsyncIterator[None]:
        """A turn, once it has come; whoever is to be refused asks `has_place` before."""
        self._asked[who] += 1
        try:
            if self._taken:
                await self._wait(who)
            self._taken = True
            try:
                yield
            finally:
                self._pass_on()
        finally:
            self._asked -= Counter([who])  # which keeps no zeros

    async def _wait(self, who: str) -> None:
        called: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(who, deque()).append(called)
        try:
            await called
        except asyncio.CancelledError:
            if not called.cancelled():  # its turn had just come
                self._pass_on()
            raise

    def _pass_on(self) -> None:
        """Call who is next; that address is last from now on."""
        while self._waiting:
            who = next(iter(self._waiting))
            calls = self._waiting.pop(who)
            called = calls.popleft()
            if calls:
                self._waiting[who] = calls
            if not called.done():  # otherwise it was cancelled
                called.set_result(None)
                return
        self._taken = False
