"""Places for new rooms: whether an address may open one more, and which room that was left behind gives way to it."""

import asyncio
import itertools
from collections.abc import Collection

from movingout.server import messages as m
from movingout.server.connection.other_nodes import RoomCount
from movingout.server.public_host import ROOMS_AT_ONCE, NoRoom, PublicHost
from movingout.server.rooms.room_notices import (
    NOBODY_HERE,
    RECORDED_TODAY,
    TOO_MANY_ROOMS,
    OpeningRefused,
    rooms_open,
    rooms_unjoined,
)
from movingout.server.rooms.room_view import LeftState, end_if_left, left_state, longest_left


class RoomPlaces:
    """The places of one host, wherever its rooms are; it keeps nothing of its own."""

    def __init__(self, host: PublicHost) -> None:
        self._host = host

    async def begin_opening(self, address: str) -> OpeningRefused | None:
        """Why nobody at this address may open one more room now, None when they may: it may close one left behind.

        After None, tell `admission.opening_ended` when it was opened, or could not be.
        """
        admission = self._host.admission
        owner, other_nodes = admission.owner(address), admission.other_nodes
        if not admission.may_record(address):
            return RECORDED_TODAY
        if not admission.may_open_room(address):
            return TOO_MANY_ROOMS  # first, because asking each of the open rooms may be a call to another process
        if not await other_nodes.may_record(owner):
            return RECORDED_TODAY
        elsewhere = await other_nodes.may_open_room(owner)
        if elsewhere is None:
            return TOO_MANY_ROOMS
        allowed = False
        admission.opening_began(address)  # before this waits, so that who asks meanwhile counts it, too
        try:
            refusal = await self._no_place(address, elsewhere)
            allowed = refusal is None
        finally:
            if not allowed:
                admission.opening_ended(address)
        return refusal

    async def make_place(self, for_operator: bool = False) -> None:
        """Where all rooms are in use, close the one that was left behind or idle longest, whichever visitor's it is.

        A process that is being replaced is not waited for: the rooms of the others are enough.
        """
        if self._host.refusal(for_operator).code != "rooms_in_use":
            return  # there is place, or a server that ends opens none
        opened = [room for _, rooms in self._host.admission.rooms_by_owner().values() for room in rooms]
        for room in longest_left(await self._left_states([room for room in opened if self._host.reaches(room)])):
            if await self._close_if_left(room):
                return

    async def _no_place(self, address: str, elsewhere: RoomCount) -> OpeningRefused | None:
        """Why the rooms that an address has leave no place for the last of those that are being opened."""
        admission, limits = self._host.admission, self._host.settings.limits
        new = admission.being_opened(address)
        opened = await self._left_states(admission.rooms_of(address))
        unjoined = sum(not room.joined for room in opened)
        if new + unjoined + elsewhere.unjoined > limits.unjoined_rooms_per_address:
            return rooms_unjoined(limits.unjoined_rooms_per_address)
        over = new + len(opened) + elsewhere.open - limits.open_rooms_per_address
        in_return = min(max(over, 0), new)  # those for the ones before may be closed only after this has asked
        left = longest_left(opened)
        if len(left) >= in_return:
            for room in left:
                if in_return and await self._close_if_left(room):
                    in_return -= 1
        return rooms_open(limits.open_rooms_per_address) if in_return else None

    async def _left_states(self, rooms: Collection[str]) -> list[LeftState]:
        """What `_left_state` says of each room that is still there."""
        waiting = iter(rooms)
        found: list[LeftState | None] = []
        while some := list(itertools.islice(waiting, ROOMS_AT_ONCE)):
            found += await asyncio.gather(*map(self._left_state, some))
        return [state for state in found if state is not None]

    async def _left_state(self, room_id: str) -> LeftState | None:
        """How much a room is needed; None when it is gone."""
        try:
            return await self._host.ask(room_id, left_state)
        except NoRoom:
            return None

    async def _close_if_left(self, room_id: str) -> bool:
        """Close a room, unless somebody has come since it was asked; whether it is gone."""
        try:
            if not await self._host.ask(room_id, end_if_left):
                return False
            await self._host.close_room(room_id, m.CLOSE_ROOM_OVER, NOBODY_HERE)
        except NoRoom:
            pass
        return True
