"""How long and how often one player may have the other wait in a round, by time stepped by hand."""

import pytest

from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RESUME_S, WrongRequest
from movingout.server.rooms.time_limits import (
    CHANGES_BURST,
    CHANGES_PER_S,
    PAUSE_LIMIT_S,
    PAUSES,
    RETURNS,
    WAIT_LIMIT_S,
)
from movingout.world.constants import TICK_SECONDS
from tests.server.support import Ear, Table


def played_on(table: Table) -> None:
    for _ in range(60):
        if table.phase == "playing":
            return
        table.step()
    raise AssertionError(table.phase)


def paused_for(table: Table, ear: Ear, seat: int, seconds: float) -> None:
    table.say(ear, m.Pause(seat))
    table.seconds(seconds)
    table.say(ear, m.Ready(seat))
    played_on(table)


def test_a_player_pauses_three_times_in_a_round_and_the_game_goes_on_after_that() -> None:
    table = Table("Simple", "HandOff")
    blue, red = table.play()
    for _ in range(PAUSES):
        paused_for(table, red, 1, 1)
    ticks = len(blue.bundles)
    with pytest.raises(WrongRequest, match="up to 3 times and for 120 s in all; the game goes on") as refused:
        table.say(red, m.Pause(1))
    assert refused.value.code == "pauses_used"
    table.step(5)
    assert (table.phase, len(blue.bundles)) == ("playing", ticks + 5)
    paused_for(table, blue, 0, 1)  # the other one has pauses of their own


def test_calling_off_the_countdown_after_a_pause_is_a_pause_too() -> None:
    table = Table()
    _, red = table.play()
    table.say(red, m.Pause(1))
    for _ in range(PAUSES - 1):
        table.say(red, m.Ready(1))
        table.say(red, m.Ready(1, False))
        assert table.phase == "paused"
    table.say(red, m.Ready(1))
    with pytest.raises(WrongRequest):
        table.say(red, m.Ready(1, False))
    assert table.phase == "countdown"
    played_on(table)


def test_changes_of_one_player_that_all_hear_of_are_few() -> None:
    table = Table()
    blue, red = table.play()
    table.say(red, m.Pause(1))
    table.room.depart(blue, table.now)
    blue = table.join(tokens=blue.tokens)
    table.say(blue, m.Ready(0, False))
    table.seconds(10)
    heard = len(blue.told)
    for _ in range(100):
        table.say(red, m.Ready(1, False))
    assert len(blue.told) == heard, "nothing has changed"
    refused = changes_refused(table, red, 100)
    assert refused == 100 - CHANGES_BURST and table.phase == "paused"
    assert len(blue.told) == heard + CHANGES_BURST, "each is told once"
    table.seconds(1)
    assert changes_refused(table, red, 10) == 10 - CHANGES_PER_S
    table.say(blue, m.Ready(0))  # the other has changes of their own


def test_whoever_asks_for_the_same_map_again_and_again_is_heard_once() -> None:
    table = Table(limit_ticks=5)
    blue, red = table.play()
    table.step(10)
    assert table.phase == "series_over"
    heard = len(blue.told)
    for _ in range(50):
        table.say(red, m.Again(1))
    assert len(blue.told) == heard + 1


def changes_refused(table: Table, ear: Ear, changes: int) -> int:
    """How many of these changes between ready and not ready, all at this moment."""
    refused = 0
    for _ in range(changes):
        try:
            table.say(ear, m.Ready(1, not table.room.seats[1].ready))
        except WrongRequest as error:
            assert error.code == "ready_rate"
            refused += 1
    return refused


def test_pauses_of_a_player_last_two_minutes_in_all_and_then_the_game_goes_on_without_them() -> None:
    table = Table()
    blue, red = table.play()
    paused_for(table, red, 1, 100)
    table.say(red, m.Pause(1))
    state = blue.last(m.RoomState)
    assert isinstance(state, m.RoomState)
    assert state.until_ms == pytest.approx((table.now + WAIT_LIMIT_S - 100) * 1e3, abs=1500)  # blue reads it
    table.seconds(WAIT_LIMIT_S - 100 - 2)
    assert table.phase == "paused"
    table.seconds(2.2)
    assert table.phase == "countdown"
    played_on(table)
    table.push(blue, 0)
    table.step(2)
    assert blue.bundles[-1].seqs[0] > 0 and table.room.seats[1].present
    with pytest.raises(WrongRequest):
        table.say(red, m.Pause(1))
    table.say(blue, m.Leave(0))
    assert table.phase == "series_over"


def test_the_next_round_has_pauses_of_its_own() -> None:
    table = Table("Simple", "HandOff", limit_ticks=10)
    blue, red = table.play()
    for _ in range(PAUSES):
        paused_for(table, red, 1, 0.5)
    table.step(12)
    assert table.phase == "round_over"
    table.ready(blue, red)
    played_on(table)
    paused_for(table, red, 1, 1)


