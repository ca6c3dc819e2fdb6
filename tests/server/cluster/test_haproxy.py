"""Two real nodes behind a real HAProxy: where rooms are found, and what happens when a node ends, dies or hangs."""

import asyncio
import contextlib
import http.client
import json
import signal
import ssl
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from movingout.recordings.verification import verify
from movingout.server.cli import main
from movingout.server.cluster.lease_store import LeaseStore
from movingout.server.cluster.proxy_config import ProxyLimits
from movingout.server.cluster.shards import STUDY, shard_of
from movingout.server.security.certificate import certificate_in
from tests.database import PostgresServer
from tests.server.cluster.clock import identity
from tests.server.cluster.lease_watch import LeaseWatch
from tests.server.cluster.processes import LEASE_S, NodeProcess, come_back, free_port, haproxy, status, wait_until
from tests.server.live import Live, Person

ROUND = 60  # ticks


@pytest.fixture(scope="module")
def nodes(tmp_path_factory: pytest.TempPathFactory, database_server: PostgresServer) -> Iterator[list[NodeProcess]]:
    folder, database = tmp_path_factory.mktemp("cluster"), database_server.new_database()
    nodes = [NodeProcess(name, free_port(), folder / "data", database) for name in ("a", "b")]
    for node in nodes:
        node.start()
    try:
        yield nodes
    finally:
        for node in nodes:
            node.end(signal.SIGKILL)


@pytest.fixture
def live(nodes: list[NodeProcess], tmp_path: Path) -> Iterator[Live]:
    for node in nodes:
        if node.has_ended:  # a test that failed left it so
            node.start()
        wait_until(node.is_ready, f"node {node.name} is ready")
    with haproxy(tmp_path, nodes) as live:
        wait_until(lambda: status(live.port, "/") == 200, "the proxy finds a node")
        time.sleep(3.0)  # its checks of all shards
        yield live


def start(live: Live, nodes: list[NodeProcess], at: int, limit_ticks: int = ROUND) -> tuple[str, Person]:
    """A room at a certain node whose only person plays."""
    seats = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]
    wanted = {"maps": ["Simple"], "seats": seats, "limit_ticks": limit_ticks}
    while True:
        _, room = wait_until(lambda: opened(live, wanted), "a room can be opened")
        if nodes[at].has(shard_of(room["room"])):
            break
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0, ready=True)
    return room["room"], person


def opened(live: Live, wanted: dict[str, Any]) -> tuple[int, dict[str, Any]] | None:
    """None while the machine is too busy for one more room."""
    code, answer = live.call("/api/rooms", wanted)
    return (code, answer) if code == 200 else None


def recording(node: NodeProcess, person: Person) -> Path:
    """Play the round to its end; its recording, once it is finished."""
    path = node.data / "recordings" / f"{person.play_out()['recording']}.mcap"
    wait_until(path.exists, f"{path.name} is finished")
    return path


def again_ready(node: NodeProcess) -> None:
    node.start()
    wait_until(node.is_ready, f"node {node.name} is ready again")


@pytest.mark.slow
def test_rooms_are_found_through_the_proxy_wherever_they_are(live: Live, nodes: list[NodeProcess]) -> None:
    for at in (0, 1):
        room, person = start(live, nodes, at)
        assert live.call(f"/api/rooms/{room}")[1]["room"] == room
        path = recording(nodes[at], person)
        assert [bundle.tick for bundle in person.bundles] == list(range(1, ROUND + 1))
        assert verify(path).identical
        assert live.call(f"/api/recordings/{path.stem}")[0] == 200
    assert live.call("/api/rooms/zzzzzzzzzzzz")[0] == 404
    private = ("/healthz", "/readyz", "/metrics", "/cluster/rooms/a", "/%63luster/rooms/a", "/%68ealthz")
    assert [status(live.port, path) for path in private] == [404] * 6


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM])
def test_when_a_node_is_gone_its_players_go_on_at_the_other_whose_own_miss_nothing(
    live: Live, nodes: list[NodeProcess], how: signal.Signals
) -> None:
    gone, other = nodes
    room, person = start(live, nodes, at=0, limit_ticks=ROUND)
    _, beside = start(live, nodes, at=1, limit_ticks=150)
    thread = threading.Thread(target=beside.play_out)
    thread.start()
    person.play(20)
    with LeaseWatch(gone.database, shard_of(room), gone.name) as lease:
        gone.send(how)
        person.end()
        returned = come_back(live, room, person.tokens[0])
    assert lease.after_s < LEASE_S, "taken within a lease length after it was over"
    assert (lease.after_s < 0.0) == (how == signal.SIGTERM), "before its end where it was given back, never else"
    path = recording(other, returned)
    assert verify(path).identical
    assert returned.bundles[0].tick <= 22 and returned.bundles[-1].tick == ROUND
    thread.join(60)
    assert [bundle.tick for bundle in beside.bundles] == list(range(1, 151))
    if how == signal.SIGSTOP:
        gone.send(signal.SIGCONT)
        wait_until(lambda: not gone.has(shard_of(room)), "it has noticed")
        wait_until(gone.is_ready, "it goes on with a shard of its own")
        assert status(gone.port, f"/api/rooms/{room}") == 503
    else:
        assert gone.process is not None
        gone.process.wait(60)
        again_ready(gone)


