"""Files of rooms by shard and fencing token: what a node that has lost a lease still writes reaches nobody."""

import time
from pathlib import Path

import pytest

from movingout.maps.files.file_lock import lock_file
from movingout.server.cluster import room_files
from movingout.server.cluster.room_files import (
    ShardedRoomStore,
    adopt,
    discard,
    folder_id,
    has_files_of,
    has_rooms_of,
    journals_of,
    shards_in,
)
from movingout.server.cluster.shards import SHARDS, new_id_in, shard_of
from movingout.server.persistence.room_store import VERSION, RoomFile, RoomStore
from movingout.server.rooms.services import RoomConfig


def room(name: str, epoch: int = 0, saved: float = 4e9) -> RoomFile:
    return RoomFile(
        version=VERSION,
        id=name,
        saved=saved,
        config=RoomConfig(maps=("Simple",)),
        seats=[],
        phase="lobby",
        reason="",
        index=0,
        epoch=epoch,
        episode="",
        results=[],
    )


def store(folder: Path, **fences: int) -> ShardedRoomStore:
    return ShardedRoomStore(folder, fences.get)


def test_the_first_letter_says_the_shard() -> None:
    assert len(set(SHARDS)) == 32
    assert all(shard_of(new_id_in(shard)) == shard and len(new_id_in(shard)) == 12 for shard in SHARDS)
    assert shard_of("") == shard_of("Ka") == shard_of("../x") == ""


def test_whoever_takes_a_shard_has_its_rooms_and_the_former_node_writes_into_nothing(tmp_path: Path) -> None:
    recordings = tmp_path / "recordings"
    recordings.mkdir()
    adopt(tmp_path, recordings, "k", 1)
    former = store(tmp_path, k=1)
    former.save(room("kaaa"))
    former.save(room("maaa"))  # of a shard that it does not have
    former.flush()
    journal = recordings / "kbbb.mcap.journal"
    journal.write_bytes(b"ticks")
    with journal.open("ab") as still_open:
        adopt(tmp_path, recordings, "k", 2)
        former.save(room("kaaa", epoch=9))
        former.save(room("kccc"))
        former.flush()
        still_open.write(b", and one too many")
    assert journal.read_bytes() == b"ticks"
    assert [file.epoch for file in store(tmp_path, k=2).load_shard("k", 2)] == [0]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["k.2", "recordings"]
    assert has_rooms_of(tmp_path, "k") and not has_rooms_of(tmp_path, "m")
    former.close()


def test_the_newest_files_count_and_a_half_made_copy_does_not(tmp_path: Path) -> None:
    for fence in (3, 20):
        adopt(tmp_path, tmp_path, "k", fence)
        made = store(tmp_path, k=fence)
        made.save(room("kaaa", epoch=fence))
        made.close()
    (tmp_path / "k.21.part").mkdir()
    adopt(tmp_path, tmp_path, "k", 21)
    adopt(tmp_path, tmp_path, "k", 21)  # the same node again
    assert [file.epoch for file in store(tmp_path, k=21).load_shard("k", 21)] == [20]


def test_rooms_come_along_whatever_the_clocks_of_the_nodes_say(tmp_path: Path) -> None:
    adopt(tmp_path, tmp_path, "k", 1)
    made = store(tmp_path, k=1)
    for name, saved in (("kaaa", 0.0), ("kbbb", 4e9)):  # in 1970, and in 2096
        made.save(room(name, saved=saved))
    made.close()
    adopt(tmp_path, tmp_path, "k", 2)
    assert [file.id for file in store(tmp_path, k=2).load_shard("k", 2)] == ["kaaa", "kbbb"]


def test_journals_of_a_shard_are_found_by_their_letter(tmp_path: Path) -> None:
    for name in ("kaa.mcap.journal", "kab.mcap", ".kac.mcap.journal.x", "mad.mcap.journal"):
        (tmp_path / name).touch()
    assert [path.name for path in journals_of(tmp_path, "k")] == ["kaa.mcap.journal"]


def test_rooms_of_a_server_that_was_no_node_come_along_and_whoever_left_something_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room_files, "GROWS_S", 0.0)
    rooms, recordings = tmp_path / "rooms", tmp_path / "recordings"
    recordings.mkdir()
    adopt(rooms, recordings, "m", 3)
    alone, of_a_node = RoomStore(rooms), store(rooms, m=3)
    alone.save(room("kaaa"))
    of_a_node.save(room("maaa"))
    alone.close()
    of_a_node.close()
    (rooms / "p.9.part").mkdir()
    (rooms / "p.9.part" / "paaa.json").touch()  # a half-made copy
    (recordings / "faaa.mcap.journal").touch()
    assert shards_in(rooms, recordings) == {"k", "m", "f"}
    adopt(rooms, recordings, "k", 1)
    assert [file.id for file in store(rooms, k=1).load_shard("k", 1)] == ["kaaa"]
    assert not list(rooms.glob("*.json")) and shards_in(rooms, recordings) == {"k", "m", "f"}


def test_what_somebody_still_writes_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for shard in "kmp":
        (tmp_path / f"{shard}aaa.json").touch()
        (tmp_path / f"{shard}bbb.mcap.journal").touch()
    with (tmp_path / "kbbb.mcap.journal").open("r+") as locked:
        assert lock_file(locked.fileno())
        monkeypatch.setattr(time, "sleep", lambda _: (tmp_path / "mbbb.mcap.journal").write_bytes(b"a tick"))
        assert shards_in(tmp_path, tmp_path) == {"p"}, "k is locked, m grows"
    assert shards_in(tmp_path, tmp_path) == {"k", "m", "p"}


def test_a_file_that_is_not_understood_stays_when_its_shard_is_given_back(tmp_path: Path) -> None:
    (tmp_path / "kaaa.json").write_text("{", encoding="ascii")
    adopt(tmp_path, tmp_path, "k", 1)
    assert has_files_of(tmp_path, "k") and not has_files_of(tmp_path, "m")
    assert list(store(tmp_path, k=1).load_shard("k", 1)) == []
    assert not has_files_of(tmp_path, "k")
    (tmp_path / "k.1" / "kbbb.tmp").touch()  # of a crash
    discard(tmp_path, "k", 1)
    adopt(tmp_path, tmp_path, "k", 2)
    discard(tmp_path, "k", 2)
    assert [path.name for path in tmp_path.rglob("*.*") if path.is_file()] == ["kaaa.json.not-understood"]
    (tmp_path / "m.0.part").mkdir()
    (tmp_path / "m.0.part" / "maaa.json").touch()  # of a crash while it was taken
    assert not has_files_of(tmp_path, "m")
    adopt(tmp_path, tmp_path, "m", 1)
    assert not (tmp_path / "m.0.part").exists()
    discard(tmp_path, "m", 1)
    assert not (tmp_path / "m.1").exists()


def test_a_data_folder_has_one_id_for_all_who_share_it(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    assert folder_id(one) == folder_id(one) != folder_id(other)
    assert len(folder_id(one)) == 20 and [path.name for path in one.iterdir()] == ["cluster-folder"]
