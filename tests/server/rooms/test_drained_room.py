"""What the people of a room are told while no further round begins, and what of it stays."""

import msgspec
import pytest

from movingout.server import messages as m
from movingout.server.persistence.room_snapshot import room_again, room_file
from movingout.server.persistence.room_store import RoomFile
from movingout.server.rooms import player_requests
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import RESTART_SOON
from tests.server.support import Ear, Table


def room_from_its_file(table: Table) -> Room:
    file = msgspec.json.decode(msgspec.json.encode(room_file(table.room, 0.0)), type=RoomFile)
    return room_again(file, None, table.services, table.now)


def restored(table: Table) -> m.RoomState:
    """What people are told when the room has come back from its file."""
    return room_from_its_file(table).state()


def test_who_is_ready_hears_why_nothing_begins_and_after_the_restart_no_longer() -> None:
    table = Table(countdown_s=0.0)
    blue, red = table.pair()
    table.room.hold_next(RESTART_SOON)
    table.say(blue, m.Ready(0))
    table.say(red, m.Ready(1))
    table.seconds(3)
    state = table.room.state()
    assert (state.phase, state.reason_code, state.reason) == ("lobby", RESTART_SOON.code, RESTART_SOON.message)
    assert restored(table).reason == ""


def test_between_two_rounds_they_hear_it_too() -> None:
    table = Table("Simple", "HandOff", limit_ticks=1, countdown_s=0.0)
    table.play()
    table.room.hold_next(RESTART_SOON)
    table.step(3)
    assert (table.phase, table.room.state().reason_code) == ("round_over", "restart_soon")


def test_why_a_game_ended_stays_unless_somebody_wants_to_play_again() -> None:
    table = Table()
    blue, _ = table.play()
    player_requests.leave(table.room, table.seats[1], table.now)
    table.room.hold_next(RESTART_SOON)
    assert (table.phase, table.room.state().reason_code) == ("series_over", "left")
    assert restored(table).reason_code == "left"
    table.say(blue, m.Again(0))
    assert table.room.state().reason_code == "restart_soon", "or they would wait without a word"
    assert restored(table).reason_code == "left"


@pytest.mark.parametrize("name", ["", "Ada"])
def test_a_restart_keeps_who_left_so_that_a_page_says_it_in_its_language(name: str) -> None:
    table = Table()
    table.play()
    table.seats[1].name = name
    player_requests.leave(table.room, table.seats[1], table.now)
    told = restored(table)
    assert (told.reason_code, told.reason_values) == ("left", {"players": [name or "red"]})
    assert told.reason == f"{name or 'Red'} left the game."


def test_a_file_of_before_has_its_reason_in_english_alone() -> None:
    table = Table()
    table.play()
    player_requests.leave(table.room, table.seats[1], table.now)
    kept = msgspec.to_builtins(room_file(table.room, 0.0))
    for field in ("reason_code", "reason_values"):
        del kept[field]
    told = room_again(msgspec.convert(kept, RoomFile), None, table.services, table.now).state()
    assert (told.reason_code, told.reason) == ("", "Red left the game.")


@pytest.mark.parametrize("maps", [("Simple",), ("Simple", "HandOff")], ids=["last", "another follows"])
def test_who_asked_to_play_again_does_so_after_the_restart(maps: tuple[str, ...]) -> None:
    table = Table(*maps, limit_ticks=1, countdown_s=0.0)
    players = table.play()
    table.room.hold_next(RESTART_SOON)
    table.step(3)
    for seat, player in enumerate(players):
        table.say(player, m.Again(seat))
    room = room_from_its_file(table)
    for player in players:
        room.join(Ear(), m.Join("room", tokens=player.tokens), table.now)
    room.tick(table.now, table.now)
    assert (room.phase, room.series.index) == ("countdown", 0)
