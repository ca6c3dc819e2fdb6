"""A server with several processes: where rooms live, and what happens when a process ends."""

import asyncio
import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosedError, InvalidMessage

from movingout.maps import load_map
from movingout.recordings.verification import verify
from movingout.remote import Client
from movingout.server import messages as m
from movingout.server.processes import room_link
from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.homes import home_of
from movingout.server.rooms.prepared_maps import Variant
from tests.server.live import ADMIN, Live, Person
from tests.server.processes.cluster import cluster, home, links

ROUND = 40  # ticks
PREPARED = attrgetter("registry.prepared_maps._made")


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with cluster(tmp_path_factory.mktemp("cluster")) as live:
        yield live


@pytest.fixture(autouse=True)
def _hang_up(live: Live) -> Iterator[None]:
    yield
    live.hang_up()


def start(live: Live, limit_ticks: int = ROUND, at: int | None = None) -> tuple[dict[str, Any], Person]:
    """A room (in a certain process) whose only person plays."""
    while True:
        room = live.open_room("here", "idle", limit_ticks=limit_ticks)
        if at is None or home_of(room["room"], len(links(live))) == at:
            break
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0, ready=True)
    return room, person


def back(live: Live, room: str, token: str) -> Person:
    """The same person, connected again; tries as pages do, should the process have ended in the same moment."""
    while True:
        with contextlib.suppress(InvalidMessage):
            person = live.person(room, tokens=[token])
            break
        time.sleep(0.1)
    person.say(type="ready", seat=0, ready=True)
    return person


def wait_until(condition: Callable[[], bool], within_s: float = 20.0) -> None:
    deadline = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def finished(live: Live, person: Person) -> Path:
    """Play the round to its end; its recording."""
    episode = person.play_out()["recording"]
    path: Path = live.host.settings.recordings / f"{episode}.mcap"
    wait_until(path.exists)
    return path


@pytest.mark.slow
def test_rooms_are_shared_out_and_their_ids_say_where_they_live(live: Live) -> None:
    rooms = [live.open_room("here", "idle")["room"] for _ in range(4)]
    assert sorted(home_of(room, 2) for room in rooms) == [0, 0, 1, 1]
    assert all(room in home(live, room).rooms for room in rooms)


@pytest.mark.slow
def test_a_program_of_the_client_finds_the_process_of_its_room(live: Live) -> None:
    async def seat(room: str) -> int:
        async with Client(f"http://{live.address}", room) as client:
            return client.seat

    rooms = [live.open_room("idle", "remote")["room"] for _ in range(4)]
    assert {home_of(room, 2) for room in rooms} == {0, 1}
    assert [asyncio.run(seat(room)) for room in rooms] == [1] * 4


def test_a_round_is_played_recorded_and_finished(live: Live) -> None:
    _, person = start(live)
    path = finished(live, person)
    assert [bundle.tick for bundle in person.bundles] == list(range(1, ROUND + 1))
    assert verify(path).identical


def test_the_api_finds_a_room_wherever_it_lives(live: Live) -> None:
    for at in (0, 1):
        room, person = start(live, at=at)
        name, token = room["room"], person.tokens[0]
        assert live.call(f"/api/rooms/{name}")[1]["map"] == "Simple"
        assert live.call(f"/api/rooms/{name}/qr.svg")[0] == 200
        assert live.call(f"/api/rooms/{name}/answers", token=token) == (200, {"answers": {}})
        assert live.call(f"/api/rooms/{name}/answers", token="wrong")[0] == 401
        assert name in {row["room"] for row in live.call("/api/admin/state", token=ADMIN)[1]["rooms"]}
        assert live.call(f"/api/admin/rooms/{name}/close", {}, token=ADMIN) == (200, {"closed": True})
        assert person.end()[0] == m.CLOSE_KICKED
        assert live.call(f"/api/rooms/{name}")[0] == 404
        assert live.call(f"/api/admin/rooms/{name}/close", {}, token=ADMIN)[0] == 404