def test_who_plays_with_an_agent_keeps_nobody_waiting() -> None:
    table = Table(seats=[Seat(0, "human", shared=True), Seat(1, "agent", "scripted")], practice=True)
    blue = table.join(claim=1)
    table.ready(blue)
    played_on(table)
    for _ in range(2 * PAUSES):
        paused_for(table, blue, 0, 30)
    table.say(blue, m.Pause(0))
    table.seconds(PAUSE_LIMIT_S - 1)
    assert table.phase == "paused"
    table.seconds(2)
    assert (table.phase, table.room.notice.code) == ("series_over", "paused_too_long")


def test_two_at_one_screen_keep_nobody_waiting_who_is_elsewhere() -> None:
    table = Table()
    both = table.join(claim=2)
    for seat in (0, 1):
        table.say(both, m.Ready(seat))
    played_on(table)
    for _ in range(2 * PAUSES):
        paused_for(table, both, 1, 30)
    table.say(both, m.Pause(1))
    table.seconds(PAUSE_LIMIT_S - 1)
    assert table.phase == "paused"


def test_players_who_both_pause_wait_for_nobody_and_an_absent_one_is_no_pause() -> None:
    table = Table()
    blue, red = table.play()
    table.say(red, m.Pause(1))
    table.say(blue, m.Ready(0, False))
    table.seconds(WAIT_LIMIT_S + 60)
    assert table.phase == "paused"
    table.say(blue, m.Ready(0))
    table.seconds(WAIT_LIMIT_S - 5)  # counted from now on
    table.room.depart(blue, table.now)
    table.seconds(20)
    back = table.join(tokens=blue.tokens)
    table.say(back, m.Ready(0))
    assert table.phase == "paused"
    table.seconds(4)
    assert table.phase == "paused"
    table.seconds(1 + 2 * TICK_SECONDS)
    assert table.phase == "countdown"


def test_a_pause_of_the_experimenter_takes_no_time_from_anybody() -> None:
    table = Table()
    _, red = table.play()
    table.say(red, m.Pause(1))
    table.room.hold(Notice("study_paused", "Wait."), table.now)
    table.seconds(2 * WAIT_LIMIT_S)
    table.room.release(table.now)
    assert table.phase == "paused"
    table.seconds(WAIT_LIMIT_S - 2)
    assert table.phase == "paused"


def dropped_for(table: Table, ear: Ear, seat: int, seconds: float) -> Ear:
    """A connection is lost and comes back after `seconds`, unless that was too much."""
    table.room.depart(ear, table.now)
    table.seconds(seconds)
    if table.phase == "series_over":
        return ear
    back = table.join(tokens=ear.tokens)
    table.say(back, m.Ready(seat))
    return back


@pytest.mark.parametrize("absence_s", [0.0, 20.0])
def test_who_drops_again_and_again_holds_the_other_for_two_minutes_of_a_round_in_all(absence_s: float) -> None:
    table = Table()
    blue, red = table.play()
    began, waited = table.now, 0.0
    for _ in range(60):
        paused_at = table.now
        red = dropped_for(table, red, 1, absence_s)
        if table.phase == "series_over":
            break
        played_on(table)
        waited += table.now - paused_at
    assert (table.phase, table.room.notice.code) == ("series_over", "unsteady")
    assert 0.5 * RETURNS * RESUME_S < waited <= RETURNS * RESUME_S + RESUME_S and table.now > began
    assert blue.last(m.RoomState).reason_code == "unsteady"  # type: ignore[union-attr]


def test_absences_of_one_who_is_waited_for_by_nobody_are_not_counted() -> None:
    table = Table(seats=[Seat(0, "human", shared=True), Seat(1, "agent", "scripted")], practice=True)
    blue = table.join(claim=1)
    table.ready(blue)
    played_on(table)
    for _ in range(8):
        blue = dropped_for(table, blue, 0, 25)
        played_on(table)
    assert table.phase == "playing"


def test_an_absence_is_counted_once_though_others_come_and_go_meanwhile() -> None:
    table = Table()
    blue, red = table.play()
    table.room.depart(red, table.now)
    for _ in range(5):
        table.seconds(3)
        table.say(blue, m.Ready(0, False))
        table.say(blue, m.Ready(0))
    state = blue.last(m.RoomState)
    assert isinstance(state, m.RoomState) and table.phase == "paused"
    assert state.until_ms == pytest.approx((table.now + RESUME_S - 15) * 1e3, abs=1000)


def test_an_agent_that_is_still_loading_after_a_restart_has_not_paused_the_game() -> None:
    table = Table(seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake", name="fake")])
    blue = table.join(claim=1)
    table.ready(blue)
    played_on(table)
    table.say(blue, m.Pause(0))
    table.services.agents.players[0].ready = False
    table.say(blue, m.Ready(0))
    assert (table.phase, table.room.notice.code) == ("paused", "all_back")
