"""Checks a running study once a second, so that nobody waits for ever and nothing fails unseen."""

import asyncio
import logging
import time
from collections.abc import Iterator
from typing import NamedTuple

from movingout.server.notices import AlertCode
from movingout.server.rooms.room_view import RoomView
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.study.errors import StoreError

log = logging.getLogger(__name__)

INTERVAL_S = 1.0
AWAY_S = 120.0  # somebody who was here and is silent for so long is worth an alert
NOTED_S = 60.0  # between two notes of who is here
SLOW_PARTNER_S = 300.0  # a present partner who keeps somebody waiting this long is worth an alert


class RoomProblem(NamedTuple):
    """What an alert says of a round."""

    about: AlertCode
    text: str
    values: tuple[tuple[str, int | str], ...]
    episode: str


class StudyMonitor:
    """Checks a running study. `start` and `stop` run inside the event loop, while the study runs."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running
        self._watching: asyncio.Task[None] | None = None
        self._noted_at = time.monotonic()  # when it was last kept who is here
        self._told: dict[int, set[RoomProblem]] = {}  # what alerts say of the rounds of each unit, by its number

    def start(self) -> None:
        self._watching = asyncio.create_task(self._watch())

    async def stop(self) -> None:
        if self._watching is not None:
            self._watching.cancel()
            await asyncio.gather(self._watching, return_exceptions=True)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(INTERVAL_S)
            try:
                await self.look()
            except StoreError as error:
                log.warning("%s", error)  # the experimenter was alerted; nobody moves until the database works again
            except Exception:  # the study goes on, whatever went wrong with one unit
                log.exception("checking the study failed")
                self._running.alerts.add("fault", "Something went wrong on the server; its log has the details.")

    async def look(self) -> None:
        """All checks, and what nobody shall wait for."""
        async with self._running.transaction() as tx:
            await self.check(tx)
        await self._running.participants.scrub_identities(time.monotonic())

    async def check(self, tx: Transaction) -> None:
        """All checks, once."""
        running, now = self._running, time.monotonic()
        running.progress.note_sleep()
        await running.rooms.look(tx, running.units)
        running.progress.note_standing(now)
        self._notice_absent(now)
        for unit in running.units:
            if unit.finished:
                running.units.remove(tx, unit)
            else:
                await self._check_unit(tx, unit, now)
        self._forget_units()
        await running.participants.note_absences(tx)
        if now - self._noted_at > NOTED_S:
            self._noted_at = now
            await running.participants.note_last_seen(tx)
        await running.progress.hold_rooms(tx)
        await running.rooms.check(tx, running.units, now, may_begin=not running.progress.paused)
        if not running.progress.paused:
            await running.units.match(tx)
        running.notes.forget(await running.participants.drop_undecided(tx, now))
        for fault in running.host.health().faults:
            running.alerts.add("server", "Something on the server does not work any more.", fault)
        full = running.host.full_disk()
        if full:
            running.alerts.add("disk", full.message)

    async def _check_unit(self, tx: Transaction, unit: StudyUnit, now: float) -> None:
        await self._running.units.move_to_first_step(tx, unit)
        self._mark_players_present(unit, now)
        if not (self._running.progress.paused or unit.paused):
            await self._dismiss_absent(tx, unit, now)
            self._notice_slow_partner(unit, now)
        self._notice_room(unit)

    def _mark_players_present(self, unit: StudyUnit, now: float) -> None:
        """Whoever is connected to the game is present, even without a page of the study."""
        if unit.running_round is not None:
            for pid, seat in unit.running_round.seats.items():
                if unit.running_round.view.seats[seat].present:
                    session = self._running.participants[pid]
                    session.seen(now, self._running.progress.is_paused(session))

    async def _dismiss_absent(self, tx: Transaction, unit: StudyUnit, now: float) -> None:
        """Nobody waits for ever for a partner who is gone."""
        departures = self._running.departures
        left = any(one.finished and one.record.outcome != "done" for one in unit.members)
        if left or await self._is_left_at_a_round(tx, unit):
            await departures.release_partners(tx, unit)  # where a kill or a database error interrupted `dismiss`
        return_s = self._running.study.pairing.return_s
        absent = [one for one in unit.members if not one.finished and one.is_gone(now, return_s)]
        staying = await self._running.units.with_rounds_left(tx, unit) if absent else []
        waiting = [one for one in staying if one not in absent and one.has_waited(now, return_s, absent[0])]
        if waiting:
            pid, partner = absent[0].pid, waiting[0].pid
            self._running.alerts.add(
                "gone", f"{pid} did not come back; {partner} was given a code.", pid=pid, partner=partner
            )
            await departures.dismiss(tx, absent[0], "dropped-out")

    async def _is_left_at_a_round(self, tx: Transaction, unit: StudyUnit) -> bool:
        """Whether somebody waits at a round for one who is done.

        After a restart nothing tells that the time of a block was up whose rounds one of the two had deleted.
        """
        waiting = [one for one in unit.members if one.step is not None and one.step.kind == "round"]
        if not waiting or not any(one.finished for one in unit.members):
            return False
        await self._running.progress.catch_up(tx, unit)  # it may be that the round has been played, or left out
        return any(one.step is not None and one.step.kind == "round" for one in waiting)

    def _notice_absent(self, now: float) -> None:
        """Alert once to each participant who was here and has been away for a while; a pause is no absence.

        Who is in no unit has begun nothing that anybody waits for: many open a link, agree and close it again, and
        their alerts would push out those that matter.
        """
        for session in self._running.participants:
            if session.absence_told or session.finished or self._running.progress.is_paused(session):
                continue
            if session.record.unit is not None and session.absent_s(now) > AWAY_S:
                session.absence_told = True
                self._running.alerts.add("away", f"{session.pid} has been away for two minutes.", pid=session.pid)

    def _notice_slow_partner(self, unit: StudyUnit, now: float) -> None:
        """Alert once while somebody waits for a partner who is there but not ready; of who is away tell others."""
        if not unit.ready or unit.slow_told or unit.problem or not all(one.present(now) for one in unit.members):
            return
        if now - max(unit.ready_at, *(one.present_since for one in unit.members)) > SLOW_PARTNER_S:
            unit.slow_told = True
            pid = ", ".join(sorted(unit.ready))
            self._running.alerts.add("slow", f"{pid} is waiting: the partner is there but not ready.", pid=pid)

    def _notice_room(self, unit: StudyUnit) -> None:
        """Alert once to each problem of a unit's round, and take back what is over.

        That a round is not recorded stays true: it is taken back once the unit plays a round that is.
        """
        room = unit.running_round.view if unit.running_round else None
        told = self._told.setdefault(unit.record.id, set())
        found = set(_problems(unit.record.id, room)) if room else set()
        recorded = room is not None and room.phase == "playing" and room.recording
        self._settle(unit.record.id, {one for one in told - found if one.about != "recording" or recorded})
        for one in found - told:
            detail = room.recording_problem if room and one.about == "recording" else ""
            self._running.alerts.add(one.about, one.text, detail, **dict(one.values))
            told.add(one)

    def _settle(self, unit: int, over: set[RoomProblem]) -> None:
        for one in over:
            self._running.alerts.settle(one.about, **dict(one.values))
        self._told[unit] -= over

    def _forget_units(self) -> None:
        """Of units that have finished there is nothing to be done any more."""
        for unit in self._told.keys() - {one.record.id for one in self._running.units}:
            self._settle(unit, set(self._told[unit]))
            del self._told[unit]


def _problems(unit: int, room: RoomView) -> Iterator[RoomProblem]:
    """For the experimenter, who does not know which partner is which agent."""
    for seat in room.seats:
        who = (("unit", unit), ("partner", seat.player_name))
        if seat.agent_failure:
            yield RoomProblem("agent_failed", f"{seat.title} of unit {unit} cannot play.", who, room.episode)
        if seat.agent_caution:
            text = f"{seat.title} of unit {unit} was not trained on this map and may play badly."
            yield RoomProblem("agent_unseen", text, who, room.episode)
    if room.phase == "playing" and not room.recording and not room.practice:
        text = f"The round of unit {unit} is not being recorded."
        yield RoomProblem("recording", text, (("unit", unit),), room.episode)
