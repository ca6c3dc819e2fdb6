"""A torn or damaged recording: what is whole of it is saved, says so, and the file as it was stays."""

import contextlib
import random
import shutil
import struct
import tracemalloc
import zlib
from pathlib import Path

import pytest
import zstandard
from mcap.reader import make_reader

from movingout.recordings import Episode, RecordingError, finalise, read_episode, verify
from movingout.recordings.file_format.records import FOOTER, MAGIC
from movingout.recordings.storage.repair import recover_recording, repair
from tests.recordings.support import plain, record

TICKS = 120
LAST = b"finalised_utc"  # stands in the last record before the checksum of the data


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finalise(record(tmp_path_factory.mktemp("finished"), ticks=TICKS, map_name="AdaptiveAssist")[0])


@pytest.fixture
def torn(finished: Path, tmp_path: Path) -> Path:
    """A copy that broke off in the middle."""
    path = tmp_path / finished.name
    path.write_bytes(finished.read_bytes()[: finished.stat().st_size // 2])
    return path


def assert_true_as_far_as_it_goes(found: Episode, truth: Episode) -> None:
    ticks = len(found.ticks)
    assert plain(found.ticks) == plain(truth.ticks[:ticks])
    assert found.inputs == truth.inputs[: len(found.inputs)] and len(found.inputs) >= ticks
    assert found.decisions == truth.decisions[: len(found.decisions)] and len(found.decisions) >= ticks
    assert found.initial.tick == 0 and found.header.map == truth.header.map


def test_the_whole_ticks_before_the_tear_are_saved_and_marked(finished: Path, torn: Path) -> None:
    before = torn.read_bytes()
    done = recover_recording(torn)
    found = read_episode(torn)
    assert 20 < done.ticks == len(found.ticks) < TICKS
    assert_true_as_far_as_it_goes(found, read_episode(finished))
    assert (found.outcome, found.complete) == ("interrupted", False)
    assert found.damage == done.note != ""
    assert f"up to tick {done.ticks}; its names, seats and settings could not be checked" in done.note
    assert torn.with_name(f"{torn.name}.damaged").read_bytes() == before
    assert sorted(path.name for path in torn.parent.iterdir()) == [torn.name, f"{torn.name}.damaged"]


def test_what_was_saved_is_a_recording_like_any_other(torn: Path) -> None:
    done = recover_recording(torn)
    assert recover_recording(torn).note == "whole; left as it is"
    assert verify(torn).damage == done.note
    with torn.open("rb") as stream:
        topics = {channel.topic for _, channel, _ in make_reader(stream, validate_crcs=True).iter_messages()}
    assert {"/metrics", "/scene/bodies", "/tf"} <= topics


def test_a_file_that_lost_its_index_alone_is_whole_again(finished: Path, tmp_path: Path) -> None:
    path = tmp_path / finished.name
    path.write_bytes(finished.read_bytes()[: -FOOTER.size - len(MAGIC) - 20])
    assert recover_recording(path).note == "only its index was lost; whole again"
    found, truth = read_episode(path), read_episode(finished)
    assert found.complete and found.damage == ""
    assert (plain(found.ticks), found.events, found.outcome) == (plain(truth.ticks), truth.events, truth.outcome)
    assert (found.header, found.versions, found.ended_ns) == (truth.header, truth.versions, truth.ended_ns)


def test_damage_that_a_file_was_saved_with_stays_told(torn: Path) -> None:
    note = recover_recording(torn).note
    torn.with_name(f"{torn.name}.damaged").unlink()
    torn.write_bytes(torn.read_bytes()[:-20])
    recover_recording(torn)
    assert read_episode(torn).damage == note


def believed(data: bytes, truth: Episode) -> int:
    """How many ticks of changed or missing bytes are believed, all of which must be true; -1 for none at all."""
    try:
        found, _ = repair(data, "x.mcap")
    except RecordingError:
        return -1
    assert_true_as_far_as_it_goes(found, truth)
    assert not found.complete and "could not be checked" in found.damage
    return len(found.ticks)


def test_more_bytes_never_mean_fewer_ticks(finished: Path) -> None:
    data, truth = finished.read_bytes(), read_episode(finished)
    end = data.rindex(LAST)
    kept = [believed(data[:length], truth) for length in range(0, end, end // 40)]
    assert kept == sorted(kept) and kept[0] == -1 and kept[-1] > TICKS // 2


@pytest.mark.parametrize("attempts", [30, pytest.param(500, marks=pytest.mark.slow)])
def test_a_flipped_bit_is_never_believed(finished: Path, attempts: int) -> None:
    data, truth, choice = finished.read_bytes(), read_episode(finished), random.Random(attempts)
    end = data.rindex(LAST)
    kept = []
    for _ in range(attempts):
        changed = bytearray(data)
        changed[choice.randrange(end)] ^= 1 << choice.randrange(8)
        kept.append(believed(bytes(changed), truth))
    assert max(kept) > 0


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"a letter to my aunt", MAGIC + bytes(500)])
def test_what_is_no_recording_of_ours_is_refused_and_left_as_it_is(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError):
        recover_recording(path)
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [content]


def test_a_file_that_was_put_aside_before_is_not_overwritten(torn: Path) -> None:
    aside = torn.with_name(f"{torn.name}.damaged")
    aside.write_bytes(b"older")
    before = torn.read_bytes()
    with pytest.raises(RecordingError, match="is there already; move it away"):
        recover_recording(torn)
    assert (aside.read_bytes(), torn.read_bytes()) == (b"older", before)
    assert len(list(torn.parent.iterdir())) == 2


def test_where_files_can_have_one_name_only_a_copy_is_kept(torn: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr("os.link", refuse)
    copy = shutil.copy2(torn, torn.with_name("copy"))
    assert recover_recording(torn).ticks > 0
    assert torn.with_name(f"{torn.name}.damaged").read_bytes() == Path(copy).read_bytes()


def test_a_chunk_that_would_fill_the_memory_is_left_out(torn: Path) -> None:
    """Some hundred thousand bytes that unpack to gigabytes: the checksum of a chunk can be made to fit."""
    content = b"\0" * (300 << 20)
    packed = zstandard.ZstdCompressor().compress(content)
    body = struct.pack("<QQQI", 0, 0, len(content), zlib.crc32(content)) + struct.pack("<I", 4) + b"zstd"
    body += struct.pack("<Q", len(packed)) + packed
    data = torn.read_bytes() + struct.pack("<BQ", 0x06, len(body)) + body
    tracemalloc.start()
    with contextlib.suppress(RecordingError):
        repair(data, "bomb")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 250 << 20
