"""Who sits in a room: tokens, seats, spectators, and what a client may not ask for."""

import pytest

from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import Refused, WrongRequest
from movingout.server.rooms.time_limits import INVITED_S
from tests.server.support import TICK, Table

CLOSED = Notice("closed_by_operator", "closed")


def test_tokens_change_at_each_join_and_the_old_one_dies_when_the_new_one_has_arrived() -> None:
    table = Table()
    blue = table.join(claim=1)
    again = table.join(tokens=blue.tokens)
    assert again.seats == [0] and again.tokens != blue.tokens
    assert blue.goodbye is not None and blue.goodbye[0] == m.CLOSE_REPLACED
    once_more = table.join(tokens=blue.tokens)  # the welcome of `again` may have been lost
    table.room.seating.confirm(once_more)
    with pytest.raises(Refused) as refused:
        table.join(tokens=blue.tokens)
    assert refused.value.code == m.CLOSE_UNAUTHORISED


def test_a_line_that_drops_again_and_again_before_the_welcome_loses_no_seat() -> None:
    """The second drop made the only token invalid that the client had."""
    table = Table()
    blue = table.join(claim=1)
    table.room.seating.confirm(blue)
    lost = [table.join(tokens=blue.tokens) for _ in range(6)]
    last = table.join(tokens=blue.tokens)
    table.room.seating.confirm(last)
    for old in (blue, *lost):
        with pytest.raises(Refused):
            table.join(tokens=old.tokens)
    assert table.join(tokens=last.tokens).seats == [0]


def test_a_token_that_has_arrived_makes_the_one_before_it_invalid_though_the_line_drops_again() -> None:
    table = Table()
    blue = table.join(claim=1)
    arrived = table.join(tokens=blue.tokens)
    table.join(tokens=arrived.tokens)
    with pytest.raises(Refused):
        table.join(tokens=blue.tokens)
    assert table.join(tokens=arrived.tokens).seats == [0]


@pytest.mark.parametrize("token", ["", "token", "token0x", "é" * 10, "\ud800"])
def test_a_wrong_token_gets_no_seat(token: str) -> None:
    table = Table()
    table.join(claim=1)
    with pytest.raises(Refused):
        table.join(tokens=[token])


def test_a_full_room_refuses_a_third_player_and_names_the_watch_link() -> None:
    table = Table()
    table.pair()
    with pytest.raises(Refused, match="/watch/room"):
        table.join(claim=1)


def test_one_client_may_hold_both_seats() -> None:
    table = Table()
    both = table.join(claim=2)
    assert both.seats == [0, 1]
    table.ready(both)
    table.push(both, 0)
    table.push(both, 1)
    table.step(2)
    assert min(both.bundles[-1].seqs) > 0


def test_seats_kept_for_this_screen_are_not_given_to_the_link() -> None:
    table = Table(seats=[Seat(0, "human"), Seat(1, "human", shared=True)])
    assert table.join(claim=2).seats == [1]


def test_a_program_gets_a_remote_seat_only() -> None:
    table = Table(seats=[Seat(0, "human", shared=True), Seat(1, "remote", shared=True)])
    assert table.join(claim=1, program=True).seats == [1]
    assert table.join(claim=1).seats == [0]


def test_nobody_plays_a_seat_that_is_not_theirs() -> None:
    table = Table()
    blue, _ = table.play()
    with pytest.raises(WrongRequest, match="not yours"):
        table.push(blue, 1)
    for message in (m.Ready(1), m.Pause(1), m.Leave(1), m.Again(1), m.Ready(7), m.Ready(-1)):
        with pytest.raises(WrongRequest, match="not yours"):
            table.say(blue, message)


def test_spectators_see_everything_and_may_do_nothing() -> None:
    table = Table()
    watcher = table.join(mode="watch")
    blue, _ = table.play()
    assert watcher.seats == [] and [b.tick for b in watcher.bundles] == [b.tick for b in blue.bundles]
    with pytest.raises(WrongRequest):
        table.say(watcher, m.Pause(0))
    state = blue.last(m.RoomState)
    assert isinstance(state, m.RoomState) and state.spectators == 1


def test_who_has_left_their_seat_is_no_spectator() -> None:
    table = Table()
    table.join(mode="watch")
    blue, red = table.play()
    table.say(blue, m.Leave(0))
    state = red.last(m.RoomState)
    assert isinstance(state, m.RoomState) and state.spectators == 1


def test_spectators_are_limited() -> None:
    table = Table()
    for _ in range(30):
        table.join(mode="watch")
    with pytest.raises(Refused):
        table.join(mode="watch")


def test_a_late_joiner_gets_the_round_and_the_whole_state_first() -> None:
    table = Table()
    table.play()
    table.step(7)
    watcher = table.join(mode="watch")
    welcome, coming, full, *_ = watcher.told
    assert isinstance(welcome, m.Welcome) and isinstance(coming, m.Round) and isinstance(full, m.FullState)
    assert (full.tick, full.epoch, len(full.poses)) == (8, coming.epoch, 5)
    assert full.time_ms == pytest.approx((table.now + TICK) * 1e3), "a state is of the end of its tick"


def test_nicknames_are_cut_and_stripped_of_control_characters() -> None:
    table = Table()
    table.join(claim=1, name="  <b>A\u0000\u202e\nlan</b> " + "x" * 50)
    assert table.room.seats[0].name == "<b>Alan</b> " + "x" * 12


def test_wrong_order_is_refused_with_what_is_possible_and_what_is() -> None:
    table = Table()
    blue, _ = table.pair()
    with pytest.raises(WrongRequest, match="pause is possible in playing; the room is in lobby"):
        table.say(blue, m.Pause(0))
    with pytest.raises(WrongRequest, match="joined already"):
        table.say(blue, m.Join("room"))


def test_an_empty_room_closes_after_a_quarter_of_an_hour() -> None:
    table = Table()
    table.room.depart(table.join(claim=1), table.now)
    table.seconds(890)
    assert table.phase == "lobby"
    table.seconds(20)
    assert table.phase == "closed"


def test_a_link_that_nobody_has_used_is_kept_for_minutes_and_who_only_watched_does_not_count() -> None:
    table = Table()
    watcher = table.join(mode="watch")
    table.seconds(INVITED_S + 10)
    assert table.phase == "lobby", "somebody is there"
    table.room.depart(watcher, table.now)
    table.seconds(INVITED_S - 10)
    assert table.phase == "lobby" and not table.room.was_joined
    table.seconds(20)
    assert table.phase == "closed"


def test_where_agents_have_both_seats_who_watches_has_joined() -> None:
    table = Table(seats=[Seat(0, "idle"), Seat(1, "idle")])
    table.join(mode="watch")
    assert table.room.was_joined


def test_a_closed_room_stays_closed_when_its_clients_go() -> None:
    table = Table()
    blue, _ = table.play()
    table.room.close(m.CLOSE_KICKED, CLOSED)
    table.room.depart(blue, table.now)
    table.step()
    assert table.phase == "closed"
    assert blue.goodbye == (m.CLOSE_KICKED, CLOSED)


def test_the_state_is_told_every_second() -> None:
    table = Table()
    blue, _ = table.play()
    blue.told.clear()
    table.seconds(10)
    assert 9 <= sum(isinstance(message, m.RoomState) for message in blue.told) <= 11


def test_a_beat_follows_each_tick_of_play_only() -> None:
    table = Table()
    blue, red = table.pair()
    table.room.beat()
    table.ready(blue, red)
    table.room.beat()
    assert blue.beats == red.beats == 1
