"""A running study with the routes of its pages: what a server starts, and stops when another one goes on with it."""

from collections.abc import Callable

from fastapi import APIRouter

from movingout.server.public_host import PublicHost
from movingout.server.study.api import experimenter, participant
from movingout.server.study.api.dashboard import Dashboard
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.arrivals.admission import Admission
from movingout.server.study.arrivals.session_service import SessionService
from movingout.server.study.experimenter_actions import ExperimenterActions
from movingout.server.study.metrics import study_faults, study_metrics
from movingout.server.study.monitor import StudyMonitor
from movingout.server.study.running_study import RunningStudy, always
from movingout.study.data.study_folder import StudyFolder


class ServedStudy:
    """Raises StudyError when the databases cannot be used, or when the study is not what it began with.

    `in_charge` says whether this server may act for the study at this moment.
    """

    def __init__(
        self,
        host: PublicHost,
        folder: StudyFolder,
        file_text: str,
        admission: Admission,
        in_charge: Callable[[], bool] = always,
    ) -> None:
        self._host = host
        self.running = RunningStudy(folder, file_text, host, admission, in_charge)
        self.monitor = StudyMonitor(self.running)
        self.session_service = SessionService(self.running)
        views = ParticipantViews(self.running)
        actions = ExperimenterActions(self.running, self.session_service)
        self.routers: tuple[APIRouter, ...] = (
            participant.routes(self.running, self.session_service, views),
            experimenter.routes(self.running, actions, Dashboard(self.running, views)),
        )
        self._metrics = lambda: study_metrics(self.running)
        self._faults = lambda: study_faults(self.running)
        host.metric_sources.append(self._metrics)
        host.checks.append(self._faults)

    async def start(self) -> None:
        await self.running.start()
        self.monitor.start()

    async def stop(self) -> None:
        self.detach()
        await self.monitor.stop()
        await self.running.stop()

    def detach(self) -> None:
        """Hear of no round any more, at once, and let pages ask elsewhere."""
        self.running.let_go = True
        if self._metrics in self._host.metric_sources:
            self._host.metric_sources.remove(self._metrics)
            self._host.checks.remove(self._faults)
        self._host.round_watchers.clear()
