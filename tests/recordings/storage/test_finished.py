"""A finished recording: readable by any MCAP reader, and never believed when a byte of it changed."""

import io
import json
import re
import struct
from itertools import pairwise
from pathlib import Path
from typing import IO, Any

import pytest
import zstandard
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from movingout.recordings import RecordingError, finalise, read_episode
from movingout.recordings.file_format.reader import check_file, episode_of_journal
from movingout.recordings.file_format.records import MAGIC
from movingout.recordings.storage.finished import recover
from movingout.recordings.storage.listing import read_players, read_summary
from movingout.recordings.storage.repair import recover_recording
from movingout.world.metrics import METRICS
from tests.recordings.support import plain, record

KEYS = [metric.key for metric in METRICS]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    journal, _ = record(tmp_path_factory.mktemp("finished"), ticks=8)
    return finalise(journal)


def test_every_flipped_byte_is_found(finished: Path) -> None:
    data = bytearray(finished.read_bytes())
    check_file(bytes(data), finished.name)
    for position in range(len(data)):
        data[position] ^= 1 << (position % 8)
        with pytest.raises(RecordingError):
            check_file(bytes(data), finished.name)
        data[position] ^= 1 << (position % 8)


def test_every_missing_tail_is_found(finished: Path) -> None:
    data = finished.read_bytes()
    for length in range(0, len(data), 11):
        with pytest.raises(RecordingError):
            check_file(data[:length], finished.name)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is empty"),
        (b"PK\x03\x04 something else", "is not an MCAP file"),
        (b"\x89MCAP0\r\n", "is an MCAP file, but not a Moving Out recording"),
    ],
)
def test_other_files_get_a_sentence(tmp_path: Path, content: bytes, sentence: str) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=sentence):
        read_episode(path)


def test_a_foreign_mcap_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="not a Moving Out recording"):
        read_episode(mcap(tmp_path, profile="ros2", metadata={}))


def test_a_newer_format_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"format 99 is not the format 1 of this program; update it"):
        read_episode(mcap(tmp_path, profile="movingout", metadata={"format": "99"}))


def test_a_recording_without_ticks_of_ours_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="the map or the start is missing"):
        read_episode(mcap(tmp_path, profile="movingout", metadata={"format": "1", "episode_id": "x"}))


@pytest.mark.parametrize("name", ["../escape", "/tmp/escape", "", "a/b", ".hidden", "x" * 81])
def test_an_id_that_leads_out_of_a_folder_gets_a_sentence(tmp_path: Path, name: str) -> None:
    """Exports are written under it, and a journal's recording."""
    path = mcap(tmp_path, profile="movingout", metadata={"format": "1", "episode_id": name})
    for read in (read_episode, read_summary, read_players):
        with pytest.raises(RecordingError, match="episode id"):
            read(path)


def test_a_journal_with_such_an_id_is_put_aside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = record(tmp_path, ticks=3, episode_id="kept")[0]
    with monkeypatch.context() as patched:
        patched.setattr("movingout.recordings.file_format.writer.EPISODE_ID", re.compile(r".*"))
        record(tmp_path / "inner", ticks=3, episode_id="../escape")
    assert [one.recording for one in recover(tmp_path)] == [None, kept.with_name("kept.mcap")]
    assert sorted(path.name for path in tmp_path.rglob("*.mcap*")) == [
        "escape.mcap.journal.unreadable",
        "kept.mcap",
    ]


def test_a_missing_file_gets_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="there is no such file"):
        read_episode(tmp_path / "none.mcap")


