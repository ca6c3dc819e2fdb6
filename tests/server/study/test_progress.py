"""Pauses, and the absences around them, which are not paid where they are long; also over a stop of the server."""

import asyncio
import time
from pathlib import Path

import pytest
from sqlalchemy import update

from movingout.server.host import Host
from movingout.server.settings import Settings
from movingout.server.study import running_study
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.arrivals.arrival_link import LINK
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.earnings import minutes_here
from movingout.server.study.experimenter_actions import ExperimenterActions, ExperimenterRequest
from movingout.server.study.monitor import StudyMonitor
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.rounds.study_rooms import StudyRooms
from movingout.server.study.running_study import RunningStudy
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.study_file import parse_study
from movingout.study.store.tables import participants
from tests.server.study.support import SOLO, Served, Visitor
from tests.study.support import Clock

HOUR_S = 3600


def away(study: Served, visitor: Visitor, seconds: float) -> None:
    """As if so much time had passed without the visitor, on every clock."""
    session = study.running.participants[visitor.pid]
    for clock in ("last_seen_at", "resumed_at", "unpaid_until"):
        setattr(session, clock, getattr(session, clock) - seconds)
    earlier = participants.c.arrived_ms - round(1e3 * seconds)
    with study.running.databases.store.database.write() as connection:
        connection.execute(update(participants).where(participants.c.pid == visitor.pid).values(arrived_ms=earlier))


def test_who_was_away_for_long_and_came_back_is_not_paid_for_it(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    session = solo.running.participants[visitor.pid]
    away(solo, visitor, 50_000)
    visitor.look()
    solo.look()
    assert session.record.away_ms >= 50_000_000, "kept at the next look, also over a restart"
    away(solo, visitor, 200)
    visitor.look()
    solo.ask("pause")
    away(solo, visitor, 6_000)
    visitor.look()
    solo.ask("resume")
    away(solo, visitor, 40_000)
    visitor.look()
    visitor.stop(True)
    assert (200 + 6_000) / 60 <= solo.row(visitor.pid)["minutes"] < (200 + 6_000) / 60 + 5, "pauses are paid"


@pytest.mark.parametrize("returns", ["in the pause", "after it", "after another one", "never"])
def test_a_long_absence_before_a_pause_is_not_paid_and_counts_once(solo: Served, returns: str) -> None:
    visitor = solo.visitor().go_to("round")
    away(solo, visitor, 50_000)
    solo.ask("pause", pid=visitor.pid)
    solo.ask("pause")
    away(solo, visitor, 6_000)
    if returns == "in the pause":
        visitor.look()
    solo.ask("resume")
    solo.ask("resume", pid=visitor.pid)
    if returns == "after another one":
        away(solo, visitor, 60)
        solo.ask("pause")
        solo.ask("resume")
    if returns != "never":
        visitor.look()
    solo.ask("kick", pid=visitor.pid)
    paid_s = 6_000 + (60 if returns == "after another one" else 0)
    assert paid_s / 60 <= solo.row(visitor.pid)["minutes"] < paid_s / 60 + 5


def test_who_is_ended_in_a_pause_that_began_in_their_absence_is_not_paid_for_it_and_did_not_come_back(
    solo: Served,
) -> None:
    visitor = solo.visitor().go_to("form")
    solo.ask("pause")
    away(solo, visitor, 60_000)
    visitor.look()
    solo.ask("resume")
    away(solo, visitor, 50_000)
    solo.ask("pause")
    solo.look()
    solo.ask("kick", pid=visitor.pid)
    solo.ask("resume")
    row = solo.row(visitor.pid)
    assert row["outcome"] == "dropped-out" and 60_000 / 60 <= row["minutes"] < 60_000 / 60 + 5, "counted once"


@pytest.mark.parametrize("ended", ["in the pause", "after it"])
def test_a_pause_is_paid_whether_who_left_in_it_is_ended_in_it_or_after_it(solo: Served, ended: str) -> None:
    visitor = solo.visitor().go_to("round")
    away(solo, visitor, 100)
    visitor.look()
    solo.ask("pause")
    away(solo, visitor, 6_000)
    if ended == "after it":
        solo.ask("resume")
    solo.ask("kick", pid=visitor.pid)
    row = solo.row(visitor.pid)
    solo.ask("resume")
    assert row["outcome"] == ("withdrew" if ended == "after it" else "dropped-out")
    assert 6_100 / 60 <= row["minutes"] < 6_100 / 60 + 5


# ---- over a stop of the server --------------------------------------------------------------------------------------


def begun(folder: Path, clock: Clock) -> RunningStudy:
    """A study that is not served."""
    study = RunningStudy(StudyFolder(parse_study(SOLO), folder), SOLO, Host(Settings(data=folder)), Admission())
    study.databases.store.now = clock
    return study


async def here(study: RunningStudy) -> ParticipantSession:
    """Somebody who has consented."""
    async with study.transaction() as tx:
        session = await study.participants.arrive(tx, "P1", "en", LINK)
        await tx.run(study.databases.store.consent, "P1", "1", "en", "text", [])
        await study.participants.move(tx, session, "input-check")
    return session


async def started_again(study: RunningStudy) -> ParticipantSession:
    async with study.transaction() as tx:
        await study.participants.restore(tx, {})
        await study.progress.restore(tx)
    return study.participants["P1"]


async def minutes(study: RunningStudy, session: ParticipantSession) -> float | None:
    async with study.transaction() as tx:
        await study.participants.finish(tx, session, "done")
    return minutes_here(session.record)


@pytest.mark.parametrize(
    ("away_s", "stopped_s", "paid_s"),
    [
        (9 * HOUR_S, 15 * HOUR_S, 0),
        (0, 15 * HOUR_S, 0),
        (100, 250, 0),
        (0, 250, 250),
    ],
)
@pytest.mark.parametrize("returns", [True, False])
def test_an_absence_goes_on_while_the_server_is_stopped(
    tmp_path: Path, away_s: int, stopped_s: int, paid_s: int, returns: bool
) -> None:
    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        session = await here(study)
        clock.ms += 1000 * (HOUR_S + away_s)
        session.last_seen_at -= away_s
        await study.stop()
        clock.ms += 1000 * stopped_s
        study = begun(tmp_path, clock)
        try:
            session = await started_again(study)
            if returns:
                session.seen(time.monotonic(), paused=False)
            paid = HOUR_S + (paid_s if returns else 0)
            assert await minutes(study, session) == pytest.approx(paid / 60, abs=0.1)
        finally:
            study.databases.close()

    asyncio.run(test())


@pytest.mark.parametrize("away_s", [0, 100])
def test_a_clock_that_is_set_back_between_two_runs_takes_nobodys_minutes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, away_s: int
) -> None:
    async def no_rooms(*_: object) -> None: ...

    monkeypatch.setattr(StudyRooms, "resume", no_rooms)

    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        session = await here(study)
        clock.ms += 1000 * (HOUR_S + away_s)
        session.last_seen_at -= away_s
        await study.stop()
        clock.ms -= 1000 * 3 * HOUR_S
        told = []
        for again in (True, False):  # the times are moved once
            study = begun(tmp_path, clock)
            await study.start()
            told.append([alert["values"] for alert in study.alerts.to_json()])
            if again:
                study.databases.close()
        try:
            session = study.participants["P1"]
            session.seen(time.monotonic(), paused=False)
            assert await minutes(study, session) == pytest.approx(60, abs=0.1)
            assert told == [[{"minutes": pytest.approx(180 - away_s / 60, abs=0.2)}], []]
        finally:
            study.databases.close()

    asyncio.run(test())


