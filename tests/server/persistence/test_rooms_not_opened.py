"""Rooms that cannot be opened at a start, such as for want of an agent's package: nothing of a game is lost by that."""

import asyncio
from pathlib import Path

import msgspec
import pytest

from movingout.maps import load_map
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server import messages as m
from movingout.server.agent_workers.agent_seat import AgentSeat
from movingout.server.cluster.host import ClusterHost
from movingout.server.host import Host
from movingout.server.monitoring.status import room_report
from movingout.server.persistence.room_snapshot import room_file
from movingout.server.persistence.room_store import RoomFile
from movingout.server.room_host import RoomHost, RoomKept
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.settings import Settings

ROUND = "round-1"


def kept_room(data: Path, study: dict[str, str], agent_id: str = "of-a-package") -> RoomFile:
    """The room of a server that has ended; an agent sits in it, by default one that is not there any more."""
    host = Host(Settings(data=data))
    host.settings.rooms.mkdir()
    room = host.registry.open(RoomConfig(maps=("Simple",), study=study), [Seat(0, "human"), Seat(1, "idle")])
    file = msgspec.structs.replace(room_file(room, saved=0.0), episode=ROUND)
    file.seats[1].kind, file.seats[1].agent_id = "agent", agent_id
    host.store.save(file)
    host.store.close()
    return file


def restored(host: RoomHost) -> RoomHost:
    for file in list(host.store.load()):
        asyncio.run(host.restore(file))
    host.store.flush()
    return host


def test_a_room_without_its_agent_waits_for_the_next_start_and_so_does_its_journal(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = kept_room(tmp_path, {})
    without = restored(Host(Settings(data=tmp_path)))
    assert not without.registry.rooms
    assert without.episodes() == [ROUND], "its journal is not finished"
    assert f"room {file.id} does not come back now; its file and the recording" in caplog.text
    assert f"to end it, remove {file.id}.json below {tmp_path / 'rooms'}" in caplog.text
    without.store.close()

    file.seats[1].agent_id = "scripted"  # as if the package were there again
    (tmp_path / "rooms" / f"{file.id}.json").write_bytes(msgspec.json.encode(file))
    again = restored(Host(Settings(data=tmp_path)))
    assert [*again.registry.rooms] == [file.id]
    again.store.close()


def test_who_comes_back_to_such_a_room_hears_that_it_is_kept_and_comes_again(tmp_path: Path) -> None:
    file = kept_room(tmp_path, {})
    host = Host(Settings(data=tmp_path))
    restored(host)
    said = host.endpoint.absence(file.id), host.endpoint.absence("nowhere")
    assert [(each.code, each.notice.code) for each in said] == [
        (m.CLOSE_SHUTDOWN, "room_kept"),
        (m.CLOSE_NOT_FOUND, "no_room"),
    ]
    with pytest.raises(RoomKept) as kept:
        asyncio.run(host.ask(file.id, lambda room: room.id))
    assert kept.value.code == "room_kept"
    assert room_report(host)["rooms_not_opened"] == 1
    host.store.close()


def test_without_its_file_such_a_room_ends_and_the_next_start_finishes_its_recording(tmp_path: Path) -> None:
    file = kept_room(tmp_path, {})
    restored(Host(Settings(data=tmp_path))).store.close()
    (tmp_path / "rooms" / f"{file.id}.json").unlink()
    host = restored(Host(Settings(data=tmp_path)))
    assert host.episodes() == []
    host.store.close()


def test_a_study_takes_such_a_round_as_it_was_recorded(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    kept_room(tmp_path, {"study": "morning", "unit": "1"})
    host = restored(Host(Settings(data=tmp_path)))
    assert host.episodes() == []
    assert not list((tmp_path / "rooms").iterdir()), "no pseudonym is left behind"
    assert "its round ends where it was interrupted" in caplog.text
    host.store.close()


def node(data: Path, monkeypatch: pytest.MonkeyPatch) -> ClusterHost:
    host = ClusterHost(Settings(data=data, cluster="postgresql://nowhere/none", node="a"))
    monkeypatch.setattr(host.node.leases, "valid", lambda shard, now: True)
    return host


def test_a_node_keeps_them_until_it_lets_go_of_the_shard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = kept_room(tmp_path, {})
    shard = file.id[0]
    host = node(tmp_path, monkeypatch)
    host.settings.recordings.mkdir()
    (host.settings.recordings / f"{shard}{ROUND}{JOURNAL_SUFFIX}").touch()
    file.episode = f"{shard}{ROUND}"
    monkeypatch.setattr(host.store, "delete", lambda room_id: pytest.fail("the room is lost"))
    asyncio.run(host._bring(file, shard))
    assert host.episodes() == [file.episode]
    monkeypatch.setattr(host.node, "serves", lambda shard: True)
    assert host.endpoint.absence(file.id).notice.code == "room_kept"
    host._recover_shard(shard)  # would ask the recording service, which was not started
    host.close_shard(shard)
    assert host.episodes() == []
    host.store.close()


def test_a_node_refuses_no_agent_of_a_room_that_it_takes_over_as_too_slow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = kept_room(tmp_path, {}, "idle")
    host = node(tmp_path, monkeypatch)
    asyncio.run(host._bring(file, file.id[0]))
    seats = [host.registry.rooms[file.id].seats[1].player, host.agents.open("idle", load_map("Simple"), 1, 0, 500)]
    assert [seat._opening.must_keep_up for seat in seats if isinstance(seat, AgentSeat)] == [False, True]
    assert host.agents._limited, "its place counts, as those of the other rooms do"
    host.store.close()
