"""A study that is being run: its parts, started and stopped in order, and the lock on its changes.

Every change is in the database before anybody is told of it; everything here can be restored from it after a crash.
"""

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from movingout.server.host import Host
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.departures import Departures
from movingout.server.study.notes import ExperimenterNotes
from movingout.server.study.participants import Participants
from movingout.server.study.progress import Progress
from movingout.server.study.room_setup import RoomSetup
from movingout.server.study.study_rooms import StudyRooms
from movingout.server.study.transaction import Transaction
from movingout.server.study.units import Units
from movingout.study.data.study_folder import StudyFolder


class RunningStudy:
    """One study in one server. `start` and `stop` run inside the event loop, after and before the host's."""

    def __init__(
        self, folder: StudyFolder, file_text: str, host: Host, needs_code: bool = False, simulated: bool = False
    ) -> None:
        self.study = folder.study
        self.host = host
        self.needs_code = needs_code
        self.simulated = simulated
        self.alerts = Alerts()
        self.databases = StudyDatabases(folder, file_text, self.alerts, simulated)
        self._lock = asyncio.Lock()
        self.participants = Participants(self.study, self.databases)
        self.units = Units(self.study, self.participants, self.databases, self.alerts)
        self.progress = Progress(self.study, self.participants, self.units, self.databases)
        self.rooms = StudyRooms(
            RoomSetup(self.study, host, simulated),
            host=host,
            databases=self.databases,
            alerts=self.alerts,
            transaction=self.transaction,
            on_saved=self.progress.round_ended,
        )
        self.departures = Departures(
            folder.recordings,
            host=host,
            databases=self.databases,
            alerts=self.alerts,
            participants=self.participants,
            units=self.units,
            rooms=self.rooms,
        )
        self.notes = ExperimenterNotes(self.databases, self.participants)

    @asynccontextmanager
    async def transaction(self) -> AsyncIterator[Transaction]:
        """The right to change who is where, for one holder at a time: the two of a pair cannot overtake each other."""
        asked = time.monotonic()
        async with self._lock:
            tx = Transaction(self.databases, asked)
            try:
                yield tx
            finally:
                tx.end()

    async def start(self) -> None:
        """Bring everybody back to where they were."""
        known = await self.databases.run(self.databases.identities.everybody)
        async with self.transaction() as tx:
            await self.participants.restore(tx, {pid: source for pid, (source, _) in known.items()})
            await self.notes.restore()
            await self.units.restore(tx)
            await self.rooms.resume(tx, self.units)
            await self.progress.restore(tx)
            for unit in self.units:
                await self.progress.catch_up(tx, unit)
                await self.units.move_to_first_step(tx, unit)
        for session in self.participants:
            if session.record.keep is False and session.finished:
                self.departures.delete_data(session)

    async def stop(self) -> None:
        await self.rooms.saved()
        await self.departures.deleted()
        self.databases.close()
