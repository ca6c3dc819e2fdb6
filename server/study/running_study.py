"""A study that is being run: its parts, started and stopped in order, and the lock on its changes.

Every change is in the database before anybody is told of it; everything here can be restored from it after a crash.
"""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from math import inf
from pathlib import Path

from movingout.server.public_host import PublicHost
from movingout.server.study.alerts import Alerts
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.arrivals.arrival_link import PLATFORMS
from movingout.server.study.arrivals.signed_links import LinkSigner
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.deletions import Deletions
from movingout.server.study.departures import Departures
from movingout.server.study.notes import ExperimenterNotes
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.participants import Participants
from movingout.server.study.progress import Progress
from movingout.server.study.rounds.room_setup import RoomSetup
from movingout.server.study.rounds.study_rooms import StudyRooms
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import StudyUnit
from movingout.server.study.units import Units
from movingout.study.data.study_folder import StudyFolder
from movingout.study.errors import StoreError
from movingout.study.store.frozen_study import frozen_study

NOTE_S = 5.0  # for which a server that stops tries to note who is here


def always() -> bool:
    """Of a study in one server."""
    return True


class RunningStudy:
    """One study in one server. `start` and `stop` run inside the event loop, after and before the host's."""

    def __init__(
        self,
        folder: StudyFolder,
        file_text: str,
        host: PublicHost,
        admission: Admission,
        in_charge: Callable[[], bool] = always,
    ) -> None:
        self.alerts = Alerts()
        self.databases = StudyDatabases(folder, file_text, self.alerts, admission.simulated)
        self.study = folder.study.allocated_by(frozen_study(self.databases.store).allocation)
        self.host = host
        self.admission = admission
        self.signer = LinkSigner.in_folder(folder.own, folder.study.id)
        self.let_go = False  # whether another server goes on with it
        self._in_charge = in_charge  # whether no other server runs the study meanwhile
        self._lock = asyncio.Lock()
        self._half_read = False  # while a start reads who was here
        self.participants = Participants(self.study, self.databases)
        self.units = Units(self.study, self.participants, self.databases, self.alerts)
        self.progress = Progress(self.study, self.participants, self.units, self.databases, self._hold)
        self.rooms = self._make_rooms()
        self.notes = ExperimenterNotes(self.databases, self.participants)
        self.deletions = self._make_deletions(folder.recordings)
        self.departures = self._make_departures()

    def _make_rooms(self) -> StudyRooms:
        return StudyRooms(
            RoomSetup(self.study, self.host, self.admission.simulated),
            host=self.host,
            databases=self.databases,
            alerts=self.alerts,
            transaction=self.transaction,
            on_saved=self.progress.round_ended,
            on_recovered=self.progress.catch_up,
        )

    def _make_deletions(self, recordings: Path) -> Deletions:
        return Deletions(
            recordings,
            host=self.host,
            databases=self.databases,
            alerts=self.alerts,
            participants=self.participants,
            units=self.units,
            finished=self.rooms.finished,
            notes=self.notes,
        )

    def _make_departures(self) -> Departures:
        return Departures(
            databases=self.databases,
            participants=self.participants,
            units=self.units,
            rooms=self.rooms,
            deletions=self.deletions,
            notes=self.notes,
            is_paused=self.progress.is_paused,
        )

    def is_over(self) -> bool:
        """Whether nobody hears anything more from here."""
        return self.host.stopping or self.let_go or not self._in_charge()

    async def _hold(self, tx: Transaction, unit: StudyUnit, paused: bool) -> None:
        await self.rooms.hold(tx, unit, paused)

    def device_bound(self, session: ParticipantSession) -> bool:
        """Whether they may come back in their own browser only.

        Anybody who knows somebody's id on a platform can make that link; the other links are secrets themselves.
        """
        free = self.admission.any_device or session.any_device or not session.has_consented
        return session.source in PLATFORMS and not free

    @asynccontextmanager
    async def transaction(self, asked: float | None = None) -> AsyncIterator[Transaction]:
        """The right to change who is where, for one holder at a time: the two of a pair cannot overtake each other.

        `asked`: since when it was waited for elsewhere, in seconds of the monotonic clock.
        """
        since = time.monotonic() if asked is None else asked
        async with self._lock:
            tx = Transaction(self.databases, since, self._in_charge)
            try:
                yield tx
            finally:
                tx.end()

    async def start(self) -> None:
        """Bring everybody back to where they were."""
        known = await self.databases.run(self.databases.identities.everybody)
        async with self.transaction() as tx:
            self._half_read = True
            back_s = await self.participants.restore(tx, {pid: source for pid, (source, _) in known.items()})
            self._tell_of_clock(back_s)
            await self.notes.restore()
            await self.units.restore(tx)
            await self.rooms.resume(tx, self.units)
            await self.progress.restore(tx)
            await self.progress.catch_up_all(tx)
            for unit in self.units:
                await self.units.move_to_first_step(tx, unit)
                if unit.lacks_member:
                    await self.departures.release_partners(tx, unit)
            self._half_read = False
        left = [one.pid for one in self.participants if one.record.keep is False and one.finished]
        self.deletions.resume(left, await self.databases.run(self.databases.store.database.is_unscrubbed))

    def _tell_of_clock(self, back_s: float) -> None:
        if back_s:
            minutes = round(back_s / 60, 1)
            text = f"The clock is {minutes:g} min behind the times of before the start; everybody's paid time goes on."
            self.alerts.add("clock", text, minutes=minutes)

    async def stop(self) -> None:
        await self.rooms.finished.saved()
        await self.deletions.end()
        with suppress(StoreError, TimeoutError):  # or what was noted a minute ago counts
            async with asyncio.timeout(NOTE_S), self.transaction() as tx:
                if not self._half_read:  # else who was away already seems to have left only now
                    await self.participants.note_absences(tx)
                    await self.participants.note_last_seen(tx)
        await self.participants.scrub_identities(inf)
        await asyncio.to_thread(self.databases.close)  # a query may have to be given up first
