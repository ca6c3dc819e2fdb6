"""A study whose rooms live in two other processes: played, killed and paused."""

import asyncio
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import cast

import pytest

from movingout.recordings import verify
from movingout.recordings.storage.index import list_recordings
from movingout.server.connection.asgi import App
from movingout.server.processes.front import Front
from movingout.server.processes.front_endpoint import FrontEndpoint
from movingout.server.processes.room_link import RoomLink
from movingout.server.settings import Settings
from movingout.study.store.tables import rounds
from tests.server.study.support import SOLO, Served, Visitor, served

TICKS = 120  # of 50 ms
LONG = SOLO.replace("[HandOff], limit_ticks: 20", f"[HandOff], limit_ticks: {TICKS}")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    data = tmp_path_factory.mktemp("several")
    lock = os.open(data, os.O_RDONLY)

    def several(settings: Settings) -> tuple[Front, App]:
        front = Front(settings, 2, lock)
        return front, FrontEndpoint(front)

    try:
        with served(data, LONG, host_of=several, tick_s=0.05) as running:
            yield running
    finally:
        os.close(lock)


@pytest.fixture(autouse=True)
def _hang_up(study: Served) -> Iterator[None]:
    yield
    study.live.hang_up()


def home(study: Served, visitor: Visitor) -> RoomLink:
    return cast(Front, study.live.host).link_of(visitor.step["room"]["id"])


def in_a_round(study: Served) -> Visitor:
    visitor = study.visitor().go_to("round")
    visitor.next()
    visitor.wait_until(lambda one: one.step.get("state") == "playing")
    return visitor


def wait_until(reached: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 120.0
    while not reached():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def outcomes(study: Served, visitor: Visitor) -> list[tuple[str, int]]:
    """Of the recorded rounds of somebody, in order."""
    unit = study.running.participants[visitor.pid].record.unit
    rows = study.running.databases.store.rows(rounds)
    return [(row["outcome"], row["ticks"]) for row in rows if row["unit"] == unit]


@pytest.mark.slow
def test_rooms_are_spread_and_a_killed_process_loses_no_round(study: Served) -> None:
    killed, beside = in_a_round(study), in_a_round(study)
    assert home(study, killed) is not home(study, beside)
    person, other = killed.player(), beside.player()
    seat, other_seat = killed.step["room"]["seat"], beside.step["room"]["seat"]
    seen = person.play(10, seat)[-1]
    assert study.row(killed.pid)["phase"] == "playing" and study.row(killed.pid)["present"]
    os.kill(home(study, killed).pid, signal.SIGKILL)
    other.play_out(other_seat)
    ticks = [bundle.tick for bundle in other.bundles]
    assert ticks == sorted(set(ticks)) and ticks[-1] == TICKS, "the other one plays on, on the same connection"
    before = killed.step["room"]
    assert killed.look()["step"]["room"] == before, "the page keeps its room and its key"
    again = killed.player()
    assert seen - 1 <= again.next_tick(seat) < TICKS, "the round goes on after the last recorded tick"
    again.play_out(seat)
    for visitor in (killed, beside):
        visitor.wait_until(lambda one: one.kind == "questionnaire")
        assert outcomes(study, visitor) == [("time", TICKS)]
    settled = study.live.host.recording_service.settled()
    asyncio.run_coroutine_threadsafe(settled, study.live.loop).result(120.0)
    recordings, damaged = list_recordings(study.folder.recordings)
    assert damaged == [] and all(verify(one.path).identical for one in recordings)
    killed.fill_in()
    killed.play()
    assert outcomes(study, killed) == [("time", TICKS)] * 2


@pytest.mark.slow
def test_a_practice_and_a_round_that_has_not_begun_survive_their_process(study: Served) -> None:
    practising, ready = study.visitor().go_to("practice"), in_a_round(study)
    practising.next()
    practising.wait_until(lambda one: one.step.get("state") == "playing")
    for link in cast(Front, study.live.host).links:
        os.kill(link.pid, signal.SIGKILL)
    practising.play()
    ready.play()
    assert practising.kind == "round"
    assert (ready.kind, outcomes(study, ready)) == ("questionnaire", [("time", TICKS)])


@pytest.mark.slow
def test_what_is_paused_stays_paused_when_its_process_dies(study: Served) -> None:
    visitor = in_a_round(study)
    seat = visitor.step["room"]["seat"]
    visitor.player().play(3, seat)
    study.ask("pause", pid=visitor.pid)
    assert study.row(visitor.pid)["phase"] == "paused"
    os.kill(home(study, in_pause := visitor).pid, signal.SIGKILL)
    wait_until(lambda: study.row(in_pause.pid)["phase"] == "paused" and home(study, in_pause).is_ready)
    assert visitor.look()["step"]["kind"] == "paused"
    study.ask("resume", pid=visitor.pid)
    visitor.look()
    visitor.player().play_out(seat)
    visitor.wait_until(lambda one: one.kind == "questionnaire")
    assert outcomes(study, visitor) == [("time", TICKS)]


@pytest.mark.slow
def test_a_journal_that_is_gone_with_its_process_is_a_round_to_play_again(study: Served, tmp_path: Path) -> None:
    visitor = in_a_round(study)
    seat, room = visitor.step["room"]["seat"], visitor.step["room"]["id"]
    visitor.player().play(3, seat)
    link = home(study, visitor)
    os.kill(link.pid, signal.SIGSTOP)  # it writes nothing any more
    (study.live.host.settings.rooms / f"{room}.json").unlink()  # as if the disk had lost it
    os.kill(link.pid, signal.SIGKILL)
    wait_until(lambda: visitor.look()["step"]["state"] == "card")  # a process that finishes journals starts first
    ((outcome, ticks),) = outcomes(study, visitor)
    assert outcome == "interrupted" and 0 < ticks < TICKS
    visitor.play()
    assert [found for found, _ in outcomes(study, visitor)] == ["interrupted", "time"]