@pytest.mark.parametrize(("killed", "paid_s"), [(False, 600), (True, 0)])
def test_a_stop_is_not_paid_to_who_had_only_opened_the_link(tmp_path: Path, killed: bool, paid_s: int) -> None:
    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        async with study.transaction() as tx:
            await study.participants.arrive(tx, "P1", "en", LINK)
        clock.ms += 1000 * 600
        if killed:
            study.databases.close()
        else:
            await study.stop()
        clock.ms += 1000 * 15 * HOUR_S
        study = begun(tmp_path, clock)
        try:
            session = await started_again(study)
            async with study.transaction() as tx:
                await study.participants.drop_undecided(tx, time.monotonic() + 1)
            assert study.participants.get("P1"), "their page may come back in a moment"
            session.seen(time.monotonic(), paused=False)
            assert await minutes(study, session) == pytest.approx(paid_s / 60, abs=0.1)
        finally:
            study.databases.close()

    asyncio.run(test())


@pytest.mark.parametrize(("returns", "outcome"), [(False, "dropped-out"), (True, "withdrew")])
def test_who_had_gone_before_a_restart_and_is_ended_right_after_it_did_not_come_back(
    tmp_path: Path, returns: bool, outcome: str
) -> None:
    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        session = await here(study)
        session.last_seen_at -= HOUR_S
        await study.stop()
        study = begun(tmp_path, clock)
        try:
            session = await started_again(study)
            if returns:
                session.seen(time.monotonic(), paused=False)
            await ExperimenterActions(study, SessionService(study)).kick(ExperimenterRequest(pid="P1"))
            assert session.record.outcome == outcome
        finally:
            study.databases.close()

    asyncio.run(test())


