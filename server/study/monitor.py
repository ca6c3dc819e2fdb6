"""What time alone brings about in a study, looked after once a second: nobody waits for ever, nothing fails unseen."""

import asyncio
import logging

from movingout.server.rooms.room import Room
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import StudyUnit
from movingout.study.errors import StoreError

log = logging.getLogger(__name__)

LOOK_S = 1.0
SLOW_PARTNER_S = 300.0  # somebody who is there and lets a partner wait so long is worth an alert


class StudyMonitor:
    """Looks after a running study. `start` and `stop` run inside the event loop, while the study runs."""

    def __init__(self, running: RunningStudy) -> None:
        self._running = running
        self._watching: asyncio.Task[None] | None = None

    def start(self) -> None:
        self._watching = asyncio.create_task(self._watch())

    async def stop(self) -> None:
        if self._watching is not None:
            self._watching.cancel()
            await asyncio.gather(self._watching, return_exceptions=True)

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(LOOK_S)
            try:
                async with self._running.lock:
                    await self.look()
            except StoreError as error:
                log.warning("%s", error)  # the experimenter sees it; nobody moves until it is mended
            except Exception:  # the study goes on, whatever went wrong with one of it
                log.exception("looking after the study failed")
                self._running.alerts.raise_("fault", "Something in the server failed; its log says what.")

    async def look(self) -> None:
        """One look. The lock is held."""
        running, now = self._running, self._running.now()
        for unit in list(running.units.values()):
            if (
                all(session.finished for session in unit.members)
                and unit.running_round is None
                and unit.finished_round is None
            ):
                del running.units[unit.record.id]
            else:
                await self._look_after(unit, now)
        await running.rooms.look_after(running.units.values(), now, may_begin=not running.paused)
        if not running.paused:
            await running.match()
        full = running.host.full_disk()
        if full:
            running.alerts.raise_("disk", full)

    async def _look_after(self, unit: StudyUnit, now: float) -> None:
        await self._running.bring_in(unit)
        self._hear_players(unit, now)
        if not (self._running.paused or unit.paused):
            await self._evict(unit, now)
            self._notice_slow_partner(unit, now)
        if unit.running_round is not None:
            self._notice_room(unit.record.id, unit.running_round.room)

    def _hear_players(self, unit: StudyUnit, now: float) -> None:
        """Who sits in the game is present, though no page of the study is open."""
        if unit.running_round is not None:
            for pid, seat in unit.running_round.seats.items():
                if unit.running_round.room.seats[seat].client is not None:
                    self._running.sessions[pid].last_seen_at = now

    async def _evict(self, unit: StudyUnit, now: float) -> None:
        """Nobody waits for ever for a partner who is gone."""
        running = self._running
        if any(one.finished and one.record.outcome != "done" for one in unit.members):
            await running.part(unit)  # the server was killed, or the database refused, half-way through
        absent = [one for one in unit.members if not one.finished and self._gone(one, now)]
        waiting = [one for one in unit.members if not one.finished and one.has_rounds_left() and one.present(now)]
        if absent and waiting:
            running.alerts.raise_("gone", f"{absent[0].pid} did not come back; {waiting[0].pid} was given a code.")
            await running.dismiss(absent[0], "withdrew")

    def _gone(self, session: ParticipantSession, now: float) -> bool:
        return not session.present(now) and now - session.last_seen_at > self._running.study.pairing.return_s

    def _notice_slow_partner(self, unit: StudyUnit, now: float) -> None:
        if unit.ready and now - unit.ready_at > SLOW_PARTNER_S and not unit.problem:
            waiting = ", ".join(sorted(unit.ready))
            self._running.alerts.raise_("slow", f"{waiting} waits for a partner who is there, but does not come.")

    def _notice_room(self, unit: int, room: Room) -> None:
        """What the experimenter should know of a room."""
        alerts = self._running.alerts
        for seat in room.seats:
            if seat.agent_failure:
                alerts.raise_("agent", f"Unit {unit}: {seat.agent_failure}")
            if seat.agent_caution:
                alerts.raise_("agent", f"Unit {unit}: {seat.agent_caution}")
        if room.phase == "playing" and not room.recording and not room.config.practice:
            problem = room.round.recorder.problem
            alerts.raise_("recording", f"A round of unit {unit} is not recorded: {problem}")
