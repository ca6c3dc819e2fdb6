"""How many rooms an address may open, also when it asks for many at once and their processes answer later."""

import asyncio
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from movingout.server.api.room_places import RoomPlaces
from movingout.server.connection.admission import ROUND_BYTES
from movingout.server.host import Host
from movingout.server.notices import Notice
from movingout.server.public_host import Away, NoRoom
from movingout.server.rooms.room_view import IDLE_S, LEFT_BEHIND_S
from movingout.server.rooms.time_limits import INVITED_S
from movingout.server.settings import Settings
from tests.server.live import limits

ADDRESS = "192.0.2.1"


class FarHost(Host):
    """A host whose rooms are in other processes. `states` says how long each is empty, and whether somebody came.

    `idle` says how long those are without a round in which somebody waits.
    """

    def __init__(self, data: Path, states: dict[str, tuple[float, bool]], **limited: int) -> None:
        super().__init__(Settings(data=data, limits=limits(rooms_per_address_per_minute=1000, **limited)))
        self.states = states
        self.idle: dict[str, float] = {}
        for room in states:
            self.admission.opened_room(self.admission.owner(ADDRESS), room)

    async def ask(self, room_id: str, work: Any) -> Any:  # type: ignore[override]
        await asyncio.sleep(0)
        if room_id not in self.states:
            raise NoRoom
        empty_s, joined = self.states[room_id]
        room = {"id": room_id, "was_joined": joined, "seating": SimpleNamespace(clients=(), taken_at=0.0)}
        room |= {"phase": "lobby", "unchanged_since": time.monotonic() - self.idle.get(room_id, 0.0)}
        return work(SimpleNamespace(**room, empty_s=lambda now: empty_s, close=lambda code, notice: None))

    async def close_room(self, room_id: str, code: int, notice: Notice, *how: Any) -> Any:
        await asyncio.sleep(0)
        if self.states.pop(room_id, None) is None:
            raise NoRoom
        self.admission.closed_room(room_id)

    @property
    def room_count(self) -> int:
        return len(self.states)

    async def openings(self, count: int) -> list[str]:
        """The codes that so many requests at once are refused with, empty for those that may open a room."""
        answers = await asyncio.gather(*(RoomPlaces(self).begin_opening(ADDRESS) for _ in range(count)))
        return ["" if refused is None else refused.code for refused in answers]


def test_requests_at_once_open_no_more_rooms_than_one_after_another(tmp_path: Path) -> None:
    host = FarHost(tmp_path, {f"room{number}": (0.0, False) for number in range(3)}, unjoined_rooms_per_address=10)
    assert asyncio.run(host.openings(20)) == [""] * 7 + ["rooms_unjoined"] * 13
    assert host.admission.being_opened(ADDRESS) == 7, "what was refused is not being opened"


def test_each_of_them_takes_the_place_of_a_room_that_was_left_behind(tmp_path: Path) -> None:
    states = {"played": (0.0, True), "left": (LEFT_BEHIND_S, True), "left long ago": (2 * LEFT_BEHIND_S, True)}
    host = FarHost(tmp_path, states, open_rooms_per_address=3)
    assert asyncio.run(host.openings(1)) == [""]
    host.admission.opening_ended(ADDRESS)
    assert set(host.states) == {"played", "left"}
    host = FarHost(tmp_path, {**host.states, "left long ago": (2 * LEFT_BEHIND_S, True)}, open_rooms_per_address=3)
    assert asyncio.run(host.openings(5)) == ["", ""] + ["rooms_open"] * 3
    assert set(host.states) == {"played"}


def test_a_refusal_says_what_the_rooms_wait_for_and_how_long(tmp_path: Path) -> None:
    host = FarHost(tmp_path, {"room": (0.0, False)}, unjoined_rooms_per_address=1)
    refusal = asyncio.run(RoomPlaces(host).begin_opening(ADDRESS))
    assert refusal is not None
    assert (refusal.code, refusal.values) == ("rooms_unjoined", {"count": 1, "minutes": INVITED_S / 60})
    host.settings = Settings(
        data=tmp_path, limits=limits(unjoined_rooms_per_address=50, rooms_per_address_per_minute=2)
    )
    host.admission = Host(host.settings).admission
    assert asyncio.run(host.openings(3)) == ["", "", "too_many_rooms"]


def test_a_day_full_of_recordings_is_no_minute_full_of_rooms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def no(owner: str) -> bool:
        return False

    host = FarHost(tmp_path, {}, recorded_per_address_per_day=ROUND_BYTES)
    assert asyncio.run(host.openings(1)) == [""]
    host.admission.opened_room(host.admission.owner(ADDRESS), "room")
    host.admission.recorded("room", 1)
    assert asyncio.run(host.openings(1)) == ["recorded_today"]
    host = FarHost(tmp_path, {})
    monkeypatch.setattr(host.admission.other_nodes, "may_record", no)
    assert asyncio.run(host.openings(1)) == ["recorded_today"], "at the other nodes of a cluster"


