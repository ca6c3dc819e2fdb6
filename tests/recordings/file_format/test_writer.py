"""Writing an episode: what goes in comes out, and what goes wrong is said in a sentence."""

import os
from pathlib import Path

import numpy as np
import pytest

from movingout.recordings import EpisodeWriter, Event, RecordingError, TickRecord, finalise, read_episode
from movingout.recordings.file_format.journal import Journal
from movingout.world import World
from movingout.world.state import WorldState
from tests.recordings.support import assert_holds, begin, clock, header, plain, play, play_tick, record


def test_an_episode_read_from_its_journal_equals_what_was_recorded(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=30)
    episode = read_episode(journal)
    assert_holds(episode, played)
    assert (episode.outcome, episode.complete, episode.damage) == ("time", True, "")


def test_a_finished_episode_equals_its_journal(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=30, map_name="AdaptiveAssist")
    before = plain(read_episode(journal))
    finished = finalise(journal)
    assert plain(read_episode(finished)) == before
    assert_holds(read_episode(finished), played)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["episode.mcap"]


def test_attachments_are_kept_beside_the_map(tmp_path: Path) -> None:
    start = header()
    writer = EpisodeWriter.create(tmp_path, start, World(start.map).state(), {"card-red.json": b'{"id":"bass"}'})
    episode = read_episode(finalise(writer.close("stopped")))
    assert episode.attachments.keys() == {"map.json", "card-red.json"}
    assert episode.attachments["card-red.json"] == b'{"id":"bass"}'


def test_the_robots_running_into_each_other_is_an_event_also_right_after_a_restart(tmp_path: Path) -> None:
    start = header("HandOff")  # blue at (0, 0), red at (0, -1), in one lane
    world = World(start.map)
    writer = EpisodeWriter.create(tmp_path, start, world.state())
    while not (events := read_episode(writer.path).events):
        assert world.tick < 20
        writer.abandon()
        writer, _ = EpisodeWriter.resume(writer.path)
        world.step([[1.0, np.pi, 0.0], [1.0, 0.0, 0.0]])
        writer.tick(TickRecord(np.zeros((2, 3)), ("human", "human"), (-1, -1), world.state(), (False,) * 4, 0.0))
    writer.abandon()
    assert [(event.tick, event.kind, event.seat) for event in events] == [(world.tick, "collision", -1)]
    assert events[0].detail.endswith(" units/s")


def test_a_journal_goes_on_after_a_restart(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 12)
    writer.abandon()
    resumed, episode = EpisodeWriter.resume(writer.path, clock=clock().__next__)
    assert_holds(episode, played)
    assert episode.outcome == "interrupted"
    play(resumed, played, 8)
    assert_holds(read_episode(finalise(resumed.close("delivered"))), played)


def test_a_resumed_journal_loses_only_the_tick_in_flight(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 12)
    writer.abandon()
    os.truncate(writer.path, writer.path.stat().st_size - 40)
    resumed, episode = EpisodeWriter.resume(writer.path)
    assert_holds(episode, played, ticks=11)
    resumed.tick(played.ticks[11])
    assert plain(read_episode(resumed.close("left")).ticks) == plain(played.ticks)


def test_an_ended_episode_cannot_be_resumed(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, ticks=3)
    with pytest.raises(RecordingError, match=r"ended \(time\)"):
        EpisodeWriter.resume(journal)


def test_a_journal_belongs_to_one_writer(tmp_path: Path) -> None:
    writer, _ = begin(tmp_path)
    with pytest.raises(RecordingError, match="being written by another process"):
        EpisodeWriter.resume(writer.path)
    with pytest.raises(RecordingError, match="being written by another process"):
        finalise(writer.path)
    writer.abandon()
    finalise(writer.path)


def test_a_pause_is_on_disk_before_the_next_tick(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 2)
    pause = Event(2, "pause", seat=1, detail="connection lost")
    writer.event(pause)
    assert read_episode(writer.path).events == (pause,)
    writer.event(Event(3, "grab", seat=0, item=1))
    assert read_episode(writer.path).events == (pause,), "a grab belongs to its tick and waits for it"
    writer.abandon()


