"""Five hundred cuts and five hundred flipped bits: what is read is true, or it is an error."""

import random
from pathlib import Path

import pytest

from movingout.recordings import Episode, RecordingError, finalise, read_episode, recover
from tests.recordings.support import plain, record

pytestmark = pytest.mark.slow
ATTEMPTS = 500


@pytest.fixture(scope="module")
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("journal"), ticks=60, map_name="AdaptiveAssist")[0]


@pytest.fixture(scope="module")
def finished(journal: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    copy = tmp_path_factory.mktemp("finished") / journal.name
    copy.write_bytes(journal.read_bytes())
    return finalise(copy)


def assert_true_as_far_as_it_goes(found: Episode, truth: Episode) -> None:
    ticks = len(found.ticks)
    assert plain(found.ticks) == plain(truth.ticks[:ticks])
    assert found.inputs == truth.inputs[: len(found.inputs)]
    assert found.header == truth.header


def test_a_journal_cut_anywhere_recovers_every_whole_tick(journal: Path, tmp_path: Path) -> None:
    truth, data, choice = read_episode(journal), journal.read_bytes(), random.Random(1)
    kept = {}
    for length in sorted(choice.randrange(len(data)) for _ in range(ATTEMPTS)):
        path = tmp_path / "episode.mcap.journal"
        path.write_bytes(data[:length])
        (entry,) = recover(tmp_path)
        kept[length] = entry.ticks
        if entry.recording is not None:
            assert_true_as_far_as_it_goes(read_episode(entry.recording), truth)
        for left in tmp_path.iterdir():
            left.unlink()
    assert list(kept.values()) == sorted(kept.values()), "more bytes never mean fewer ticks"


def test_a_journal_with_a_flipped_bit_is_believed_up_to_it(journal: Path, tmp_path: Path) -> None:
    truth, data, choice = read_episode(journal), journal.read_bytes(), random.Random(2)
    path = tmp_path / journal.name
    for _ in range(ATTEMPTS):
        path.write_bytes(_flipped(data, choice))
        try:
            found = read_episode(path)
        except RecordingError:
            continue  # in the head
        assert_true_as_far_as_it_goes(found, truth)
        assert not found.complete
        assert len(found.ticks) < len(truth.ticks) or found.outcome == "interrupted"


def test_a_recording_cut_anywhere_is_refused(finished: Path, tmp_path: Path) -> None:
    data, choice = finished.read_bytes(), random.Random(3)
    path = tmp_path / finished.name
    for _ in range(ATTEMPTS):
        path.write_bytes(data[: choice.randrange(len(data))])
        with pytest.raises(RecordingError):
            read_episode(path)


def test_a_recording_with_a_flipped_bit_is_refused(finished: Path, tmp_path: Path) -> None:
    data, choice = finished.read_bytes(), random.Random(4)
    path = tmp_path / finished.name
    for _ in range(ATTEMPTS):
        path.write_bytes(_flipped(data, choice))
        with pytest.raises(RecordingError):
            read_episode(path)


def _flipped(data: bytes, choice: random.Random) -> bytes:
    changed = bytearray(data)
    changed[choice.randrange(len(data))] ^= 1 << choice.randrange(8)
    return bytes(changed)
