"""What a room records, and that the game goes on when it cannot."""

import os
from pathlib import Path

import numpy as np
import pytest

from movingout.recordings import EpisodeWriter, read_episode, verify
from movingout.server import messages as m
from movingout.server.rooms.rounds.round import LiveRound
from movingout.world import WorldError
from tests.server.support import FakeServices, Table


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
    assert back.bundles[-1].flags & m.FLAG_SKIPPED
    assert table.room.missed_ticks == 4
    table.step(25)
    episode = read_episode(table.services.archived[0])
    kinds = [event.kind for event in episode.events if event.kind not in ("grab_failed",)]
    assert kinds == ["start", "pause", "resume", "drop", "return", "resume", "tick_skipped", "end"]
    assert max(tick.late_ms for tick in episode.ticks) == pytest.approx(10.0)


def test_a_round_with_two_returns_verifies_though_each_connection_counts_from_one(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=30)
    _, red = table.play()
    for turn in range(3):
        for seq in range(1, 6):
            table.push(red, 1, heading=turn + seq / 10, seq=10 + seq)
            table.step()
        table.room.depart(red, table.now)
        red = table.join(tokens=red.tokens)
        table.push(red, 1, heading=-2.0 - turn, seq=11)  # while nothing is recorded: a number that was used before
        table.ready(red)
        table.step(2)
    table.step(30)
    episode = read_episode(table.services.archived[0])
    assert [event.kind for event in episode.events].count("return") == 3
    assert {sample.connection for sample in episode.inputs if sample.seat == 1} == {0, 1, 2, 3}
    assert verify(table.services.archived[0]).first_divergence is None
    first = next(sample for sample in episode.inputs if sample.connection == 1)
    assert first.seq == 11 and first.heading == pytest.approx(-2.0), "what a seat holds when play goes on is recorded"


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


def test_everybody_is_told_whose_page_is_hidden(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path))
    blue, red = table.play()
    for visible in (False, True):
        table.say(blue, m.Focus(visible))
        table.seconds(1.1)
        state = red.last(m.RoomState)
        assert isinstance(state, m.RoomState)
        assert [seat.visible for seat in state.seats] == [visible, True]


def focus_events(table: Table) -> list[tuple[int, int, str]]:
    """Tick, seat and detail."""
    events = read_episode(table.services.archived[0]).events
    return [(event.tick, event.seat, event.detail) for event in events if event.kind == "focus"]


def hidden_s(table: Table) -> list[float]:
    return [table.room.round.quality.hidden_s(seat) for seat in (0, 1)]


def test_a_page_that_came_back_during_a_pause_is_visible_when_play_goes_on(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=20)
    blue, _ = table.play()
    table.step(6 - table.room.round.state.tick)
    table.say(blue, m.Focus(False))
    table.step(3)
    table.say(blue, m.Pause(0))
    table.say(blue, m.Focus(True))
    table.ready(blue)
    table.step(20)
    assert focus_events(table) == [(7, 0, "hidden"), (10, 0, "visible")]
    assert hidden_s(table) == [pytest.approx(0.3), 0.0]


def test_a_page_that_is_hidden_while_the_clock_stands_is_hidden_when_it_runs(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=10)
    blue, red = table.pair()
    for _ in range(2):  # two messages about the same are one event
        table.say(red, m.Focus(False))
    table.ready(blue, red)
    table.step(15)
    assert focus_events(table) == [(1, 1, "hidden")]
    assert hidden_s(table) == [0.0, pytest.approx(1.0)]


def test_a_page_that_lost_its_connection_while_hidden_is_visible_until_it_says_otherwise(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=20)
    _, red = table.play()
    table.say(red, m.Focus(False))
    table.step(2)
    table.room.depart(red, table.now)
    back = table.join(tokens=red.tokens)
    table.ready(back)
    table.step(25)
    assert [detail for _, _, detail in focus_events(table)] == ["hidden", "visible"]
    assert hidden_s(table)[1] == pytest.approx(0.2)


def test_a_round_that_a_crash_interrupted_knows_how_long_a_page_was_hidden(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), limit_ticks=20)
    blue, _ = table.play()
    table.say(blue, m.Focus(False))
    table.step(3)
    table.room.suspend()
    (journal,) = tmp_path.iterdir()
    resumed = LiveRound(table.room.round.map, 20, 1, "", 0)
    writer, episode = EpisodeWriter.resume(journal)
    resumed.resume(episode, writer)
    assert resumed.quality.hidden_s(0) == table.room.round.quality.hidden_s(0) == pytest.approx(0.3)
    assert resumed.quality.focus(0, True), "what comes next is new"


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
    problem = table.room.round.recorder.problem
    assert problem.code == "disk_full" and "No space left" in problem.message
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


def test_an_orderly_stop_leaves_the_round_to_be_resumed(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path))
    blue, _ = table.play()
    table.step(4)
    table.room.suspend()
    assert blue.goodbye is not None and blue.goodbye[0] == m.CLOSE_SHUTDOWN
    assert (table.phase, table.services.archived) == ("playing", [])
    (journal,) = tmp_path.iterdir()
    episode = read_episode(journal)
    assert (episode.outcome, len(episode.ticks)) == ("interrupted", 5)


def test_a_disk_that_is_full_at_the_start_or_at_the_end_leaves_a_round_without_a_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_space(*_: object) -> int:
        raise OSError(28, os.strerror(28))

    full = Table(services=FakeServices(folder=tmp_path / "start"), limit_ticks=5)
    monkeypatch.setattr(os, "write", no_space)
    blue, _ = full.play()
    full.step(2)
    assert full.phase == "playing" and not full.room.recording
    assert "No space left" in full.room.round.recorder.problem.message
    monkeypatch.undo()

    late = Table(services=FakeServices(folder=tmp_path / "end"), limit_ticks=5)
    blue, _ = late.play()
    late.step(3)
    assert late.room.recording
    monkeypatch.setattr(os, "write", no_space)
    late.step(3)
    assert isinstance(blue.last(m.Result), m.Result)
    assert late.services.archived == []
    assert "No space left" in late.room.round.recorder.problem.message
