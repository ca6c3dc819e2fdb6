"""Two whole nodes on one database, without a proxy: what each says of rooms that are at the other, or waiting."""

import asyncio
import math
import shutil
from pathlib import Path
from typing import Any

import pytest

from movingout.recordings.verification import verify
from movingout.server import messages as m
from movingout.server.cli import main
from movingout.server.cluster.app import create_cluster_app
from movingout.server.cluster.errors import DatabaseAway, NodeRefused
from movingout.server.cluster.shards import shard_of
from movingout.server.persistence.data_folder import exclusive_data_folder
from movingout.server.settings import Settings
from tests.database import PostgresServer
from tests.server.cluster.nodes import host, node
from tests.server.cluster.processes import wait_until
from tests.server.live import ADMIN, Live, Person, serve

ROUND = 40
SEATS = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]}


def wait_for_rooms(live: Live) -> None:
    wait_until(lambda: live.call("/readyz")[0] == 200, "the node takes rooms")


def opened(live: Live, **config: Any) -> tuple[str, Person]:
    """A room whose only person plays."""
    wait_for_rooms(live)
    room = live.open_room("here", "idle", limit_ticks=ROUND, **config)
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0, ready=True)
    return room["room"], person


@pytest.mark.slow
def test_a_node_that_ends_hands_its_rooms_over_and_they_go_on(tmp_path: Path, database: str) -> None:
    with node(tmp_path, database, "b") as b:
        with node(tmp_path, database, "a") as a:
            room, person = opened(a)
            assert shard_of(room) == host(a).node.home != host(b).node.home
            assert a.call(f"/cluster/rooms/{shard_of(room)}")[0] == 200
            assert b.call(f"/cluster/rooms/{shard_of(room)}")[0] == 404
            wait_until(lambda: b.call(f"/api/rooms/{room}")[0] == 503, "b knows of the room")
            assert b.call(f"/api/rooms/{room}")[1]["error"]["code"] == "moving"
            assert b.call("/api/rooms/zzzzzzzzzzzz")[0] in (404, 503)
            person.play(10)
            wait_until(lambda: host(a).node.leases.shared, "a knows of b")
            wait_until(lambda: (row := host(b).node.view.lease(shard_of(room))) and row.shared, "b knows that, too")
            assert a.server is not None
            a.server.should_exit = True
            assert person.end()[0] == m.CLOSE_SHUTDOWN
        wait_until(lambda: b.call(f"/api/rooms/{room}")[0] == 200, "b has taken the room over")
        assert host(b).admission.rooms_of("127.0.0.1") == {room}, "who opened it at a has it at b"
        again = b.person(room, tokens=[person.tokens[0]])
        again.say(type="ready", seat=0, ready=True)
        path = tmp_path / "recordings" / f"{again.play_out()['recording']}.mcap"
        wait_until(path.exists, "the recording is finished")
        assert verify(path).identical and again.bundles[-1].tick == ROUND
        report = b.call("/api/admin/state", token=ADMIN)[1]["cluster"]
        assert [(row["name"], row["state"]) for row in report["nodes"]] == [("a", "ended"), ("b", "serving")]
        assert b.call(f"/api/admin/rooms/{room}/close", {}, token=ADMIN)[0] == 200
        wait_until(lambda: shard_of(room) not in host(b).node.leases, "the shard is given back")


@pytest.mark.slow
def test_the_admin_closes_the_rooms_of_an_address_at_all_nodes(tmp_path: Path, database: str) -> None:
    behind = {"trusted_proxies": ("127.0.0.1",)}
    with node(tmp_path / "a", database, "a", **behind) as a, node(tmp_path / "b", database, "b", **behind) as b:
        rooms: dict[tuple[int, str], str] = {}
        for live in (a, b):
            wait_for_rooms(live)
            for address in ("192.0.2.7", "192.0.2.8"):
                rooms[live.port, address] = live.call("/api/rooms", SEATS, **{"X-Forwarded-For": address})[1]["room"]
        wait_until(lambda: len(host(a)._nodes()) == 2, "a knows of b")
        path = f"/api/admin/rooms/{rooms[a.port, '192.0.2.7']}/close-address"
        assert a.call(path, {}, token=ADMIN) == (200, {"closed": 2})
        for live in (a, b):
            left = {row["room"] for row in live.call("/api/admin/state", token=ADMIN)[1]["rooms"]}
            assert left == {rooms[live.port, "192.0.2.8"]}


@pytest.mark.slow
def test_a_node_comes_back_to_its_rooms(tmp_path: Path, database: str) -> None:
    with node(tmp_path, database, "a") as a:
        room, person = opened(a)
        person.play(8)
    with node(tmp_path, database, "a") as a:
        assert host(a).node.home == shard_of(room)
        again = a.person(room, tokens=[person.tokens[0]])
        again.say(type="ready", seat=0, ready=True)
        path = tmp_path / "recordings" / f"{again.play_out()['recording']}.mcap"
        wait_until(path.exists, "the recording is finished")
        assert verify(path).identical


