"""Rooms of a study: keys that let in again, rounds that are played once, a clock that can be held."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from movingout.recordings import read_episode
from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.rooms import player_requests
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import Refused, WrongRequest
from movingout.server.security.tokens import hash_token
from tests.server.support import Ear, FakeServices, Table

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


def test_a_name_that_a_program_gives_itself_is_not_shown_to_a_partner_in_a_study() -> None:
    table = study_table()
    table.seats[0].key = hash_token("key 0")
    table.join(tokens=["key 0"], name="I am the human :-)")
    assert [seat.name for seat in table.room.state().seats] == ["", ""]


@pytest.mark.parametrize(("study", "said"), [(STUDY, False), ({}, True)])
def test_a_participant_does_not_read_why_an_agent_cannot_play(
    study: dict[str, str], said: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """The agent's own sentence names it, its options and files."""
    seats = [Seat(0, "human", shared=True), Seat(1, "agent", "bass", name="Partner A")]
    table = Table(seats=seats, study=study)
    blue = table.join(claim=1)
    table.services.agents.players[0].failed = "bass@all:path=/home/lab/net cannot be loaded"
    table.ready(blue)
    told = [one for one in blue.told if isinstance(one, m.RoomState) and one.reason_code == "agent_failed"]
    assert {one.reason.startswith("Partner A cannot play") for one in told} == {True}
    assert {"bass" in msgspec.json.encode(one).decode() for one in told} == {said}
    assert "/home/lab/net" in caplog.text


@pytest.mark.parametrize(("study", "code"), [(STUDY, "agent_failed"), ({}, "agent_slow")])
def test_players_hear_that_an_agent_is_too_slow_and_participants_only_that_it_cannot_play(
    study: dict[str, str], code: str
) -> None:
    """That it computes at all is not for a participant to know."""
    seats = [Seat(0, "human", shared=True), Seat(1, "agent", "bass", name="Partner A")]
    table = Table(seats=seats, study=study)
    blue = table.join(claim=1)
    player = table.services.agents.players[0]
    player.failed, player.slow = "bass@all needs 200 ms for a decision", True
    table.ready(blue)
    told = [one for one in blue.told if isinstance(one, m.RoomState) and one.phase == "countdown"]
    assert {one.reason_code for one in told} == {code}
    assert all(one.reason_values == {"players": ["Partner A"]} for one in told)


def test_a_participant_does_not_read_which_agent_is_not_free() -> None:
    services = FakeServices()
    table = Table(services=services, seats=[Seat(0, "human", shared=True), Seat(1, "agent", "bass")], study=STUDY)
    table.room.notice = Notice("cannot_start", "bass@all needs more of a core than is left")
    assert table.room.state().reason == "This round cannot start."


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
    table.room.hold(Notice("study_paused", "The experimenter has paused the study."), table.now)
    assert (table.phase, table.room.notice.message) == ("paused", "The experimenter has paused the study.")
    tick = table.room.round.state.tick
    table.say(blue, m.Ready(0))
    table.seconds(700)
    assert (table.phase, table.room.round.state.tick) == ("paused", tick)
    table.room.release(table.now)
    assert table.phase == "countdown"
    table.seconds(3.5)
    assert table.phase == "playing" and table.room.round.state.tick > tick


DRAIN = Notice("restart_soon", "The server restarts soon.")


def test_a_drain_goes_on_when_the_pause_of_the_study_ends() -> None:
    """The experimenter's "Resume" began a round that the restart would have cut off."""
    table = study_table()
    blue, red = seated(table)
    table.room.hold(Notice("study_paused", "The experimenter has paused the study."), table.now)
    table.room.hold_next(DRAIN)
    table.ready(blue, red)
    table.room.release(table.now)
    table.seconds(10)
    assert (table.phase, table.room.state().reason_code) == ("lobby", DRAIN.code)
    told = blue.last(m.RoomState)
    assert isinstance(told, m.RoomState) and told.reason_code == "restart_soon"


def test_a_countdown_that_is_called_off_in_a_drain_does_not_begin_again() -> None:
    table = study_table()
    blue, red = seated(table)
    for ear, seat in ((blue, 0), (red, 1)):
        table.say(ear, m.Ready(seat))
    table.room.hold_next(DRAIN)
    assert table.phase == "countdown", "what has begun goes on"
    table.say(blue, m.Ready(0, ready=False))
    table.say(blue, m.Ready(0))
    table.seconds(10)
    assert (table.phase, table.room.state().reason_code) == ("lobby", DRAIN.code)


def test_a_round_that_has_begun_is_played_to_its_end_in_a_drain_and_is_the_last() -> None:
    table = Table("Simple", "HandOff", limit_ticks=12)
    blue, red = table.play()
    table.room.hold(Notice("study_paused", "The experimenter has paused the study."), table.now)
    table.room.hold_next(DRAIN)
    table.room.release(table.now)
    table.ready(blue, red)
    table.step(12)
    assert table.phase == "round_over"
    table.ready(blue, red)
    table.seconds(10)
    assert (table.phase, table.room.state().reason_code) == ("round_over", DRAIN.code)


def test_a_round_that_is_held_before_its_first_tick_does_not_begin() -> None:
    table = study_table()
    blue, red = seated(table)
    table.say(blue, m.Ready(0))
    table.say(red, m.Ready(1))
    table.room.hold(Notice("study_paused", "Wait."), table.now)
    table.seconds(10)
    assert (table.phase, table.room.round.started) == ("lobby", False)
    table.room.release(table.now)
    assert table.phase == "countdown"


def test_who_has_practised_enough_leaves_the_other_to_practise_on() -> None:
    table = study_table(practice=True, limit_ticks=1200)
    blue, red = seated(table)
    table.ready(blue, red)
    player_requests.retire(table.room, table.seats[1], table.now)
    table.room.depart(red, table.now)
    tick = table.room.round.state.tick
    table.step(5)
    assert (table.phase, table.room.round.state.tick) == ("playing", tick + 5)
    with pytest.raises(Refused):
        table.join(tokens=["key 1"])