def test_ticks_must_follow_each_other(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 2)
    with pytest.raises(RecordingError, match="tick 2 cannot follow tick 2"):
        writer.tick(played.ticks[1])
    writer.abandon()


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_number_that_is_not_finite_is_refused(tmp_path: Path, value: float) -> None:
    writer, played = begin(tmp_path)
    state = played.world.state()
    poses = state.item_poses.copy()
    poses[1, 0] = value
    broken = WorldState(1, state.robot_poses, state.robot_velocities, state.held, poses)
    with pytest.raises(RecordingError, match="not finite"):
        writer.tick(TickRecord(np.zeros((2, 3)), ("idle", "idle"), (-1, -1), broken, (False,) * 4, 0.0))
    writer.abandon()
    assert read_episode(writer.path).ticks == ()


@pytest.mark.parametrize("name", ["../escape", "", "a/b", ".hidden", "x" * 81])
def test_an_episode_id_is_a_safe_file_name(tmp_path: Path, name: str) -> None:
    with pytest.raises(RecordingError, match="episode id"):
        begin(tmp_path / "inner", episode_id=name)
    assert not list(tmp_path.iterdir())


def test_nothing_is_ever_overwritten(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, ticks=2)
    with pytest.raises(RecordingError, match="cannot create"):
        begin(tmp_path)
    finalise(journal)
    with pytest.raises(RecordingError, match="exists already"):
        begin(tmp_path)


def test_a_folder_that_cannot_be_made_gets_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(RecordingError, match="a file stands where a folder should be"):
        begin(tmp_path / "file" / "recordings")


def test_a_full_disk_is_an_error_and_what_was_written_stays_whole(tmp_path: Path, small_files: int) -> None:
    writer, played = begin(tmp_path)
    with pytest.raises(RecordingError, match="cannot write"):
        while True:
            play_tick(writer, played)
    writer.abandon()
    episode = read_episode(writer.path)
    assert_holds(episode, played)
    assert writer.path.stat().st_size <= small_files


def test_a_disk_that_is_full_from_the_start_leaves_no_journal(tmp_path: Path, tiny_files: int) -> None:
    with pytest.raises(RecordingError, match="cannot write"):
        begin(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_is_too_slow_is_an_error_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 1)
    times = iter([0.0, 3.7])
    monkeypatch.setattr(Journal, "timer", staticmethod(lambda: next(times)))
    with pytest.raises(RecordingError, match=r"the disk took 3\.7 s for one tick"):
        play_tick(writer, played)
    writer.abandon()
    assert len(read_episode(writer.path).ticks) == 2, "what was written slowly is written all the same"


def test_finishing_on_a_full_disk_keeps_the_journal_and_leaves_no_half_file(
    tmp_path: Path, journal_then_small_files: Path
) -> None:
    with pytest.raises(RecordingError, match="cannot write"):
        finalise(journal_then_small_files)
    assert [path.name for path in tmp_path.iterdir()] == ["episode.mcap.journal"]


def test_syncing_after_closing_does_nothing(tmp_path: Path) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 1)
    writer.sync()
    writer.close("time")
    writer.sync()


def no_space(*_: object) -> int:
    raise OSError(28, os.strerror(28))


def test_a_write_that_fails_raises(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    writer, played = begin(tmp_path)
    play(writer, played, 2)
    with monkeypatch.context() as full:
        full.setattr(os, "write", no_space)
        with pytest.raises(RecordingError, match="No space left"):
            play_tick(writer, played)
    writer.abandon()
    assert len(read_episode(writer.path).ticks) == 2, "what was written is kept"


def test_a_writer_that_tolerates_errors_tells_of_one_and_ends_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer, played = begin(tmp_path)
    told: list[str] = []
    writer.tolerate_errors(lambda error: told.append(str(error)))
    play(writer, played, 2)
    with monkeypatch.context() as full:
        full.setattr(os, "write", no_space)
        play_tick(writer, played)
    assert len(told) == 1 and "No space left" in told[0]
    assert len(read_episode(writer.path).ticks) == 2, "what was written is kept"
