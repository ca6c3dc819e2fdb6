"""Which room files a server keeps: a finished round of a study must not leave a pseudonym and a result behind."""

import asyncio
import errno
import json
import os
import time
from pathlib import Path

import msgspec
import pytest

from movingout.agents.errors import AgentsBusyError
from movingout.server import room_host
from movingout.server.agent_workers.capacity import COSTS, AgentCosts
from movingout.server.connection import client_connection
from movingout.server.host import Host
from movingout.server.persistence.room_snapshot import room_file
from movingout.server.persistence.room_store import RoomStore, episodes_of_other_studies
from movingout.server.rooms.player_requests import leave
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.tokens import hash_token
from movingout.server.settings import Settings
from tests.server.live import serve


@pytest.mark.parametrize(("study", "kept"), [({}, True), ({"unit": "7"}, False)], ids=["lobby", "study"])
def test_a_finished_round_of_a_study_leaves_no_room_file(tmp_path: Path, study: dict[str, str], kept: bool) -> None:
    host = Host(Settings(data=tmp_path))
    host.settings.rooms.mkdir()
    seats = [Seat(0, "human", alias="person-1"), Seat(1, "idle")]
    room = host.registry.open(RoomConfig(maps=("Simple",), study=study), seats)
    file = host.settings.rooms / f"{room.id}.json"
    host.store.flush()
    assert "person-1" in file.read_text()
    leave(room, seats[0], now=0.0)
    room.suspend()
    host.save(room)  # as a server does that stops
    host.store.close()
    assert room.phase == "series_over"
    assert file.exists() == kept


def test_rooms_and_rounds_of_another_study_in_the_folder_are_left_alone(tmp_path: Path) -> None:
    host = Host(Settings(data=tmp_path))
    host.settings.rooms.mkdir()
    studies: list[dict[str, str]] = [{"study": "morning", "unit": "1"}, {"study": "afternoon", "unit": "1"}, {}]
    for number, study in enumerate(studies):
        seats = [Seat(0, "human", alias="person-1"), Seat(1, "idle")]
        file = room_file(host.registry.open(RoomConfig(maps=("Simple",), study=study), seats), saved=0.0)
        host.store.save(msgspec.structs.replace(file, episode=f"round-{number}"))
    host.store.flush()
    for served, found in (("morning", [0, 2]), ("afternoon", [1, 2]), ("", [0, 1, 2])):
        kept = RoomStore(host.settings.rooms, served).load()
        assert sorted(file.episode for file in kept) == [f"round-{number}" for number in found]
    assert episodes_of_other_studies(host.settings.rooms, "morning") == {"round-1": "afternoon"}
    assert episodes_of_other_studies(host.settings.rooms, "") == {}
    host.store.close()


@pytest.mark.slow
def test_who_hears_a_new_token_finds_the_seat_again_whenever_the_server_dies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = RoomStore._write

    def slowly(store: RoomStore, room_id: str) -> None:
        time.sleep(0.3)
        write(store, room_id)

    with serve(tmp_path) as live:
        room = live.open_room("here", "idle")
        monkeypatch.setattr(RoomStore, "_write", slowly)
        token = room["tokens"][0]
        for _ in range(3):
            person = live.person(room["room"], tokens=[token])
            token = person.tokens[0]
            kept = json.loads((tmp_path / "rooms" / f"{room['room']}.json").read_text())
            assert kept["seats"][0]["token"] == hash_token(token).hex(), "what was told was kept before"


@pytest.mark.slow
def test_a_disk_that_hangs_keeps_nobody_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client_connection, "KEPT_S", 0.1)

    async def never(store: RoomStore) -> None:
        await asyncio.Event().wait()

    with serve(tmp_path) as live:
        room = live.open_room("here", "idle")
        monkeypatch.setattr(RoomStore, "written", never)
        assert live.person(room["room"], tokens=room["tokens"][:1]).tokens


def test_a_file_that_the_disk_does_not_give_waits_for_the_next_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    host = Host(Settings(data=tmp_path))
    host.settings.rooms.mkdir()
    room = host.registry.open(RoomConfig(maps=("Simple",)), [Seat(0, "human"), Seat(1, "idle")])
    host.store.close()
    (host.settings.rooms / "damaged.json").write_text("{")

    def too_many_files(path: Path) -> bytes:
        raise OSError(errno.EMFILE, "Too many open files")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "read_bytes", too_many_files)
        assert list(host.store.load()) == []
    assert "cannot be read: Too many open files" in caplog.text
    assert [file.id for file in host.store.load()] == [room.id]
    kept = sorted(path.name for path in host.settings.rooms.iterdir())
    assert kept == sorted([f"{room.id}.json", "damaged.json.not-understood"]), "what is not understood is set aside"
    assert "damaged or of another version: left out, and kept as damaged.json.not-understood" in caplog.text


def test_all_rooms_come_back_though_their_agents_seem_to_cost_more_than_when_they_were_opened(tmp_path: Path) -> None:
    first = Host(Settings(data=tmp_path))
    first.settings.rooms.mkdir()
    first.agents.costs.measured("scripted", 0.01)
    opened = [first.registry.open(RoomConfig(maps=("Simple",)), person_and_agent()) for _ in range(4)]
    first.store.close()

    second = Host(Settings(data=tmp_path))  # of a killed server nothing was kept but the rooms
    second.agents.costs.measured("scripted", 10.0)
    for file in list(second.store.load()):
        asyncio.run(second.restore(file))
    with pytest.raises(AgentsBusyError):
        second.registry.open(RoomConfig(maps=("Simple",)), person_and_agent())
    second.store.close()
    assert {*second.registry.rooms} == {room.id for room in opened}
    assert {path.stem for path in second.settings.rooms.iterdir()} == {room.id for room in opened}
    assert all(room.seats[1].player for room in second.registry.rooms.values())


def person_and_agent() -> list[Seat]:
    return [Seat(0, "human"), Seat(1, "agent", agent_id="scripted")]


def test_what_agents_cost_is_kept_while_the_server_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room_host, "COSTS_S", 0.001)
    (tmp_path / "recordings").mkdir()

    async def scenario() -> None:
        host = Host(Settings(data=tmp_path))
        await host.start_rooms()
        host.agents.costs.measured("scripted", 0.02)
        while not (tmp_path / COSTS).exists():
            await asyncio.sleep(0.001)
        await host.background.stop()
        host.store.close()

    asyncio.run(asyncio.wait_for(scenario(), 10.0))
    assert AgentCosts(tmp_path / COSTS).of("scripted") == 0.02


def test_a_pipe_among_the_rooms_holds_no_start(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    os.mkfifo(tmp_path / "abcdefghijk0.json")
    assert list(RoomStore(tmp_path).load()) == []
    assert "is no plain file and is left out" in caplog.text


def test_a_room_is_known_to_nobody_before_a_restart_would_bring_it_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slow_disk(part: Path, path: Path) -> None:
        time.sleep(0.3)
        os.rename(part, path)

    host = Host(Settings(data=tmp_path))
    host.settings.rooms.mkdir()
    monkeypatch.setattr(os, "replace", slow_disk)
    room_id = asyncio.run(host.open_room(RoomConfig(maps=("Simple",)), [Seat(0, "human"), Seat(1, "idle")]))
    assert (host.settings.rooms / f"{room_id}.json").exists()
    host.store.close()