def test_a_pause_over_a_stop_is_paid_and_what_went_before_it_counts_once(tmp_path: Path) -> None:
    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        session = await here(study)
        clock.ms += 1000 * 10 * HOUR_S
        session.last_seen_at -= 9 * HOUR_S
        async with study.transaction() as tx:
            await study.progress.set_paused(tx, True)
        await study.stop()
        clock.ms += 1000 * 15 * HOUR_S
        study = begun(tmp_path, clock)
        try:
            session = await started_again(study)
            async with study.transaction() as tx:
                await study.progress.set_paused(tx, False)
            assert await minutes(study, session) == pytest.approx(60 * (1 + 15), abs=0.1)
        finally:
            study.databases.close()

    asyncio.run(test())


@pytest.mark.parametrize("stops", [False, True])
def test_a_pause_makes_nobody_heard_who_has_long_gone(tmp_path: Path, stops: bool) -> None:
    """Retention begins when they were heard, also where every evening is a pause."""

    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        session = await here(study)
        session.seen(time.monotonic(), paused=False)
        async with study.transaction() as tx:
            await study.participants.note_last_seen(tx)
        noted = clock.ms
        clock.ms += 1000 * 2400 * HOUR_S
        session.last_seen_at -= 2400 * HOUR_S
        async with study.transaction() as tx:
            await study.progress.set_paused(tx, True)
        if stops:
            await study.stop()
            study = begun(tmp_path, clock)
            session = await started_again(study)
        try:
            async with study.transaction() as tx:
                await study.progress.set_paused(tx, False)
                heard_ms = study.databases.store.participant("P1").heard_ms
                assert heard_ms and abs(heard_ms - noted) < 1000
                session.seen(time.monotonic(), paused=False)
                await study.participants.note_last_seen(tx)
            assert (study.databases.store.participant("P1").heard_ms or 0) > heard_ms
        finally:
            study.databases.close()

    asyncio.run(test())


@pytest.mark.parametrize(("slept_s", "paid_s"), [(9 * HOUR_S, 0), (250, 250)])
@pytest.mark.parametrize("first", ["monitor", "page", "pause"])
def test_a_laptop_that_slept_with_the_server_was_away_for_everybody_but_in_a_pause(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, slept_s: int, paid_s: int, first: str
) -> None:
    asleep_s = 100.0  # before the server was started
    monkeypatch.setattr("movingout.server.study.progress.slept_s", lambda: asleep_s)

    async def test() -> None:
        nonlocal asleep_s
        clock = Clock()
        study = begun(tmp_path, clock)
        try:
            session = await here(study)
            clock.ms += 1000 * (HOUR_S + slept_s)
            asleep_s += slept_s
            async with study.transaction() as tx:
                if first == "monitor":
                    await StudyMonitor(study).check(tx)
                if first == "pause":
                    await study.progress.set_paused(tx, True)
            SessionService(study)._mark_present(session)
            if first == "pause":
                clock.ms += 1000 * slept_s
                asleep_s += slept_s
                async with study.transaction() as tx:
                    await study.progress.set_paused(tx, False)
            paid = HOUR_S + paid_s + (slept_s if first == "pause" else 0)
            assert await minutes(study, session) == pytest.approx(paid / 60, abs=0.1)
            assert not study.alerts.number
        finally:
            study.databases.close()

    asyncio.run(test())


def test_a_server_that_stops_saves_rounds_before_it_notes_who_is_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running_study, "NOTE_S", 0.05)

    async def test() -> None:
        study = begun(tmp_path, Clock())
        saved = asyncio.Event()

        async def save() -> None:
            saved.set()

        monkeypatch.setattr(study.rooms.finished, "saved", save)
        async with study.transaction():  # something else holds the lock for long
            stopping = asyncio.create_task(study.stop())
            await asyncio.wait_for(saved.wait(), 2)
            await asyncio.wait_for(stopping, 2)

    asyncio.run(test())


def test_who_is_here_is_noted_once_a_minute_in_case_the_server_is_killed(tmp_path: Path) -> None:
    async def test() -> None:
        clock = Clock()
        study = begun(tmp_path, clock)
        try:
            session = await here(study)
            monitor = StudyMonitor(study)
            async with study.transaction() as tx:
                await monitor.check(tx)
                assert study.databases.store.participant("P1").last_seen_ms is None
                monitor._noted_at -= 61
                session.last_seen_at -= 30
                await monitor.check(tx)
            noted = study.databases.store.participant("P1").last_seen_ms
            assert noted is not None and 29_000 < clock.ms - noted < 32_000
        finally:
            study.databases.close()

    asyncio.run(test())
