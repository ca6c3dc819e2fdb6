"""What pages and the HTTP API need of a server, wherever its rooms are: in this process or in others."""

import asyncio
import contextlib
import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator
from typing import Any, Concatenate, ParamSpec, TypeVar

from prometheus_client.core import Metric

from movingout.maps import MapSpec, MovingOutError
from movingout.recordings.episode import Outcome
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.agent_workers.agent_use import AgentUse
from movingout.server.background import BackgroundWork
from movingout.server.connection.admission import AdmissionControl, address_group
from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.notices import NOTHING, ErrorCode, Notice
from movingout.server.own_maps.folder import MapFolder
from movingout.server.own_maps.workers import MapWorkers
from movingout.server.persistence.answer_log import AnswerLog
from movingout.server.persistence.disk_space import LEAST_FREE, disk_free
from movingout.server.persistence.recording_service import RecordingService
from movingout.server.persistence.recording_uploads import RecordingUploads
from movingout.server.persistence.room_store import episodes_of_other_studies
from movingout.server.rooms.lateness import Lateness
from movingout.server.rooms.prepared_maps import PreparedMaps, Variant
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.tokens import hash_token, new_token, token_matches
from movingout.server.settings import Settings

log = logging.getLogger(__name__)

DRAIN_LOOK_S = 0.2
ROOMS_AT_ONCE = 20  # that are asked about between two ticks
Given = ParamSpec("Given")
Found = TypeVar("Found")


class NoRoom(MovingOutError):
    """There is no such room."""


class Away(MovingOutError):
    """The process that is asked is being replaced; a moment later it can be reached again."""

    code: ErrorCode = "restarting"