def test_where_all_rooms_are_in_use_the_one_left_longest_gives_way(tmp_path: Path) -> None:
    states = {"played": (0.0, True), "left": (LEFT_BEHIND_S + 1, True), "left long ago": (2 * LEFT_BEHIND_S, True)}
    host = FarHost(tmp_path, states, rooms=3, rooms_for_operator=0)
    for expected in ({"played", "left"}, {"played", "left"}):
        asyncio.run(RoomPlaces(host).make_place())
        assert set(host.states) == expected, "a place is made only where there is none"
    host.states["new"] = 0.0, False
    asyncio.run(RoomPlaces(host).make_place())
    host.states |= {"another": (LEFT_BEHIND_S - 1, True), "a third": (0.0, True)}
    asyncio.run(RoomPlaces(host).make_place())
    assert set(host.states) == {"played", "new", "another", "a third"}, "whoever has just left may come back"


def test_after_those_that_are_empty_the_one_that_waits_longest_for_a_round_gives_way(tmp_path: Path) -> None:
    """A few addresses could hold all rooms, with a connection in each that is never ready."""
    states = {"held": (0.0, True), "held longest": (0.0, True), "left": (LEFT_BEHIND_S, True), "waits": (0.0, True)}
    host = FarHost(tmp_path, states, rooms=4, rooms_for_operator=0)
    host.idle = {"held": IDLE_S + 1, "held longest": 2 * IDLE_S, "waits": IDLE_S - 1}
    for given in ("left", "held longest", "held", ""):
        asyncio.run(RoomPlaces(host).make_place())
        assert given not in host.states and len(host.states) == 4 - bool(given)
        host.states[f"new {given}"] = 0.0, True
    assert "waits" in host.states


class HalfAway(FarHost):
    """A process is being replaced: who asks for its rooms waits, and hears so."""

    def reaches(self, room_id: str) -> bool:
        return "away" not in room_id

    async def ask(self, room_id: str, work: Any) -> Any:  # type: ignore[override]
        if not self.reaches(room_id):
            raise Away("the process of this room is being restarted; try again in a moment")
        return await super().ask(room_id, work)


def test_while_one_process_is_replaced_a_room_of_another_gives_way(tmp_path: Path) -> None:
    states = {"left, away": (2 * LEFT_BEHIND_S, True), "left": (LEFT_BEHIND_S, True), "played": (0.0, True)}
    host = HalfAway(tmp_path, states, rooms=3, rooms_for_operator=0)
    asyncio.run(RoomPlaces(host).make_place())
    assert set(host.states) == {"left, away", "played"}


class FoundAgain(FarHost):
    """To the room that was left longest somebody comes while the others are asked."""

    async def ask(self, room_id: str, work: Any) -> Any:  # type: ignore[override]
        state = await super().ask(room_id, work)
        if room_id == "left long ago":
            self.states[room_id] = 0.0, True
        return state


def test_a_room_to_which_somebody_has_come_meanwhile_stays_and_another_gives_way(tmp_path: Path) -> None:
    states = {"left long ago": (2 * LEFT_BEHIND_S, True), "left": (LEFT_BEHIND_S, True), "played": (0.0, True)}
    host = FoundAgain(tmp_path, dict(states), rooms=3, rooms_for_operator=0)
    asyncio.run(RoomPlaces(host).make_place())
    assert set(host.states) == {"left long ago", "played"}
    host = FoundAgain(tmp_path, dict(states), open_rooms_per_address=3)
    assert asyncio.run(host.openings(1)) == [""]
    assert set(host.states) == {"left long ago", "played"}


def test_rooms_are_asked_some_at_a_time(tmp_path: Path) -> None:
    host = FarHost(tmp_path, {f"room{number:03}": (0.0, True) for number in range(100)}, rooms=100)
    turns = 0

    async def count() -> None:
        nonlocal turns
        while True:
            await asyncio.sleep(0)
            turns += 1

    async def make_place() -> None:
        counting = asyncio.create_task(count())
        await RoomPlaces(host).make_place()
        counting.cancel()

    asyncio.run(make_place())
    assert 5 <= turns < 50


@pytest.mark.parametrize("error", [Away("restarting"), asyncio.CancelledError()], ids=["away", "cancelled"])
def test_an_opening_that_fails_while_rooms_are_asked_counts_no_longer(tmp_path: Path, error: BaseException) -> None:
    host = FarHost(tmp_path, {"room": (0.0, True)})

    async def ask(room_id: str, work: Any) -> Any:
        assert host.admission.being_opened(ADDRESS) == 1
        raise error

    host.ask = ask  # type: ignore[method-assign]
    with pytest.raises(type(error)):
        asyncio.run(host.openings(1))
    assert host.admission.being_opened(ADDRESS) == 0