@pytest.mark.slow
def test_the_proxy_speaks_tls_tells_browsers_to_stay_with_it_and_counts_addresses(
    nodes: list[NodeProcess], tmp_path: Path
) -> None:
    wait_until(nodes[1].is_ready, "node b is ready")
    made = certificate_in(tmp_path, "127.0.0.1")
    pem = tmp_path / "site.pem"
    pem.write_bytes(made.certificate.read_bytes() + made.key.read_bytes())
    few = ProxyLimits(connections=300, requests_per_10s=30)
    redirect = f"127.0.0.1:{free_port()}"
    with haproxy(tmp_path, nodes[1:], certificate=str(pem), redirect_from=redirect, limits=few) as live:

        def get(path: str = "/", **headers: str) -> tuple[int, str | None]:
            """The status of a page or an answer, and what it says of https."""
            trusting = ssl._create_unverified_context()
            connection = http.client.HTTPSConnection("127.0.0.1", live.port, context=trusting, timeout=30)
            with contextlib.closing(connection):
                connection.request("GET", path, headers=headers)
                answer = connection.getresponse()
                answer.read()
                return answer.status, answer.headers["strict-transport-security"]

        def calm() -> bool:
            time.sleep(1.0)  # not to use up the requests
            return get() == (200, "max-age=31536000")

        wait_until(calm, "the proxy finds a node")
        assert [get("/static/theme.js")[0] for _ in range(40)] == [200] * 40, "a page has many files"
        many = threading.Thread(target=lambda: [get("/api/maps") for _ in range(40)])
        many.start()
        wait_until(lambda: get("/api/maps", X_Forwarded_For="9.9.9.9")[0] == 429, "requests of an address are counted")
        many.join(60)
        assert get()[0] == 200, "who may not ask any more still sees a page"


@pytest.mark.slow
def test_who_comes_while_no_node_is_there_sees_a_calm_page(tmp_path: Path) -> None:
    nobody = NodeProcess("a", free_port(), tmp_path, "")
    with haproxy(tmp_path, [nobody]) as live:

        def page() -> Any:
            status_code, body = live.call("/")
            return status_code == 503 and body.decode()

        text = wait_until(page, "the proxy answers by itself")
    assert "This page comes back by itself" in text and "kommt von selbst zurück" in text and "refresh" in text


def test_status_of_a_cluster_without_nodes_names_none(database: str, capsys: pytest.CaptureFixture[str]) -> None:
    async def prepare() -> None:
        store = LeaseStore(database)
        await store.prepare()
        await store.close()

    asyncio.run(prepare())
    assert main(["cluster", "status", "--cluster", database, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"nodes": [], "waiting": [], "unserved": []}


def test_status_tells_which_node_runs_the_study_and_none_when_that_has_ended(
    database: str, capsys: pytest.CaptureFixture[str]
) -> None:
    who = identity("a")

    def runs_study() -> list[bool]:
        main(["cluster", "status", "--cluster", database, "--json"])
        return [node["runs_study"] for node in json.loads(capsys.readouterr().out)["nodes"]]

    async def take() -> None:
        store = LeaseStore(database, lease_s=60.0)
        await store.prepare()
        await store.join(who)
        free = (await store.view()).lease(STUDY)
        assert free is not None and await store.take(who, free, shared=True) == 1
        await store.close()

    async def serve() -> None:
        store = LeaseStore(database, lease_s=60.0)
        await store.renew(who, {STUDY: 1}, {}, shared=True, state="serving")
        await store.close()

    async def leave() -> None:
        store = LeaseStore(database)
        await store.leave(who)
        await store.close()

    asyncio.run(take())
    assert runs_study() == [False], "it is being opened"
    asyncio.run(serve())
    assert runs_study() == [True]
    asyncio.run(leave())
    assert runs_study() == [False]
