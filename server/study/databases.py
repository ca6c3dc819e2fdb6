"""The databases of a study for the event loop: one thread runs all queries, one after the other."""

import asyncio
import time
from collections.abc import Callable
from concurrent import futures
from concurrent.futures import ThreadPoolExecutor
from typing import ParamSpec, TypeVar

from movingout.server.study.alerts import Alerts
from movingout.study.data.study_folder import StudyFolder
from movingout.study.data.versions import agent_code, code_versions, model_hashes
from movingout.study.errors import StoreError, StoreLocked, StudyError
from movingout.study.store import IdentityStore, Store
from movingout.study.store.database import Database, shown
from movingout.study.store.frozen_study import freeze_study, is_new
from movingout.study.store.rounds import Rounds

LOOK_S = 1.0  # between two looks whether a query is answered
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

MOST_WAITING = 500  # queries: two seconds' worth (220 answers a second, measured); whoever comes then tries again


_WHAT_HELPS = (
    "Move it back, or bring back the last backup: movingout study restore. To begin anew, choose another --data folder"
)


class StoreBusy(StoreError):
    """More queries wait already than are answered while somebody waits."""


class StudyDatabases:
    """Opened once per run, which freezes the study.

    Raises StoreError, and StudyError if the study has changed or one of its databases was lost.
    """

    def __init__(self, folder: StudyFolder, file_text: str, alerts: Alerts, simulated: bool) -> None:
        self.store: Store = folder.open()
        try:
            self._refuse_unknown(folder)
            self.identities: IdentityStore = folder.open_identities()
            try:
                self._refuse_lost(folder)
                code = code_versions() | agent_code(folder.study)
                models = model_hashes(folder.study)
                forget = self.identities.drop_visitors
                freeze_study(self.store, folder.study.id, file_text, code, models, simulated, forget)
                self._forget_half_arrived()
            except StudyError:
                self.identities.close()
                raise
        except StudyError:
            self.store.close()
            raise
        self.rounds = Rounds(self.store)
        self._alerts = alerts
        self.problem = ""  # of the newest query, empty when it succeeded
        for database in self._databases():
            database.hurry()
        self._locked = ""  # what a query was told that last gave up waiting, and when
        self._locked_at = float("-inf")
        self._working_since: float | None = None  # of the monotonic clock; None while no query runs
        self._waiting = 0  # queries, with the one that is under way
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="study-store")

    def _refuse_lost(self, folder: StudyFolder) -> None:
        """Raises StudyError where people are known who took part in a study whose database is not there any more.

        They would begin once more, and be paid twice.
        """
        known = len(self.identities.everybody()) if is_new(self.store) else 0
        if known:
            address = shown(self.store.database.address)
            raise StudyError(
                f"the database {address} of study {folder.study.id} is empty, but the identities of participants are "
                f"there ({known}): it was moved or lost. {_WHAT_HELPS}"
            )

    def _forget_half_arrived(self) -> None:
        """Delete ids that a kill left of people before it was written down that they came.

        At a start nobody else writes: no other server serves the study, and nobody is just arriving.
        """
        known = {one.pid for one in self.store.everybody()}
        self.identities.drop_visitors([one.pid for one in self.identities.without(known) if one.half_arrived])

    def _refuse_unknown(self, folder: StudyFolder) -> None:
        """Raises StudyError where people have taken part whose identities are not there any more, and makes none anew.

        A file without rows is another case: identities are deleted when the study no longer needs them.
        """
        if folder.has_identities:
            return
        if number := len(self.store.everybody()):
            raise StudyError(
                f"{folder.identity_file} of study {folder.study.id}, which says who is who, is not there, but people "
                f"have taken part ({number}): it was moved, lost or deleted. Those who come back would begin once "
                f"more. {_WHAT_HELPS}"
            )

    async def run(self, work: Callable[Arguments, Result], *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        """Do `work` in the thread. Raises StoreError, after alerting the experimenter; at once where too many wait."""
        if self._waiting >= MOST_WAITING:
            error = StoreBusy(f"{MOST_WAITING} queries wait for the database already")
            self._alerts.add("database", "The database could not be read or written.", str(error))
            raise error
        return await self.run_asked(time.monotonic(), work, *args, **kwargs)

    async def run_asked(
        self, asked: float, work: Callable[Arguments, Result], *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Result:
        """The same for what has waited since `asked`, in seconds of the monotonic clock, and is never one too many.

        Transactions come here: one at a time, and one that has begun is not to be refused half way.
        """

        def unless_locked() -> Result:
            if asked < self._locked_at:  # it waited behind a query that gave up: it need not give up after as long
                raise StoreLocked(self._locked)
            self._working_since = time.monotonic()
            try:
                return work(*args, **kwargs)
            except StoreLocked as error:
                self._locked, self._locked_at = str(error), time.monotonic()
                raise
            finally:
                self._working_since = None

        loop = asyncio.get_running_loop()
        self._waiting += 1
        try:
            found = await self._answer(loop.run_in_executor(self._thread, unless_locked))
            self.problem = ""
            return found
        except StoreError as error:
            self.problem = str(error)
            self._alerts.add("database", "The database could not be read or written.", str(error))
            raise
        finally:
            self._waiting -= 1

    async def _answer(self, future: asyncio.Future[Result]) -> Result:
        try:
            while not (await asyncio.wait([future], timeout=LOOK_S))[0]:
                self._give_up_silent()
            return future.result()
        finally:
            future.cancel()  # what still waits when nobody wants it any more

    def _give_up_silent(self) -> None:
        """Let a query fail that PostgreSQL does not answer: a thread cannot be interrupted otherwise."""
        since = self._working_since
        if since is not None:
            silent = [database.give_up(since) for database in self._databases()]
            self.problem = "the database does not answer" if any(silent) else self.problem

    def _databases(self) -> tuple[Database, Database]:
        return self.store.database, self.identities.database

    def close(self) -> None:
        last = self._thread.submit(int)
        while not futures.wait([last], LOOK_S).done:
            self._give_up_silent()
        self._thread.shutdown()
        self.store.close()
        self.identities.close()