@pytest.mark.slow
def test_rooms_and_rounds_of_a_server_that_was_no_node_go_on_at_a_node(tmp_path: Path, database: str) -> None:
    with serve(tmp_path) as alone:
        room = alone.open_room("here", "idle", limit_ticks=ROUND)
        person = alone.person(room["room"], tokens=room["tokens"][:1])
        person.say(type="ready", seat=0, ready=True)
        person.play(8)
    with node(tmp_path, database, "a") as a:
        again = a.person(room["room"], tokens=[person.tokens[0]])
        again.say(type="ready", seat=0, ready=True)
        path = tmp_path / "recordings" / f"{again.play_out()['recording']}.mcap"
        wait_until(path.exists, "the recording is finished")
        assert verify(path).identical


@pytest.mark.slow
def test_recordings_of_a_shard_that_another_folder_has_are_finished_where_they_lie(
    tmp_path: Path, database: str
) -> None:
    with node(tmp_path / "a", database, "a") as a, node(tmp_path / "b", database, "b") as b:
        _, person = opened(b)
        person.play(8)
        wait_until(lambda: len(host(a)._nodes()) == 2, "a knows of b")
        [there] = (tmp_path / "b" / "recordings").glob("*.journal")
        left = tmp_path / "a" / "recordings" / there.name  # as a weekend ago, when a had this shard
        shutil.copy(there, left)
        own = opened(a)[1]
        own.play(5)
        asyncio.run_coroutine_threadsafe(host(a)._recover_left(), a.loop).result(30)
        wait_until(left.with_suffix("").exists, "the recording is finished")
        assert not left.exists()
        own.play_out()


@pytest.mark.slow
def test_a_lost_lease_ends_the_rooms_here_and_a_connection_hears_where_they_are(tmp_path: Path, database: str) -> None:
    import psycopg

    with node(tmp_path, database, "a") as a:
        room, person = opened(a)
        person.play(5)
        with psycopg.connect(database, autocommit=True) as connection:
            connection.execute(
                "UPDATE movingout_cluster.lease SET fence = fence + 1, node = 'x', run = 'y', "
                "expires = now() + interval '1 hour' WHERE shard = %s",
                (shard_of(room),),
            )
        code, said = person.end()
        assert code == m.CLOSE_SHUTDOWN and said[-1]["error"] == "moving"
        assert a.call(f"/api/rooms/{room}")[1]["error"]["code"] == "moving"
        wait_until(lambda: a.call("/readyz")[0] == 200, "the node goes on with another shard")
        other, _ = opened(a)
        assert shard_of(other) != shard_of(room)


@pytest.mark.slow
def test_a_node_without_its_database_says_so_and_not_that_it_restarts(
    tmp_path: Path, database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with node(tmp_path, database, "a") as a:
        wait_for_rooms(a)
        monkeypatch.setattr(host(a).node, "_say", lambda _: None)
        monkeypatch.setattr(host(a).node.open_shards, "since", lambda _: math.inf)  # as when its lease has run out
        assert a.call("/readyz")[1]["reasons"] == ["The server is being restarted; try again in a minute."]
        monkeypatch.setattr(host(a).node, "problem", "the database of the cluster is away")
        assert a.call("/readyz") == (503, {"ready": False, "reasons": ["the database of the cluster is away"]})


def test_what_a_node_cannot_start_with_is_a_sentence(
    tmp_path: Path, database: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(*options: str) -> str:
        assert main(["play", "--port", "0", "--data", str(tmp_path), *options]) == 2
        return capsys.readouterr().err

    assert "needs both" in refused("--node", "a")
    assert "needs both" in refused("--cluster", database)
    assert "needs both" in refused("--lease", "10")
    assert "one process" in refused("--cluster", database, "--node", "a", "--processes", "31")
    assert "leave --tls out" in refused("--cluster", database, "--node", "a", "--tls", "--processes", "1")
    assert "does not answer" in refused("--cluster", "postgresql://x@127.0.0.1:1/x", "--node", "a")
    assert "belongs to nodes of a cluster (a)" in refused("--processes", "1")
    with exclusive_data_folder(tmp_path / "other"):
        assert main(["play", "--data", str(tmp_path / "other"), "--cluster", database, "--node", "a"]) == 2
    assert "no node of a cluster" in capsys.readouterr().err


@pytest.mark.slow
def test_a_node_of_another_version_is_refused(
    tmp_path: Path, database: str, database_server: PostgresServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    with node(tmp_path, database, "a"):
        monkeypatch.setattr("movingout.server.cluster.host.FORMAT", "rooms 99")
        monkeypatch.setattr("movingout.__version__", "9.9")
        wait_until(lambda: list(tmp_path.glob("rooms/*")), "it has a shard")
        with pytest.raises(NodeRefused, match=r"this node has version 9\.9.*end these first"):
            create_cluster_app(Settings(data=tmp_path, cluster=database, node="b"))
    with pytest.raises(DatabaseAway):
        create_cluster_app(Settings(data=tmp_path, cluster=database.rsplit("/", 1)[0] + "/none", node="b"))