def test_the_report_takes_all_processes_together(live: Live) -> None:
    report = live.call("/api/admin/state", token=ADMIN)[1]
    assert [row["ready"] for row in report["processes"]] == [True, True]
    assert len({row["pid"] for row in report["processes"]} | {os.getpid()}) == 3
    assert report["ticks"] > 0


def test_nobody_connects_without_naming_a_room(live: Live) -> None:
    with pytest.raises(ConnectionClosedError) as closed:
        Person(live.connect(), "whatever")
    assert closed.value.rcvd and closed.value.rcvd.code == m.CLOSE_BAD_MESSAGE


@pytest.mark.slow
def test_after_kill_9_its_players_play_on_and_the_others_miss_nothing(live: Live) -> None:
    room, person = start(live, at=0)
    _, other = start(live, 100, at=1)
    beside = threading.Thread(target=other.play_out)
    beside.start()
    person.play(12)
    token, killed = person.tokens[0], home(live, room["room"]).pid
    os.kill(killed, signal.SIGKILL)
    begun = time.monotonic()
    assert person.end()[0] == 1006
    again = back(live, room["room"], token)
    away_s = time.monotonic() - begun
    path = finished(live, again)
    assert home(live, room["room"]).pid != killed
    assert verify(path).identical
    assert again.bundles[0].tick <= 14 and again.bundles[-1].tick == ROUND
    beside.join(30)
    assert len(other.bundles) == 100
    assert [bundle.tick for bundle in other.bundles] == list(range(1, len(other.bundles) + 1))
    assert away_s < 5.0  # the aim is 2 s; here other tests may run beside this one


@pytest.mark.slow
def test_a_process_that_is_told_to_end_hands_its_rounds_to_the_next(live: Live) -> None:
    room, person = start(live, at=1)
    person.play(5)
    live.run(home(live, room["room"]).terminate)
    code, _ = person.end()
    assert code == m.CLOSE_SHUTDOWN
    again = back(live, room["room"], person.tokens[0])
    assert verify(finished(live, again)).identical


@pytest.mark.slow
def test_a_process_that_hangs_is_replaced(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room_link, "SILENT_S", 3.0)
    room, person = start(live, at=0)
    person.play(5)
    hung = home(live, room["room"]).pid
    os.kill(hung, signal.SIGSTOP)
    wait_until(lambda: home(live, room["room"]).pid not in (0, hung))
    again = back(live, room["room"], person.tokens[0])
    assert verify(finished(live, again)).identical


def test_whoever_asks_for_a_room_of_a_process_that_does_not_come_back_is_told_so(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    room, _ = start(live, at=0)
    link = home(live, room["room"])
    live.run(link.leaving)  # as if it had gone
    monkeypatch.setattr(room_link, "HOME_S", 0.2)
    status, answer = live.call(f"/api/rooms/{room['room']}")
    assert (status, answer["error"]["code"]) == (503, "restarting")
    live.run(lambda: link.became_ready(dict.fromkeys(link.rooms, "")))
    assert live.call(f"/api/rooms/{room['room']}")[0] == 200


@pytest.mark.slow
def test_the_rooms_come_back_with_another_number_of_processes(tmp_path: Path) -> None:
    with cluster(tmp_path, 2) as first:
        games = [start(first, at=at) for at in (0, 1)]
        for _, person in games:
            person.play(4)
        tokens = [(room["room"], person.tokens[0]) for room, person in games]
    with cluster(tmp_path, 3) as second:
        for room, token in tokens:
            assert verify(finished(second, back(second, room, token))).identical


def test_a_map_made_ahead_is_in_every_process_and_in_one_that_takes_the_place_of_another(live: Live) -> None:
    variant: Variant = (load_map("HandOff"), 7, "train")
    made = load_map("LeftRight")
    live.run(lambda: live.host.keep_map(variant, made))

    def have_it() -> bool:
        kept = [asyncio.run_coroutine_threadsafe(link.call(PREPARED), live.loop) for link in links(live)]
        with contextlib.suppress(ProcessGone):
            return all(each.result(20) == {variant: made} for each in kept)
        return False

    assert have_it()
    pid = links(live)[0].pid
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: links(live)[0].pid != pid and links(live)[0].is_ready)
    assert have_it()
