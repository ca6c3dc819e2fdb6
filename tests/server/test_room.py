"""The room, by time stepped by hand: phases, seats, pauses, series."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings import read_episode, verify
from server import messages as m
from server.seats import Seat
from server.services import RESUME_S, Refused, WrongRequest
from server.tokens import hash_token
from tests.server.script import deliver_simple
from tests.server.support import TICK, Ear, FakeServices, Table
from world import WorldError


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
    assert (table.phase, table.room.reason) == ("series_over", "Red did not come back.")


def test_a_pause_needs_the_one_who_paused_to_go_on() -> None:
    table = Table()
    blue, red = table.play()
    table.say(red, m.Pause(1))
    assert (table.phase, table.room.reason) == ("paused", "Red paused the game.")
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


# ---- seats and tokens -----------------------------------------------------------------------------------------


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
    table.seconds(890)
    assert table.phase == "lobby"
    table.seconds(20)
    assert table.phase == "closed"


def test_a_closed_room_stays_closed_when_its_clients_go() -> None:
    table = Table()
    blue, _ = table.play()
    table.room.close(m.CLOSE_KICKED, "closed")
    table.room.depart(blue, table.now)
    table.step()
    assert table.phase == "closed"
    assert blue.goodbye == (m.CLOSE_KICKED, "closed")


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


# ---- agents ---------------------------------------------------------------------------------------------------


def agent_table() -> Table:
    return Table(seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake", name="fake")])


def test_an_agent_is_asked_about_the_state_it_acts_on_until_the_next_tick() -> None:
    table = agent_table()
    blue = table.join(claim=1)
    table.ready(blue)
    (player,) = table.services.agents.players
    table.step(2)
    assert [tick for tick, _ in player.observed] == [0, 1, 2, 3]
    assert player.observed[-1][1] == pytest.approx(table.now + TICK)
    y = [bundle.poses[-1, 1, 1] for bundle in blue.bundles]
    assert y == sorted(y) and y[-1] > y[0], "red drives as the agent says"


def test_the_game_waits_for_an_agent_that_still_loads() -> None:
    table = agent_table()
    blue = table.join(claim=1)
    (player,) = table.services.agents.players
    player.ready = False
    table.say(blue, m.Ready(0))
    table.seconds(3)
    assert table.phase == "lobby"
    player.ready = True
    table.step()
    assert table.phase == "countdown"


def test_the_countdown_to_the_next_round_waits_for_its_fresh_agent_but_not_for_ever() -> None:
    table = Table("Simple", "HandOff", seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake")], limit_ticks=10)
    blue = table.join(claim=1)
    table.ready(blue)
    table.step(12)
    table.services.agents.slow = True
    table.say(blue, m.Ready(0))
    table.seconds(5)
    assert table.phase == "countdown"
    table.seconds(8.6)
    assert table.phase == "playing"


def test_an_agent_is_free_for_other_rooms_while_nobody_is_in_the_lobby_and_comes_back_with_the_first() -> None:
    table = agent_table()
    (player,) = table.services.agents.players
    table.seconds(59)
    assert not player.closed
    table.seconds(2)
    assert player.closed
    table.join(claim=1)
    assert [each.closed for each in table.services.agents.players] == [True, False]


def test_a_missed_deadline_is_neutral_counted_and_shown() -> None:
    table = agent_table()
    blue = table.join(claim=1)
    table.ready(blue)
    (player,) = table.services.agents.players
    player.asleep = True
    player.problem = "the worker died"
    table.step()
    assert [event.kind for event in blue.bundles[-1].events] == ["deadline_missed", "agent_error"]
    assert table.room.round.deadline_misses == 1
    assert table.phase == "playing"


def test_agents_play_among_themselves_only_while_somebody_looks_on() -> None:
    table = Table(seats=[Seat(0, "agent", "fake"), Seat(1, "idle")])
    table.seconds(5)
    assert table.phase == "lobby"
    table.join(mode="watch")
    table.seconds(4)
    assert table.phase == "playing"


def test_every_round_has_a_fresh_agent() -> None:
    table = Table("Simple", "HandOff", seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake")], limit_ticks=10)
    blue = table.join(claim=1)
    table.ready(blue)
    table.step(12)
    table.ready(blue)
    first, second = table.services.agents.players
    assert first.closed and not second.closed


# ---- recording ------------------------------------------------------------------------------------------------


def test_a_round_is_recorded_and_the_recording_reproduces_it(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=30)
    blue, red = table.play()
    for count in range(32):
        table.push(blue, 0, heading=count / 10)
        table.push(red, 1, heading=-count / 10, grabs=count // 10)
        table.step()
    (journal,) = table.services.archived
    episode = read_episode(journal)
    assert (len(episode.ticks), episode.outcome, episode.complete) == (30, "time", True)
    assert episode.header.map.name == "Simple"
    assert len(episode.inputs) == 58
    assert {seat.name for seat in episode.header.seats} == {seat.alias for seat in table.seats}
    assert episode.events[0].kind == "start"
    assert verify(journal).identical
    np.testing.assert_allclose(blue.bundles[-1].poses[-1, :2], episode.ticks[-1].state.robot_poses, atol=1e-4)


def test_pauses_drops_and_skipped_ticks_are_in_the_recording(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=20)
    blue, red = table.play()
    table.say(blue, m.Pause(0))
    table.ready(blue)
    table.room.depart(red, table.now)
    back = table.join(tokens=red.tokens)
    table.ready(back)
    table.now += 0.5
    table.room.tick(table.now, table.now - 0.01, skipped=4)
    assert back.bundles[-1].flags & m.FLAG_LATE
    assert table.room.missed_ticks == 4
    table.step(25)
    episode = read_episode(table.services.archived[0])
    kinds = [event.kind for event in episode.events if event.kind not in ("grab_failed",)]
    assert kinds == ["start", "pause", "resume", "drop", "return", "resume", "tick_skipped", "end"]
    assert max(tick.late_ms for tick in episode.ticks) == pytest.approx(10.0)


def test_a_hidden_page_lets_the_stick_go_and_is_recorded(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=10)
    blue, _ = table.play()
    table.push(blue, 0)
    table.step(2)
    table.say(blue, m.Focus(False))
    table.step()
    still = blue.bundles[-1].poses[-1, 0]
    table.step()
    np.testing.assert_allclose(blue.bundles[-1].poses[-1, 0], still, atol=1e-4)
    table.say(blue, m.Focus(True))
    table.step(8)
    events = read_episode(table.services.archived[0]).events
    assert [(e.seat, e.detail) for e in events if e.kind == "focus"] == [(0, "hidden"), (0, "visible")]


def test_practice_has_no_limit_and_no_recording(tmp_path: Path) -> None:
    table = Table("Simple", services=FakeServices(folder=tmp_path), limit_ticks=10, practice=True)
    blue, _ = table.play()
    table.seconds(20)
    assert table.phase == "playing"
    assert blue.bundles[-1].flags & m.FLAG_NOT_RECORDING
    assert list(tmp_path.iterdir()) == []
    state = blue.last(m.RoomState)
    assert isinstance(state, m.RoomState) and not state.recording


def test_a_full_disk_stops_the_recording_and_not_the_game(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = Table(services=FakeServices(folder=tmp_path))
    blue, _ = table.play()
    table.step(3)
    assert not blue.bundles[-1].flags & m.FLAG_NOT_RECORDING

    def no_space(*_: object) -> int:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(os, "write", no_space)
    table.step(2)
    monkeypatch.undo()
    table.step(2)
    assert [bundle.flags & m.FLAG_NOT_RECORDING for bundle in blue.bundles[-4:]] == [1, 1, 1, 1]
    assert "No space left" in table.room.round.recorder.problem
    state = blue.last(m.RoomState)
    assert isinstance(state, m.RoomState)
    (journal,) = tmp_path.iterdir()
    assert len(read_episode(journal).ticks) == 4, "what was written is kept"


def test_a_world_that_loses_its_numbers_ends_the_round_with_an_error() -> None:
    table = Table()
    blue, _ = table.play()

    def fail(actions: object) -> None:
        raise WorldError("a pose is not finite")

    table.room.round._world.step = fail  # type: ignore[method-assign]
    table.step()
    result = blue.last(m.Result)
    assert isinstance(result, m.Result) and result.outcome == "error"
    assert table.phase == "series_over"


def test_an_orderly_stop_ends_the_round_and_keeps_the_room(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path))
    blue, _ = table.play()
    table.step(4)
    table.room.suspend()
    assert blue.goodbye is not None and blue.goodbye[0] == m.CLOSE_SHUTDOWN
    assert table.phase == "lobby"
    episode = read_episode(table.services.archived[0])
    assert (episode.outcome, len(episode.ticks)) == ("stopped", 5)


# ---- rooms of a study -----------------------------------------------------------------------------------------


STUDY = {"study": "pilot", "unit": "7", "step": "play/1/Simple-1"}


def study_table(services: FakeServices | None = None, **config: Any) -> Table:
    """Two people of a study."""
    seats = [Seat(0, "human", alias="P7KXM2Q"), Seat(1, "human")]
    return Table(services=services, seats=seats, study=STUDY, **config)


def seated(table: Table) -> tuple[Ear, Ear]:
    """Both come in by the keys that the study gave them."""
    for seat in table.seats:
        seat.key = hash_token(f"key {seat.index}")
    return table.join(tokens=["key 0"]), table.join(tokens=["key 1"])


def test_the_key_of_a_study_lets_in_again_and_again() -> None:
    table = study_table()
    blue, _ = seated(table)
    again = table.join(tokens=["key 0"])
    assert again.seats == [0] and blue.goodbye is not None
    assert table.join(tokens=again.tokens).seats == [0], "and so does the newest token"


def test_a_round_of_a_study_is_played_once_and_told_to_the_study(tmp_path: Path) -> None:
    services = FakeServices(tmp_path)
    table = study_table(services, limit_ticks=12)
    blue, red = seated(table)
    table.ready(blue, red)
    table.step(12)
    assert table.phase == "series_over"
    ((episode, result),) = services.results
    assert (result.outcome, result.ticks, result.recording) == ("time", 12, episode)
    header = read_episode(services.archived[0]).header
    assert dict(header.study) == STUDY and header.seats[0].name == "P7KXM2Q"
    with pytest.raises(WrongRequest, match="played once"):
        table.say(blue, m.Again(0))


def test_practice_of_a_study_has_a_limit_and_no_recording(tmp_path: Path) -> None:
    services = FakeServices(tmp_path)
    table = study_table(services, limit_ticks=12, practice=True)
    table.ready(*seated(table))
    table.step(12)
    assert table.phase == "series_over" and list(tmp_path.iterdir()) == []


def test_a_study_says_how_long_a_round_waits_for_somebody() -> None:
    table = study_table(resume_s=60.0)
    blue, red = seated(table)
    table.ready(blue, red)
    table.room.depart(red, table.now)
    table.seconds(59)
    assert table.phase == "paused"
    table.seconds(2)
    assert (table.phase, table.services.results[0][1].outcome) == ("series_over", "left")


def test_nobody_but_who_held_the_clock_lets_it_go_on() -> None:
    table = study_table()
    blue, red = seated(table)
    table.ready(blue, red)
    table.room.hold("The experimenter has paused the study.", table.now)
    assert (table.phase, table.room.reason) == ("paused", "The experimenter has paused the study.")
    tick = table.room.round.state.tick
    table.say(blue, m.Ready(0))
    table.seconds(700)
    assert (table.phase, table.room.round.state.tick) == ("paused", tick)
    table.room.release(table.now)
    assert table.phase == "countdown"
    table.seconds(3.5)
    assert table.phase == "playing" and table.room.round.state.tick > tick


def test_a_round_that_is_held_before_its_first_tick_does_not_begin() -> None:
    table = study_table()
    blue, red = seated(table)
    table.say(blue, m.Ready(0))
    table.say(red, m.Ready(1))
    table.room.hold("Wait.", table.now)
    table.seconds(10)
    assert (table.phase, table.room.round.started) == ("lobby", False)
    table.room.release(table.now)
    assert table.phase == "countdown"


def test_who_has_practised_enough_leaves_the_other_to_practise_on() -> None:
    table = study_table(practice=True, limit_ticks=1200)
    blue, red = seated(table)
    table.ready(blue, red)
    table.room.retire(table.seats[1], table.now)
    table.room.depart(red, table.now)
    tick = table.room.round.state.tick
    table.step(5)
    assert (table.phase, table.room.round.state.tick) == ("playing", tick + 5)
    with pytest.raises(Refused):
        table.join(tokens=["key 1"])
