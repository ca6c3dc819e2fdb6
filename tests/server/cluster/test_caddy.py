"""Two real nodes behind a real Caddy: rooms and a study are found, also after the node that had them was killed."""

import signal
import time
from pathlib import Path

import pytest

from movingout.recordings.verification import verify
from movingout.server.cluster.shards import shard_of
from movingout.server.security.certificate import certificate_in
from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.simulation_plan import SimulationPlan
from tests.database import PostgresServer
from tests.server.cluster.processes import NodeProcess, caddy, come_back, free_port, status, wait_until
from tests.server.cluster.study_nodes import study_cluster, through
from tests.server.live import Live, Person

ROUND = 60  # ticks
SEATS = [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]


def start(live: Live, node: NodeProcess) -> tuple[str, Person]:
    """A room at this node whose only person plays."""

    def opened() -> dict[str, object] | None:
        code, room = live.call("/api/rooms", {"maps": ["Simple"], "seats": SEATS, "limit_ticks": ROUND})
        return room if code == 200 and node.has(shard_of(room["room"])) else None

    room = wait_until(opened, "a room at that node")
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0, ready=True)
    return room["room"], person


@pytest.mark.slow
def test_rooms_are_found_behind_caddy_and_go_on_when_their_node_is_killed(
    tmp_path: Path, database_server: PostgresServer
) -> None:
    database = database_server.new_database()
    nodes = [NodeProcess(name, free_port(), tmp_path / "data", database) for name in ("a", "b")]
    with caddy(tmp_path, nodes) as live:
        away = wait_until(lambda: (answer := live.call("/"))[0] == 503 and answer[1], "the proxy answers by itself")
        assert b"This page comes back by itself" in away and "kommt von selbst zurück" in away.decode()
        try:
            for node in nodes:
                node.start()
            for node in nodes:
                wait_until(node.is_ready, f"node {node.name} is ready")
            time.sleep(3.0)  # the checks of all shards
            private = ("/healthz", "/readyz", "/metrics", "/cluster/rooms/a")
            assert [status(live.port, path) for path in private] == [404] * 4
            room, person = start(live, nodes[0])
            assert live.call(f"/api/rooms/{room}")[1]["room"] == room
            person.play(20)
            nodes[0].send(signal.SIGKILL)
            person.end()
            returned = come_back(live, room, person.tokens[0])
            path = nodes[1].data / "recordings" / f"{returned.play_out()['recording']}.mcap"
            wait_until(path.exists, "the recording is finished")
            assert verify(path).identical
            assert returned.bundles[0].tick <= 22 and returned.bundles[-1].tick == ROUND
        finally:
            for node in nodes:
                if node.process is not None:
                    node.end(signal.SIGKILL)


@pytest.mark.slow
def test_a_study_is_taken_part_in_over_tls_while_the_node_that_runs_it_is_killed(
    tmp_path: Path, database_server: PostgresServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = certificate_in(tmp_path / "tls", "127.0.0.1")
    pem = tmp_path / "site.pem"
    pem.write_bytes(made.certificate.read_bytes() + made.key.read_bytes())
    monkeypatch.setenv("SSL_CERT_FILE", str(made.certificate))  # whom the participants trust
    with study_cluster(tmp_path, database_server.new_database(), certificate=str(pem)) as cluster:

        def trouble(cohort: Cohort) -> None:
            wait_until(through(3, cohort), "rounds begin")
            killed = cluster.leader()
            killed.kill()
            wait_until(cluster.is_served, "the other node goes on")
            killed.start()

        cluster.check(cluster.take_part(SimulationPlan(4, speed=10.0, at_once=2), trouble))
