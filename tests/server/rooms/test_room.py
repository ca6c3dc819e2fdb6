"""The room, by time stepped by hand: phases, seats, pauses, series."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server import messages as m
from movingout.server.persistence.room_snapshot import restore_room, room_again, room_file
from movingout.server.rooms import room_view
from movingout.server.rooms.room_notices import ROOM_IDLE
from movingout.server.rooms.round_series import KEPT_RESULTS
from movingout.server.rooms.services import RESUME_S, Refused
from movingout.world.metrics import METRICS
from tests.server.script import ERRANDS, deliver_simple
from tests.server.support import TICK, Table


def test_the_game_starts_three_seconds_after_both_are_ready() -> None:
    table = Table()
    blue, red = table.pair()
    table.say(blue, m.Ready(0))
    table.seconds(5)
    assert table.phase == "lobby"
    table.say(red, m.Ready(1))
    assert table.phase == "countdown"
    until = table.room.until
    assert until == pytest.approx(table.now + 3.0 + TICK)
    while table.phase == "countdown":
        table.step()
    assert table.phase == "playing"
    assert [bundle.tick for bundle in blue.bundles] == [bundle.tick for bundle in red.bundles] == [1]
    assert blue.bundles[0].time_ms == pytest.approx(until * 1e3)


def test_nobody_moves_in_the_first_tick_whatever_was_sent_in_the_countdown() -> None:
    """As docs/protocol.md says; programs that play rely on it."""
    table = Table()
    blue, red = table.pair()
    table.say(blue, m.Ready(0))
    table.say(red, m.Ready(1))
    start = table.room.round.state.robot_poses[0]
    while table.phase == "countdown":
        table.push(blue, 0)
        table.step()
    (first,) = blue.bundles
    np.testing.assert_allclose(first.poses[-1, 0], start, atol=1e-4)
    table.push(blue, 0)
    table.step()
    assert blue.bundles[-1].poses[-1, 0, 1] > start[1] + 0.01


def test_a_tick_is_sent_with_its_five_poses_before_it_has_happened() -> None:
    table = Table()
    blue, _ = table.play()
    table.push(blue, 0)
    table.step()
    bundle = blue.bundles[-1]
    assert bundle.tick == 2
    assert bundle.time_ms == pytest.approx(table.now * 1e3)
    assert bundle.poses.shape == (5, 5, 3)
    y = bundle.poses[:, 0, 1]
    assert (np.diff(y) > 0).all(), "blue drives on within the tick"


def test_a_released_stick_stops_at_the_next_tick() -> None:
    table = Table()
    blue, _ = table.play()
    table.push(blue, 0, move=1.0)
    table.step(3)
    table.push(blue, 0, move=0.0)
    table.step()
    rest = blue.bundles[-1].poses[-1, 0]
    table.step()
    np.testing.assert_allclose(blue.bundles[-1].poses[-1, 0], rest, atol=1e-4)


def test_a_stick_not_heard_of_for_half_a_second_counts_as_released() -> None:
    table = Table()
    blue, _ = table.play()
    table.push(blue, 0)
    table.step(4)
    assert blue.bundles[-1].seqs[0] > 0
    table.step(2)
    assert blue.bundles[-1].seqs[0] == 0
    still = blue.bundles[-1].poses[-1, 0]
    table.step()
    np.testing.assert_allclose(blue.bundles[-1].poses[-1, 0], still, atol=1e-4)


def test_a_doubled_press_toggles_the_hand_once_and_two_presses_twice() -> None:
    table = Table()
    blue, _ = table.play()
    events: list[str] = []

    def step_with(grabs: int, seq: int) -> None:
        table.push(blue, 0, move=0.0, grabs=grabs, seq=seq)
        table.step()
        events.extend(event.kind for event in blue.bundles[-1].events if event.seat == 0)

    step_with(1, 101)
    step_with(1, 102)  # the same press, told again
    step_with(1, 101)  # an old packet
    assert events == ["grab_failed"]
    step_with(3, 103)
    step_with(3, 104)
    step_with(3, 105)
    assert events == ["grab_failed"] * 3


def test_press_counters_go_on_from_255_to_0() -> None:
    table = Table()
    blue, _ = table.play()
    for grabs in (1, 255, 0):  # a leap of 254 presses is cut to four
        table.push(blue, 0, move=0.0, grabs=grabs)
        table.step(6)
        table.push(blue, 0, move=0.0, grabs=grabs)
    kinds = [event.kind for bundle in blue.bundles for event in bundle.events]
    assert kinds == ["grab_failed"] * (1 + 4 + 1)


def test_presses_made_before_the_start_do_nothing() -> None:
    table = Table()
    blue, red = table.pair()
    table.push(blue, 0, grabs=3)
    table.ready(blue, red)
    table.step(3)
    assert [bundle.events for bundle in blue.bundles] == [()] * 4


def test_delivering_everything_ends_the_round_with_a_result() -> None:
    table = Table()
    blue, red = table.play()
    deliver_simple(table, blue, red)
    result = blue.last(m.Result)
    assert isinstance(result, m.Result)
    assert (result.outcome, result.delivered, result.items, result.tcr) == ("delivered", 3, 3, 1.0)
    assert list(result.metrics) == [metric.key for metric in METRICS]
    assert result.metrics["tcr"] == 1.0 and result.metrics["interdependence"] == 0.0
    brought = {item: [seat] for seat, errands in ERRANDS.items() for item, *_ in errands}
    assert result.delivered_by == [brought[item] for item in range(3)]
    assert table.phase == "series_over"
    delivered = [event for bundle in blue.bundles for event in bundle.events if event.kind == "delivered"]
    assert sorted(event.item for event in delivered) == [0, 1, 2]


def test_the_limit_ends_the_round() -> None:
    table = Table("Simple", "HandOff", limit_ticks=20)
    blue, _ = table.play()
    table.step(25)
    result = blue.last(m.Result)
    assert isinstance(result, m.Result)
    assert (result.outcome, result.ticks, table.phase) == ("time", 20, "round_over")
    assert blue.bundles[-1].tick == 20


def test_after_a_round_both_are_asked_before_the_next_map_begins() -> None:
    table = Table("Simple", "HandOff", limit_ticks=10)
    blue, red = table.play()
    table.step(12)
    table.say(blue, m.Ready(0))
    table.seconds(5)
    assert table.phase == "round_over"
    table.say(red, m.Ready(1))
    coming = red.last(m.Round)
    assert isinstance(coming, m.Round)
    assert (coming.index, coming.map["name"], coming.epoch) == (1, "HandOff", 2)
    table.ready()
    assert red.bundles[-1].epoch == 2
    assert red.bundles[-1].tick == 1
    table.step(12)
    assert table.phase == "series_over"


def test_again_plays_the_same_map_once_more() -> None:
    table = Table("Simple", "HandOff", limit_ticks=10)
    blue, red = table.play()
    table.step(12)
    table.say(blue, m.Again(0))
    table.say(red, m.Ready(1))
    coming = blue.last(m.Round)
    assert isinstance(coming, m.Round)
    assert (coming.index, coming.map["name"]) == (0, "Simple")


def test_the_last_map_can_be_played_again_after_the_series() -> None:
    table = Table("Simple", limit_ticks=10)
    blue, red = table.play()
    table.step(12)
    assert table.phase == "series_over"
    table.say(blue, m.Again(0))
    table.say(red, m.Again(1))
    assert table.phase == "countdown"


def test_a_dropped_player_pauses_the_game_and_comes_back_by_token() -> None:
    table = Table()
    blue, red = table.play()
    table.step(5)
    table.room.depart(red, table.now)
    state = blue.last(m.RoomState)
    assert isinstance(state, m.RoomState)
    assert (state.phase, state.reason) == ("paused", "Red lost the connection. The game waits.")
    assert state.until_ms == pytest.approx((table.now + RESUME_S) * 1e3)
    ticks = len(blue.bundles)
    table.seconds(20)
    assert len(blue.bundles) == ticks, "the world waits"
    back = table.join(tokens=red.tokens)
    assert back.seats == [1]
    assert table.phase == "countdown"
    table.ready()
    assert back.bundles[-1].tick == ticks + 1, "play goes on where it stopped"


def test_a_player_who_does_not_come_back_ends_the_round_cleanly() -> None:
    table = Table("Simple", "HandOff")
    blue, red = table.play()
    table.room.depart(red, table.now)
    table.seconds(RESUME_S + 0.5)
    result = blue.last(m.Result)
    assert isinstance(result, m.Result)
    assert result.outcome == "left"
    assert (table.phase, table.room.notice.message) == ("series_over", "Red did not come back.")


def test_a_pause_needs_the_one_who_paused_to_go_on() -> None:
    table = Table()
    blue, red = table.play()
    table.say(red, m.Pause(1))
    assert (table.phase, table.room.notice.message) == ("paused", "Red paused the game.")
    table.say(blue, m.Ready(0))
    assert table.phase == "paused"
    table.say(red, m.Ready(1))
    assert table.phase == "countdown"


def test_a_drop_during_the_countdown_goes_back_to_the_lobby() -> None:
    table = Table()
    blue, red = table.pair()
    table.say(blue, m.Ready(0))
    table.say(red, m.Ready(1))
    table.room.depart(red, table.now)
    assert table.phase == "lobby"
    table.seconds(5)
    assert not blue.bundles


def test_leaving_ends_the_round_and_the_partner_sees_why() -> None:
    table = Table()
    blue, red = table.play()
    table.say(red, m.Leave(1))
    result, state = blue.last(m.Result), blue.last(m.RoomState)
    assert isinstance(result, m.Result) and isinstance(state, m.RoomState)
    assert (result.outcome, state.phase, state.reason) == ("left", "series_over", "Red left the game.")


def test_a_seat_left_in_the_lobby_is_free_for_the_next_one() -> None:
    table = Table()
    _, red = table.pair()
    table.say(red, m.Leave(1))
    assert table.room.seats[1].open
    assert table.join(claim=1).seats == [1]


def test_a_shared_seat_is_free_again_when_its_player_is_gone_from_the_lobby() -> None:
    table = Table()
    _, red = table.pair()
    table.room.depart(red, table.now)
    table.seconds(29)
    assert not table.room.seats[1].open
    table.seconds(2)
    assert table.room.seats[1].open
    with pytest.raises(Refused):
        table.join(tokens=red.tokens)


def test_of_a_map_played_again_and_again_the_newest_results_are_kept() -> None:
    table = Table(limit_ticks=1, countdown_s=0.0)
    blue, red = table.play()
    for _ in range(KEPT_RESULTS + 5):
        table.say(blue, m.Again(0))
        table.say(red, m.Again(1))
        table.step(3)
    assert table.phase == "series_over" and len(table.services.results) == KEPT_RESULTS + 6
    results = [result for _, result in table.services.results]
    file = room_file(table.room, 0.0)
    assert file.results == results[-KEPT_RESULTS:]
    file.results = results  # written by an earlier version
    again = room_again(file, None, table.services, table.now)
    assert list(again.series.results) == results[-KEPT_RESULTS:]


def test_a_round_that_has_not_begun_keeps_its_id_and_one_that_was_recorded_gives_way_to_another(tmp_path: Path) -> None:
    table = Table(limit_ticks=1)
    kept = room_file(table.room, 0.0)
    assert kept.next_episode
    again = restore_room(kept, tmp_path, table.services, table.now)
    assert again.round.episode_id == kept.next_episode
    assert again.series.prepare().episode_id != kept.next_episode, "the round after it is another one"
    (tmp_path / f"{kept.next_episode}{JOURNAL_SUFFIX}").touch()
    assert restore_room(kept, tmp_path, table.services, table.now).round.episode_id != kept.next_episode


def test_a_room_where_somebody_is_never_ready_may_give_way_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    table = Table()
    monkeypatch.setattr(room_view, "time", SimpleNamespace(monotonic=lambda: table.now))
    blue = table.join(claim=1)
    table.now += room_view.IDLE_S - 1
    red = table.join(claim=1)
    table.now += room_view.IDLE_S - 1
    assert not room_view.end_if_left(table.room), "a partner has come since"
    blue = table.join(tokens=blue.tokens)
    assert room_view.left_state(table.room).idle_s == room_view.IDLE_S - 1, "who comes back is nobody new"
    table.ready(blue, red)
    table.seconds(5)
    assert table.phase == "playing" and room_view.left_state(table.room).idle_s == 0.0
    table.say(blue, m.Leave(0))
    table.now += room_view.IDLE_S - 1
    assert not room_view.end_if_left(table.room), "a round has ended since"
    table.now += 2
    assert room_view.end_if_left(table.room)
    assert red.goodbye == (m.CLOSE_ROOM_OVER, ROOM_IDLE)
