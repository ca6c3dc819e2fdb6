"""How rounds ended that nobody could tell of, because a process was killed: what their recordings say."""

import logging
import time
from pathlib import Path

from movingout.recordings import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.public_host import PublicHost
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.rounds.round_outcomes import NOT_RECORDED, recovered_players, recovered_round
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import FinishedRound, RunningRound, StudyUnit
from movingout.study.errors import StudyError
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome

log = logging.getLogger(__name__)

FINISHED_S = 30.0  # in which the journal of a lost room should have become a recording
Recovered = tuple[RoundOutcome, list[PlayerOutcome]]


class RoundRecovery:
    """Reads recordings of the host; alerts the experimenter to journals that cannot be finished."""

    def __init__(self, host: PublicHost, databases: StudyDatabases, alerts: Alerts) -> None:
        self._host = host
        self._databases = databases
        self._alerts = alerts

    async def round(self, episode: str, unit: StudyUnit | None, may_come: bool = False) -> Recovered | None:
        """How far a round was recorded; None while its journal is not finished, which `may_come` takes calmly."""
        try:
            found = await self._host.recording_service.read(episode, recovered_round, urgent=True)
        except RecordingError as error:
            if not self._journal(episode).exists():
                log.warning("the round %s has no recording: %s", episode, error)
                return NOT_RECORDED, []
            if not may_come:
                text = f"The recording {episode} cannot be finished."
                self._alerts.add("recovery", text, str(error), episode=episode)
            return None
        return found.outcome, recovered_players(found, unit)

    def is_coming(self, episode: str) -> bool:
        """Whether a journal is still to become a recording, here or at another server."""
        return self._journal(episode).exists()

    def _journal(self, episode: str) -> Path:
        return self._host.settings.recordings / f"{episode}{JOURNAL_SUFFIX}"

    async def save(self, tx: Transaction, episode: str, unit: StudyUnit | None) -> RoundOutcome:
        """Save the outcome of a round that a killed server did not save, as far as it was recorded."""
        found = await self.round(episode, unit)
        if found is None:
            return NOT_RECORDED  # the row stays open, and the next start tries again
        try:
            await tx.run(self._databases.rounds.end, episode, *found, recovered=True)
        except StudyError as error:
            text = f"The round {episode} stays open in the database."
            self._alerts.add("not_closed", text, str(error), episode=episode)
            return NOT_RECORDED
        return found[0]

    async def lost(self, unit: StudyUnit, running: RunningRound) -> FinishedRound | None:
        """The end of a round whose room is gone; None while its journal is not finished."""
        episode, now = running.view.episode, time.monotonic()
        running.lost_since = now if running.lost_since is None else running.lost_since
        if running.step.turn is None:
            return FinishedRound(running.step, episode, NOT_RECORDED, ())
        if self._host.recording_service.knows(self._journal(episode)):
            return None  # it is being finished, which nobody waits for in a transaction
        found = await self.round(episode, unit, may_come=now - running.lost_since < FINISHED_S)
        return found and FinishedRound(running.step, episode, found[0], tuple(found[1]))
