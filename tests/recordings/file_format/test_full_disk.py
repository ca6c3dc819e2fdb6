"""A disk that is full at any byte: each tick that was taken is there, the rest is refused in a sentence."""

from pathlib import Path

import pytest

from movingout.recordings import EpisodeWriter, RecordingError, finalise, read_episode
from tests.recordings.full_disk import limited
from tests.recordings.support import assert_holds, begin, plain, play, record

TICKS = 3


def test_wherever_a_journal_ends_its_ticks_are_whole_and_there_is_room_for_the_rest_later(tmp_path: Path) -> None:
    journal, same = record(tmp_path, ticks=TICKS)
    whole = journal.stat().st_size
    told = []
    for size in sorted({*range(0, whole, whole // 120), *range(whole - 20, whole)}):
        folder = tmp_path / str(size)
        with limited(size):
            try:
                writer, played = begin(folder)
            except RecordingError as error:
                told.append(str(error))
                assert not list(folder.iterdir()), "no half journal"
                continue
            with pytest.raises(RecordingError, match="cannot write") as refused:
                play(writer, played, TICKS)
                writer.close("time")
            writer.abandon()
        told.append(str(refused.value))
        assert_holds(read_episode(writer.path), played)
        again, _ = EpisodeWriter.resume(writer.path)  # as after a restart, when somebody has made room
        for tick in same.ticks[len(played.ticks) :]:
            again.tick(tick)
        finished = read_episode(finalise(again.close("time")))
        assert plain(finished.ticks) == plain(same.ticks) and finished.complete
        assert [path.name for path in folder.iterdir()] == ["episode.mcap"]
    assert all("cannot write" in sentence and "File too large" in sentence for sentence in told)


def test_wherever_finishing_ends_the_journal_stays_until_the_recording_is_whole(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=TICKS)
    whole = finalise(record(tmp_path / "whole", ticks=TICKS)[0]).stat().st_size
    for size in [*range(0, whole - 200, whole // 60), whole - 200]:  # the time of finishing changes the last digits
        with limited(size), pytest.raises(RecordingError, match="cannot write"):
            finalise(journal)
        assert [path.name for path in tmp_path.glob("*.mcap*")] == [journal.name]
    assert_holds(read_episode(finalise(journal)), played)
