"""The agent service: one for the rooms of all processes."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from movingout.server.processes.front import Front
from movingout.server.processes.homes import home_of
from tests.server.live import ADMIN, Live, Person
from tests.server.processes.cluster import cluster, home

AGENT = "scripted"


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with cluster(tmp_path_factory.mktemp("agents")) as live:
        yield live


def play(live: Live, at: int) -> tuple[dict[str, Any], Person]:
    """A person beside an agent, in a certain process, when the round has begun."""
    wanted = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": AGENT}], "limit_ticks": 2000}
    deadline = time.monotonic() + 60.0
    while True:
        status, room = live.call("/api/rooms", wanted)
        if status == 200 and home_of(room["room"], 2) == at:
            break
        assert time.monotonic() < deadline, room
        if status == 503:  # agents were late on this machine: a while later they are admitted again
            time.sleep(1.0)
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0, ready=True)
    person.wait_for("room", phase="playing")
    return room, person


def moves(person: Person, ticks: int = 60) -> bool:
    """Whether the agent is elsewhere after some ticks."""
    person.play(1)
    before = person.bundles[-1].poses[-1][1].tolist()
    person.play(ticks)
    after: list[float] = person.bundles[-1].poses[-1][1].tolist()
    return bool(after != before)


def workers(live: Live) -> list[dict[str, float]]:
    rows: list[dict[str, float]] = live.call("/api/admin/state", token=ADMIN)[1]["agents"]
    return rows


def close(live: Live, room: dict[str, Any]) -> None:
    assert live.call(f"/api/admin/rooms/{room['room']}/close", {}, token=ADMIN)[0] == 200


@pytest.mark.slow
def test_rooms_of_all_processes_share_the_workers(live: Live) -> None:
    games = [play(live, at) for at in (0, 1)]
    assert [row["seats"] for row in workers(live)] == [2]
    assert all(moves(person, 20) for _, person in games)
    for room, _ in games:
        close(live, room)
    deadline = time.monotonic() + 10.0
    while [row["seats"] for row in workers(live)] != [0]:
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
def test_after_the_death_of_a_worker_its_agents_play_on(live: Live) -> None:
    room, person = play(live, 0)
    os.kill(int(workers(live)[0]["pid"]), signal.SIGKILL)
    assert moves(person)
    assert workers(live)[0]["restarts"] == 1
    close(live, room)


@pytest.mark.slow
def test_after_the_death_of_the_service_its_agents_play_on(live: Live) -> None:
    room, person = play(live, 1)
    service = cast(Front, live.host).agents
    killed = service.pid
    os.kill(killed, signal.SIGKILL)
    assert moves(person, 100)
    assert service.pid != killed
    close(live, room)


@pytest.mark.slow
def test_the_seats_of_a_killed_process_are_free_and_taken_again(live: Live) -> None:
    room, person = play(live, 0)
    token = person.tokens[0]
    link, seats = home(live, room["room"]), workers(live)[0]["seats"]
    os.kill(link.pid, signal.SIGKILL)
    person.end()
    deadline = time.monotonic() + 20.0
    while not (link.is_ready and link.restarts):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    again = live.person(room["room"], tokens=[token])
    again.say(type="ready", seat=0, ready=True)
    again.wait_for("room", phase="playing")
    assert moves(again, 20)
    assert [row["seats"] for row in workers(live)] == [seats]
    close(live, room)


@pytest.mark.slow
def test_an_agent_whose_threads_compute_for_ever_is_stopped_in_all_rooms(tmp_path: Path) -> None:
    runaway = "tests.agents.support:Threaded"
    with cluster(tmp_path, partner=runaway, agent_thread_cores=0.05) as live:
        first, second = live.open_room("here", runaway, limit_ticks=2000), live.open_room("here", "scripted")
        people = [live.person(room["room"], tokens=room["tokens"][:1]) for room in (first, second)]
        for person in people:
            person.say(type="ready", seat=0, ready=True)
            person.wait_for("room", phase="playing")
        deadline = time.monotonic() + 60.0
        while not workers(live)[0]["overruns"]:
            assert time.monotonic() < deadline
            people[0].play(1)
        assert moves(people[1], 20), "its neighbour plays on, in another process"
        people[0].play(20)
        assert workers(live)[0]["overruns"] == 1, "it is not begun again"