class PublicHost(ABC):
    """Recordings, maps, answers and limits. Raises FolderError for `settings.maps`."""

    admission: AdmissionControl
    background: BackgroundWork
    stopping: bool

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.draining = False  # about to end, when the rounds are over
        self.admin_token = settings.admin_token or new_token()
        self.answer_log = AnswerLog(settings.answers)
        self.own_maps = MapFolder(settings.maps)
        self.own_maps.read()
        self.map_workers = MapWorkers(lambda address, seconds: self.admission.worked_on_map(address, seconds))
        self.started_at = time.monotonic()
        self._admin_hash = hash_token(self.admin_token)
        self.checks: list[Callable[[], Iterator[str]]] = []  # each names what else does not work
        self.metric_sources: list[Callable[[], Iterator[Metric]]] = []  # what else is measured
        self.round_watchers: list[Callable[[str, PlayedRound], None]] = []  # called when a round of a study is over
        self._preparing: set[asyncio.Task[None]] = set()
        self._recording_service: RecordingService | None = None
        self.uploads: RecordingUploads | None = None

    # ---- rooms, wherever they are ---------------------------------------------------------------------------

    @property
    @abstractmethod
    def room_count(self) -> int: ...

    @property
    @abstractmethod
    def prepared_maps(self) -> PreparedMaps: ...

    @property
    def most_rooms(self) -> int:
        return self.settings.limits.rooms

    @abstractmethod
    async def open_room(self, config: RoomConfig, seats: list[Seat]) -> str:
        """Open a room and return its id. Raises MapError, AgentError, AgentsBusyError (try another time) and Away."""

    @abstractmethod
    async def ask(
        self,
        room_id: str,
        work: Callable[Concatenate[Room, Given], Found],
        *args: Given.args,
        **kwargs: Given.kwargs,
    ) -> Found:
        """What `work(room, ...)` returns, done where the room is; all is picklable. Raises NoRoom and Away."""

    @abstractmethod
    async def close_room(self, room_id: str, code: int, notice: Notice, outcome: Outcome = "stopped") -> PlayedRound:
        """Close a room and forget it; how its round went. Raises NoRoom and Away."""

    async def close_rooms_owned_by(self, owner: str, code: int, notice: Notice) -> int:
        """Close all rooms of an owner (`admission.owner`); how many there were. None for the empty owner."""
        closed = 0
        for room_id in self.admission.rooms_owned_by(owner):
            with contextlib.suppress(NoRoom):  # it has ended meanwhile
                await self.close_room(room_id, code, notice)
                closed += 1
        return closed

    @abstractmethod
    async def look(self, rooms: Collection[str]) -> dict[str, RoomView | None]:
        """These rooms as they are, None for those that are gone; left out are those whose process is being replaced."""

    @property
    def shares_recordings(self) -> bool:
        """Whether other servers finish recordings in the same folder."""
        return False

    def reaches(self, room_id: str) -> bool:
        """Whether the process of a room is there; otherwise it is being replaced."""
        return True

    @abstractmethod
    async def study_rooms(self) -> list[str]:
        """The rooms of a study that there are."""

    @abstractmethod
    async def lateness(self) -> Lateness:
        """Of the ticks of all rooms."""

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        for watcher in self.round_watchers:
            watcher(room_id, played)

    @abstractmethod
    async def rounds_left(self) -> int:
        """Let no further round begin in any room; the number of those that are still being played."""

    @abstractmethod
    def health(self) -> ProcessHealth:
        """How the processes with rooms are, taken together."""

    @abstractmethod
    async def room_reports(self) -> list[dict[str, Any]]:
        """What each process with rooms reports (server.monitoring.status.room_report)."""

    async def other_reports(self) -> dict[str, dict[str, Any]]:
        """What each process without rooms reports, by its name; that of agents, where it is one, with its workers."""
        return {}

    @abstractmethod
    async def report(self) -> dict[str, Any]:
        """The server's state for the admin page and the load test."""

    @abstractmethod
    async def agent_use(self, wanted: Collection[str], taken: Collection[str]) -> AgentUse:
        """What agents take of the time that there is for them, as measured; agents are given by their ids."""

    @abstractmethod
    async def reset_measurements(self) -> None:
        """Begin to measure the lateness of ticks anew."""

    # ---- start and stop -------------------------------------------------------------------------------------

    @abstractmethod
    async def start(self) -> None:
        """Restore the rooms of the last run and start to tick."""

    @abstractmethod
    async def suspend(self) -> None:
        """Keep rooms and rounds as they are for the next run."""

    @abstractmethod
    async def stop(self) -> None:
        """Finalise every recording and end the other processes."""

    @property
    def recording_service(self) -> RecordingService:
        """Raises RuntimeError before the server was started."""
        if self._recording_service is None:
            raise RuntimeError("the server has not been started")
        return self._recording_service

    def is_admin(self, token: str) -> bool:
        return token_matches(token, self._admin_hash)

    def _start_public(self) -> None:
        for folder in (self.settings.recordings, self.settings.rooms, self.settings.answers):
            folder.mkdir(parents=True, exist_ok=True)
        if self.settings.s3:
            self.uploads = RecordingUploads(self.settings.recordings, self.settings.s3)
            self.background.keep_running("sending recordings", self.uploads.run)
            self._recording_service = RecordingService(self.settings.recordings, self.uploads.add)
        else:
            self._recording_service = RecordingService(self.settings.recordings)

    def _recover_journals(self, resumed: set[str]) -> None:
        """Finish the journals of the last run, except those of rounds that go on, here or with another study."""
        going_on = resumed | self._left_to_others()
        for journal in sorted(self.settings.recordings.glob(f"*{JOURNAL_SUFFIX}")):
            if journal.name.removesuffix(JOURNAL_SUFFIX) not in going_on:
                self.recording_service.recover(journal)

    def _left_to_others(self) -> set[str]:
        return {*episodes_of_other_studies(self.settings.rooms, self.settings.study)}

    async def _stop_public(self) -> None:
        await self.recording_service.close()
        if self.uploads is not None:
            await self.uploads.close()
        await self.map_workers.close()

    async def drain(self, within_s: float) -> None:
        """Return when every round that has begun is over, or time is up; from now on nothing new begins."""
        self.draining = True
        deadline = time.monotonic() + within_s
        while await self.rounds_left() and time.monotonic() < deadline:
            await asyncio.sleep(DRAIN_LOOK_S)

    # ---- whether a room may be opened, and recorded --------------------------------------------------------

    def refusal(self, for_operator: bool = False) -> Notice:
        """Why no room can be opened now, NOTHING when one can. Some are kept for the operator; see `RoomPlaces`."""
        most = self._most_rooms_for(for_operator)
        if self.stopping or self.draining:
            return Notice("restarting", "The server is being restarted; try again in a minute.")
        if self.room_count >= most:
            text = f"All {most} rooms are in use; close one or try again later."
            return Notice("rooms_in_use", text, {"rooms": most})
        if self.health().busy:
            return Notice("busy", "The server is busy, and running games come first; try again later.")
        return self.full_disk()

    def _most_rooms_for(self, operator: bool) -> int:
        limits = self.settings.limits
        reserve = 0 if operator or not self.settings.lobby else min(limits.rooms_for_operator, limits.rooms // 10)
        return self.most_rooms - reserve

    def faults(self) -> list[str]:
        """What does not work and will not by itself, in English."""
        return [*dict.fromkeys([*self.health().faults, *(fault for check in self.checks for fault in check())])]

    def why_not_ready(self) -> list[str]:
        """Why nobody should be sent here now, empty while rooms can be opened."""
        refusal = self.refusal()
        agents = [] if self.health().agents else ["no agent worker is connected"]
        return [*self.faults(), *agents, *([refusal.message] if refusal else [])]

    def disk_free(self) -> int:
        """Bytes, see `disk_space.disk_free`."""
        return disk_free(self.settings.data, self.settings.recordings)

    def full_disk(self) -> Notice:
        """Why nothing more can be recorded, NOTHING while there is room."""
        if self.disk_free() < LEAST_FREE:
            return Notice("disk_full", "The server's disk is almost full; free some space.")
        return NOTHING

    def cannot_record(self) -> Notice:
        """Why a round would not be recorded now, NOTHING where it would; the log says more."""
        why = self.health().unwritable
        return Notice("not_writable", f"Rounds would not be recorded ({why}).") if why else self.full_disk()

    # ---- randomised maps ------------------------------------------------------------------------------------

    async def prepare_maps(self, config: RoomConfig, address: str = "") -> None:
        """Make the randomised maps of a series in another process: wait for the first, the others follow.

        `address` is whose turn it is to wait; empty for a study and the operator. Raises MapError and Busy for the
        first one.
        """
        if config.challenge2_seed is None:
            return
        seed, rounds, group = config.challenge2_seed, range(len(config.maps)), address_group(address)
        wanted = [(config.designed(index), seed + index, config.split) for index in rounds]
        await self._prepare(wanted[:1], group)
        background = asyncio.create_task(self._prepare_ahead(wanted[1:], group))
        self._preparing.add(background)
        background.add_done_callback(self._preparing.discard)

    def keep_map(self, variant: Variant, made: MapSpec) -> None:
        """Keep a randomised map where rooms will look for it."""
        self.prepared_maps.keep(variant, made)

    async def _prepare(self, wanted: list[Variant], address: str) -> None:
        for each in wanted:
            if each not in self.prepared_maps:
                self.keep_map(each, await self.map_workers.variant(*each, address))

    async def _prepare_ahead(self, wanted: list[Variant], address: str) -> None:
        try:
            await self._prepare(wanted, address)
        except MovingOutError as error:  # the room asks for what it misses when its round comes
            log.warning("a map of a series was not varied ahead: %s", error)
