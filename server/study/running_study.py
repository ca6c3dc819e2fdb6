"""A study that is being run: who is where, and who plays with whom.

Everything is in the store before anybody is told so; what is here can be made again from the store after a crash.
One lock lets one thing happen at a time, so that the two of a pair cannot overtake each other.
"""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from movingout.server.host import Host
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.study_rooms import StudyRooms
from movingout.server.study.unit import FinishedRound, StudyUnit
from movingout.server.study.waiting_room import WaitingRoom
from movingout.study.data.erasure import remove_recordings
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import assign
from movingout.study.design.definition import Outcome
from movingout.study.design.review import earned
from movingout.study.design.step_order import LAST_ALONE, WAITING, blocks_over, next_step
from movingout.study.design.steps import steps
from movingout.study.errors import StudyError
from movingout.study.store import Unit
from movingout.study.store.removal import clear, episodes_of, has_deeds
from movingout.study.store.store import Participant
from movingout.study.store.tables import notes

log = logging.getLogger(__name__)

CODE_LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
CODE_LENGTH = 10
PAUSED = "The experimenter has paused the study. Please wait."

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class RunningStudy:
    """One study in one server. `start` and `stop` run inside the event loop, after and before the host's."""

    def __init__(
        self, folder: StudyFolder, file_text: str, host: Host, needs_code: bool = False, simulated: bool = False
    ) -> None:
        self.folder = folder
        self.study = folder.study
        self.host = host
        self.needs_code = needs_code
        self.simulated = simulated
        self.alerts = Alerts()
        self.databases = StudyDatabases(folder, file_text, self.alerts, simulated)
        self.lock = asyncio.Lock()
        self.waiting = WaitingRoom(self.study.pairing.wait_s)
        self.sessions: dict[str, ParticipantSession] = {}
        self.units: dict[int, StudyUnit] = {}
        self.notes: list[dict[str, Any]] = []  # the newest first
        self.paused = False
        names = {"study": self.study.id, **({"simulated": "yes"} if simulated else {})}
        self.rooms = StudyRooms(self.study, names, host, self.databases, self.alerts, self.lock, self._played)
        self._alone = steps(self.study, assign(self.study, 0))
        self._removals: set[asyncio.Task[None]] = set()

    # ---- from start to stop -----------------------------------------------------------------------------------

    async def start(self) -> None:
        """Bring everybody back to where they were."""
        store = self.databases.store
        known = await self.run(self.databases.identities.everybody)
        for one in await self.run(store.everybody):
            self.add(one, known.get(one.pid, ("", ""))[0])
        self.paused = await self.run(store.paused)
        self.notes = [self._note(row) for row in reversed(await self.run(store.rows, notes))]
        newest = await self.run(self.databases.rounds.newest_episodes)
        for record in await self.run(store.units_on_their_way):
            self._add_unit(record, [self.sessions[pid] for pid in record.pids], newest.get(record.id, ""))
        await self.rooms.take_up(self.units)
        self._hold_rooms()
        async with self.lock:
            for unit in list(self.units.values()):
                await self._catch_up(unit)
                await self.bring_in(unit)
        for session in self.sessions.values():
            if session.record.keep is False and session.finished:
                self.remove_data(session)

    def _note(self, row: dict[str, Any]) -> dict[str, Any]:
        pids = [pid for pid, session in self.sessions.items() if row["unit"] and session.record.unit == row["unit"]]
        return {"at": row["at_ms"] / 1e3, "text": row["text"], "pid": " and ".join(pids) or None}

    async def stop(self) -> None:
        await self.rooms.finish()
        await asyncio.gather(*self._removals, return_exceptions=True)
        self.databases.close()

    def now(self) -> float:
        """Seconds of a clock that never jumps."""
        return time.monotonic()

    async def run(self, work: Callable[Arguments, Result], *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        """Ask the databases."""
        return await self.databases.run(work, *args, **kwargs)

    def add(self, record: Participant, source: str) -> ParticipantSession:
        """Somebody takes part from now on."""
        session = ParticipantSession(record, self._alone, last_seen_at=self.now(), since=self.now(), source=source)
        self.sessions[record.pid] = session
        return session

    def unit_of(self, session: ParticipantSession) -> StudyUnit | None:
        return None if session.record.unit is None else self.units.get(session.record.unit)

    def stays(self, session: ParticipantSession) -> bool:
        """Whether the experimenter has paused this participant."""
        unit = self.unit_of(session)
        return self.paused or (unit is not None and unit.paused)

    def worth(self, session: ParticipantSession) -> dict[str, Any] | None:
        """What the time of somebody who has finished is paid; None where nothing is."""
        pay, record = self.study.pay, session.record
        if pay is None or record.finished_ms is None:
            return None
        minutes = max(0, record.finished_ms - record.arrived_ms) / 60_000
        return {"minutes": round(minutes, 1), "amount": earned(self.study, minutes), "currency": pay.currency}

    def push(self, *sessions: ParticipantSession) -> None:
        """Tell open pages to look again."""
        for session in sessions:
            for push in list(session.listeners):
                push({"changed": True})

    # ---- pausing (the lock is held) ---------------------------------------------------------------------------

    async def pause(self, paused: bool, unit: StudyUnit | None = None) -> None:
        """Stop the clock of a unit or of everybody, or let it go on; a restart of the server changes nothing."""
        await self.run(self.databases.store.pause, paused, None if unit is None else unit.record.id)
        if unit is None:
            self.paused = paused
        else:
            unit.paused = paused
        self._hold_rooms()
        if not paused:
            self._begin_waits_anew(unit)
        self.push(*self.sessions.values())

    def _begin_waits_anew(self, unit: StudyUnit | None) -> None:
        """A pause does not count: nobody who went away meanwhile is gone, nobody has waited too long."""
        for session in self.sessions.values() if unit is None else unit.members:
            session.last_seen_at = self.now()
        self.waiting.begin_anew(self.now())

    def _hold_rooms(self) -> None:
        for unit in self.units.values():
            room, still = unit.running_round and unit.running_round.room, self.paused or unit.paused
            if room and still and not room.held:
                room.hold(PAUSED, self.now())
            elif room and room.held and not still:
                room.release(self.now())

    # ---- from step to step (the lock is held) -----------------------------------------------------------------

    async def advance(self, session: ParticipantSession) -> None:
        """On to the step that follows."""
        rounds, unit = self.databases.rounds, session.record.unit
        over, played = frozenset[str](), frozenset[str]()
        if unit is not None and any(block.limit_minutes for block in self.study.blocks):
            over = blocks_over(self.study, await self.run(rounds.block_seconds, unit))
            played = await self.run(rounds.finished_steps, unit)
        step = next_step(session.steps, session.record.step, over, played)
        if step.kind == "code":
            await self._finish(session, "done")
        else:
            await self.move(session, step.key)

    async def move(self, session: ParticipantSession, key: str) -> None:
        await self.run(self.databases.store.move, session.pid, key)
        await self.refresh(session)

    async def refresh(self, session: ParticipantSession) -> None:
        """Read again what the store says of them."""
        before = session.record.step
        session.record = await self.run(self.databases.store.participant, session.pid)
        if session.record.step != before:
            session.since = self.now()

    async def _played(self, unit: StudyUnit, over: FinishedRound) -> None:
        """A round or the practice has ended; one that was broken off is begun again."""
        for session in unit.at(over.step) if over.counts else []:
            await self.advance(session)
        self.push(*unit.members)

    async def _catch_up(self, unit: StudyUnit) -> None:
        """After a crash: a round that was finished and not yet counted as such is."""
        finished = await self.run(self.databases.rounds.finished_steps, unit.record.id)
        for session in unit.members:
            while not session.finished and session.record.step in finished:
                await self.advance(session)

    # ---- pairs (the lock is held) -----------------------------------------------------------------------------

    async def form(self, sessions: list[ParticipantSession]) -> None:
        """Give one or two a slot, and let them begin what depends on it."""
        record = await self.run(self.databases.store.form_unit, [session.pid for session in sessions])
        self._add_unit(record, sessions)
        for session in sessions:
            await self.refresh(session)
        await self.bring_in(self.units[record.id])
        if record.slot >= self.study.units:
            self.alerts.raise_("full", f"There are more participants than planned: slot {record.slot + 1} was given.")
        self.push(*sessions)

    def _add_unit(self, record: Unit, sessions: list[ParticipantSession], episode: str = "") -> None:
        self.units[record.id] = StudyUnit(record, sessions, paused=record.paused, episode=episode)
        for session in sessions:
            session.steps = steps(self.study, assign(self.study, record.slot))

    async def bring_in(self, unit: StudyUnit) -> None:
        """Nobody of a unit is left before its first step, also when a kill or the database came between."""
        for session in unit.members:
            if session.before_unit_steps:
                await self.move(session, next_step(session.steps, LAST_ALONE).key)

    async def match(self) -> None:
        """Pair those who wait, and let nobody wait for ever."""
        now = self.now()
        for session in self.sessions.values():
            if session.record.step == WAITING and session.record.unit is None and not session.finished:
                self.waiting.enter(session.pid, session.since, session.record.screen)
            if session.listeners and session.present(now):
                self.waiting.heard(session.pid, now)
        while (pair := self.waiting.pair(now)) is not None:
            await self.form([self.sessions[pid] for pid in pair])
        for pid in self.waiting.over(now):
            session = self.sessions[pid]
            if self.study.pairing.otherwise == "agent" and session.present(now):
                await self.form([session])
            else:
                await self._finish(session, "no-partner")
                self.push(session)
            self.waiting.leave(pid)

    # ---- going (the lock is held) -----------------------------------------------------------------------------

    async def dismiss(self, session: ParticipantSession, outcome: Outcome, keep: bool = True) -> None:
        """Somebody leaves before the end; a partner is free to go, and paid."""
        if session.finished:
            return
        if not keep:
            await self.run(self.databases.store.keep_data, session.pid, False)
        await self._finish(session, outcome)
        self.waiting.leave(session.pid)
        self.push(session)
        unit = self.unit_of(session)
        if unit is not None:
            await self.part(unit)
        if not keep:
            self.remove_data(session)

    async def part(self, unit: StudyUnit) -> None:
        """Somebody of them has left: nobody else is kept waiting for rounds that cannot be."""
        self.rooms.close(unit, "The round was ended, because somebody left the study.", "left")
        for other in unit.members:
            if not other.finished and other.has_rounds_left():
                await self._finish(other, "partner-left")
                self.push(other)

    async def _finish(self, session: ParticipantSession, outcome: Outcome) -> None:
        """Give the one and only code."""
        await self.run(self.databases.store.finish, session.pid, outcome, self._code(outcome))
        await self.refresh(session)

    def _code(self, outcome: Outcome) -> str:
        fixed = {} if self.study.codes == "unique" else self.study.codes
        return fixed.get(outcome) or "".join(secrets.choice(CODE_LETTERS) for _ in range(CODE_LENGTH))

    def remove_data(self, session: ParticipantSession) -> None:
        """Delete what they did, soon; a server that is killed before does it when it starts again."""
        task = asyncio.create_task(self._withdraw(session))
        self._removals.add(task)
        task.add_done_callback(self._removals.discard)

    async def _withdraw(self, session: ParticipantSession) -> None:
        """Delete answers and recordings once the last recording is on the disk. The code stays, to be paid."""
        await self.rooms.finish()
        await self.host.archive.settled()
        store = self.databases.store
        try:
            if await self.run(has_deeds, store, session.pid):
                episodes = await self.run(episodes_of, store, session.pid)
                removed = await asyncio.to_thread(remove_recordings, self.folder.recordings, session.pid, set(episodes))
                await self.run(clear, store, session.pid, removed)
        except StudyError as error:
            self.alerts.raise_("deletion", f"The data of {session.pid} could not be deleted: {error}")