def compressed(folder: Path, compression: CompressionType, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A finished recording, as another tool would write it."""

    def other(stream: IO[bytes], **options: Any) -> Writer:
        return Writer(stream, **(options | {"compression": compression}))

    with monkeypatch.context() as patched:
        patched.setattr("movingout.recordings.storage.finished.Writer", other)
        return finalise(record(folder, ticks=8)[0])


def test_a_recording_whose_chunks_are_not_compressed_is_read(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = compressed(tmp_path, CompressionType.NONE, monkeypatch)
    assert found.stat().st_size > 2 * finished.stat().st_size
    assert plain(read_episode(found).ticks) == plain(read_episode(finished).ticks)
    found.write_bytes(found.read_bytes()[: -len(MAGIC)])
    assert recover_recording(found).ticks == 8, "also where it is torn"


def test_a_recording_with_another_compression_gets_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = compressed(tmp_path, CompressionType.LZ4, monkeypatch)
    with pytest.raises(RecordingError, match="compressed as 'lz4'"):
        read_episode(found)
    assert read_summary(found).ticks == 8, "that is in its metadata"


@pytest.mark.parametrize("times", [0, 2, 1500])
def test_a_chunk_in_a_chunk_and_one_that_cannot_be_unpacked_get_a_sentence(times: int) -> None:
    content = b"no frame of zstd"
    for _ in range(times + 1):
        content = chunk_of(zstandard.compress(content) if times else content)
    with pytest.raises(RecordingError, match="a chunk is in a chunk" if times else "ZstdError"):
        episode_of_journal(MAGIC + content, "deep")


def chunk_of(packed: bytes) -> bytes:
    body = struct.pack("<QQQII", 0, 0, 1 << 16, 0, 4) + b"zstd" + struct.pack("<Q", len(packed)) + packed
    return struct.pack("<BQ", 0x06, len(body)) + body


def mcap(folder: Path, profile: str, metadata: dict[str, str]) -> Path:
    stream = io.BytesIO()
    writer = Writer(stream, enable_data_crcs=True)
    writer.start(profile=profile)
    writer.add_metadata("episode", metadata)
    writer.finish()  # type: ignore[no-untyped-call]
    path = folder / "other.mcap"
    path.write_bytes(stream.getvalue())
    return path


def test_a_plain_mcap_reader_sees_metadata_attachments_and_every_topic(finished: Path) -> None:
    with finished.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        attachments = [attachment.name for attachment in reader.iter_attachments()]
        topics = {channel.topic for _, channel, _ in reader.iter_messages()}
    assert metadata["episode"]["map"] == "HandOff"
    assert metadata["seat/0"] == {
        "colour": "blue",
        "kind": "human",
        "name": "P-3f2a",
        "checkpoint_sha256": "",
        "device": "gamepad",
    }
    assert metadata["study"] == {"study_id": "pilot", "session": "s-17"}
    assert metadata["recording"]["complete"] == "true"
    assert metadata["recording"]["ticks"] == "8"
    assert metadata["result"].keys() == {"delivered", "items", *KEYS}
    assert attachments == ["map.json"]
    assert topics == {
        *("/map", "/state", "/actions", "/inputs", "/events", "/agent/red", "/timing", "/metrics"),
        *("/scene/static", "/scene/bodies", "/tf", "/log"),
    }


def test_the_timeline_is_even_and_publish_time_is_the_wall_clock(finished: Path) -> None:
    with finished.open("rb") as stream:
        states = [message for _, _, message in make_reader(stream).iter_messages(topics=["/state"])]
    start = states[0].log_time
    assert [message.log_time - start for message in states] == [100_000_000 * tick for tick in range(9)]
    assert all(a.publish_time < b.publish_time for a, b in pairwise(states))


def test_viewers_can_draw_the_scene_without_set_up(finished: Path) -> None:
    with finished.open("rb") as stream:
        messages = list(make_reader(stream).iter_messages(topics=["/scene/static", "/scene/bodies", "/tf"]))
    by_topic: dict[str, list[bytes]] = {}
    for schema, channel, message in messages:
        assert schema is not None and schema.encoding == "protobuf" and schema.name.startswith("foxglove.")
        by_topic.setdefault(channel.topic, []).append(message.data)
    bodies = SceneUpdate.FromString(by_topic["/scene/bodies"][0])
    assert [entity.frame_id for entity in bodies.entities] == ["blue", "red", "item/0", "item/1", "item/2", "item/3"]
    assert all(entity.frame_locked and entity.triangles for entity in bodies.entities)
    static = SceneUpdate.FromString(by_topic["/scene/static"][0])
    assert [entity.id for entity in static.entities] == ["arena", "goal/0", "wall/0", "wall/1"]
    state = read_episode(finished).states[-1]
    last = FrameTransforms.FromString(by_topic["/tf"][-1])
    assert [transform.child_frame_id for transform in last.transforms][:2] == ["blue", "red"]
    assert (last.transforms[1].translation.x, last.transforms[1].translation.y) == tuple(state.robot_poses[1, :2])


def test_running_metrics_follow_every_state(finished: Path) -> None:
    with finished.open("rb") as stream:
        reader = make_reader(stream)
        rows = [json.loads(message.data) for _, _, message in reader.iter_messages(topics=["/metrics"])]
        result = {record.name: record.metadata for record in reader.iter_metadata()}["result"]
    assert [row["tick"] for row in rows] == list(range(9))
    assert {name: repr(float(rows[-1][name])) for name in KEYS} == {name: result[name] for name in KEYS}
