"""The rooms of one process: their clock, their sockets and agents, and what a restart needs of them."""

import asyncio
import contextlib
import errno
import logging
import time
from collections.abc import Callable
from pathlib import Path

import psutil

from movingout.agents.catalogue import agent_cards
from movingout.maps import TUTORIAL, MovingOutError, load_map, shipped_map_names
from movingout.recordings import EpisodeWriter
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server import messages as m
from movingout.server.agent_workers.capacity import COSTS, COSTS_S, AgentCosts
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.background import BackgroundWork, reason
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.closing import KEPT, CloseConnection, no_room
from movingout.server.connection.endpoint import SocketEndpoint
from movingout.server.garbage_collection import GarbageCollection
from movingout.server.monitoring.overload import Overload, ProcessHealth
from movingout.server.notices import ErrorCode
from movingout.server.open_files import within_open_files
from movingout.server.own_maps.workers import MapWorkers
from movingout.server.persistence.fsync import sync_recordings, try_writing
from movingout.server.persistence.room_snapshot import restore_room, room_file
from movingout.server.persistence.room_store import RoomFile, RoomStore
from movingout.server.public_host import Away, NoRoom
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import RESTART_SOON
from movingout.server.rooms.room_view import PlayedRound, played_round
from movingout.server.rooms.scheduler import RoomScheduler
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.tokens import new_id
from movingout.server.settings import Settings
from movingout.world import World
from movingout.world.distance import paper_distances

log = logging.getLogger(__name__)

SYNC, SYNC_S = "saving recordings to the disk", 1.0
WRITING, WRITING_S = "writing to the folder of recordings", 30.0
CPU_SAMPLES = 5  # seconds that the CPU share is averaged over


class FolderReplacedError(FileNotFoundError):
    """Another folder lies where the recordings are: rounds that begin now are recorded there."""


class RoomKept(Away):
    """The room waits for a start at which it can be opened."""

    code: ErrorCode = "room_kept"


class RoomHost:
    """`start_rooms`, `suspend` and `stop_rooms` run inside the event loop."""

    def __init__(
        self, settings: Settings, new_room_id: Callable[[], str] = new_id, agents: AgentPool | None = None
    ) -> None:
        self.settings = settings
        self.scheduler = RoomScheduler(time.monotonic, settings.tick_s)
        self.admission = AdmissionControl(
            within_open_files(settings.limits), time.monotonic, secret=settings.admin_token
        )
        self.agents = agents or _agents_of_its_own(settings)
        self.store = self._room_store()
        self.cpu_share = 0.0  # of one core, over the last seconds: for people to see
        self.overload = Overload(self.scheduler, settings.limits, time.monotonic)
        self.stopping = False
        self.background = BackgroundWork()
        self._garbage = GarbageCollection()
        self._process = psutil.Process()
        self._missing_maps = MapWorkers()  # starts no process before a round misses its map
        self.registry = RoomRegistry(
            recordings=settings.recordings,
            agents=self.agents,
            scheduler=self.scheduler,
            clock=time.monotonic,
            on_change=self.save,
            on_closed=self.room_closed,
            on_journal=self._round_recorded,
            new_room_id=new_room_id,
            owns=self.owns,
            make_map=self._missing_maps.variant,
        )
        self.registry.watch_rounds(self._study_round_over)
        self.endpoint = SocketEndpoint(settings, self.registry, self.admission, self._kept)
        self.endpoint.absence = self.absence
        self._recordings_id: tuple[int, int] | None = None
        self.not_opened: dict[str, str] = {}  # rooms that wait for the next start; the round that each was playing

    def owns(self, room_id: str) -> bool:
        """Whether a room that is here may go on at this moment."""
        return True

    def _room_store(self) -> RoomStore:
        return RoomStore(self.settings.rooms, self.settings.study)

    async def start_rooms(self) -> None:
        """Begin to tick; rooms may have been restored before."""
        self._process.cpu_percent()  # the first call begins the measurement
        self.background.keep_running("the clock of the rooms", self.scheduler.run)
        self._recordings_id = _folder_id(self.settings.recordings)
        self.background.repeat(SYNC, self._sync, SYNC_S)
        self.background.repeat(WRITING, self._try_writing, WRITING_S, may_be_late=True)
        self.background.repeat("keeping the costs of agents", self._keep_costs, COSTS_S)
        self.background.repeat("watching the load", self._watch_cpu, 1.0)
        self._garbage.start()

    async def suspend(self) -> None:
        """Keep rooms and rounds as they are for the next run, and tell the clients."""
        if self.stopping:
            return
        self.stopping = self.endpoint.stopping = True
        await self.background.stop()
        for room in self.registry.rooms.values():
            self._keep(room)
            room.suspend()
        deadline = time.monotonic() + 2.0
        while self.endpoint.open and time.monotonic() < deadline:
            await asyncio.sleep(0.02)

    def hold_rounds(self) -> int:
        """Let no further round begin; the number of those that are still being played."""
        rooms = list(self.registry.rooms.values())
        for room in rooms:
            room.hold_next(RESTART_SOON)
        return sum(room.phase in ("countdown", "playing") for room in rooms)

    async def stop_rooms(self) -> None:
        """End the agents, and wait until every room is written; after `suspend`."""
        await self.agents.close()
        await self._missing_maps.close()
        self.agents.costs.save()
        await asyncio.to_thread(self.store.close)
        self._garbage.stop()

    async def _kept(self) -> None:
        """Wait until what was saved so far would survive the process."""
        if not self.stopping:
            await self.store.written()

    def room(self, room_id: str) -> Room:
        """Raises NoRoom, and RoomKept where it waits for the next start."""
        room = self.registry.rooms.get(room_id)
        if room is None and room_id in self.not_opened:
            raise RoomKept(KEPT.message)
        if room is None:
            raise NoRoom(f"there is no room {room_id}")
        return room

    def absence(self, room_id: str) -> CloseConnection:
        """How a connection ends if its room is not here: a room that waits for a start can be found later."""
        return CloseConnection(m.CLOSE_SHUTDOWN, KEPT) if room_id in self.not_opened else no_room(room_id)

    async def open_kept(self, config: RoomConfig, seats: list[Seat]) -> Room:
        """Open a room and wait until a restart would bring it back. Raises MapError and AgentError."""
        room = self.registry.open(config, seats)
        await self._kept()
        return room

    # ---- what a room tells ----------------------------------------------------------------------------------

    def _study_round_over(self, room_id: str, episode: str, result: m.Result) -> None:
        room = self.registry.rooms.get(room_id)
        if room is not None and room.config.study:
            self.round_over(room_id, played_round(room, result))

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        """A round of a study is over: called within its last tick."""
        raise NotImplementedError

    def finish_journal(self, journal: Path) -> None:
        """A round is over: its journal is to become a recording."""
        raise NotImplementedError

    def recorded(self, room_id: str, size: int) -> None:
        """A round of a room has taken so many bytes on the disk."""
        raise NotImplementedError

    def _round_recorded(self, journal: Path) -> None:
        episode = journal.name.removesuffix(JOURNAL_SUFFIX)
        with contextlib.suppress(OSError, StopIteration):
            room_id = next(room.id for room in self.registry.rooms.values() if room.round.episode_id == episode)
            self.recorded(room_id, journal.stat().st_size)
        self.finish_journal(journal)

    def room_closed(self, room_id: str) -> None:
        self.store.delete(room_id)

    def save(self, room: Room) -> None:
        """Keep what a restart needs, until the server stops: what happens then is no change of a room."""
        if not self.stopping:
            self._keep(room)

    def _keep(self, room: Room) -> None:
        """Save a room, or delete what was saved: nobody returns to a closed room or a finished round of a study."""
        if room.phase == "closed" or (room.config.study and room.phase == "series_over"):
            self.store.delete(room.id)
        else:
            self.store.save(room_file(room, time.time()))

    # ---- restart --------------------------------------------------------------------------------------------

    async def prepare_map(self, file: RoomFile) -> None:
        """Make the randomised map of a room that comes back beforehand, so that it delays no tick."""
        config, index = file.config, file.index
        with contextlib.suppress(MovingOutError):  # the room reports it
            wanted = config.designed(index), config.variant_seed(index), config.split
            await self.registry.prepared_maps.prepare(*wanted)

    async def restore(self, file: RoomFile) -> None:
        """Open a room of the last run again, even where its agents would be refused as too busy."""
        await self.prepare_map(file)
        try:
            with self.agents.without_limit():
                room = restore_room(file, self.settings.recordings, self.registry, time.monotonic())
        except MovingOutError as error:
            self.cannot_open(file, error)
        else:
            self.came_back(room)

    def cannot_open(self, file: RoomFile, error: MovingOutError) -> None:
        """A package or a folder may be missing at this start only: the room and its journal wait for the next one.

        Where somebody removes the room's file, the next start finishes the journal. Not so in a study, which plays on
        without: it takes the round as far as it was recorded.
        """
        if file.config.study:
            log.warning("room %s does not come back, and its round ends where it was interrupted: %s", file.id, error)
            self.store.delete(file.id)
        else:
            kept = "its file and the recording of its round are kept for the next start"
            ends = f"to end it, remove {file.id}.json below {self.settings.rooms} before then"
            log.warning("room %s does not come back now; %s; %s: %s", file.id, kept, ends, error)
            self.not_opened[file.id] = file.episode

    def came_back(self, room: Room) -> None:
        """A room of the last run, or of another process or node, goes on here."""
        self.registry.add(room)
        self.not_opened.pop(room.id, None)

    def episodes(self) -> list[str]:
        """The rounds that have begun here or wait for the next start, whose journals must be left alone."""
        begun = [room.round.episode_id for room in self.registry.rooms.values() if room.round.started]
        return begun + [episode for episode in self.not_opened.values() if episode]

    # ---- health ---------------------------------------------------------------------------------------------

    def process_health(self) -> ProcessHealth:
        """What this process says of itself."""
        faults = (*self.background.faults(), *self.agents.faults())
        return ProcessHealth(self.cpu_share, self.overload.busy, self.agents.connected, faults, self._unwritable())

    def _unwritable(self) -> str:
        """Why a round that began now would not be recorded: writing failed the last time, or is stuck."""
        for work in (SYNC, WRITING):
            error = self.background.error(work)
            if error is not None and not isinstance(error, FolderReplacedError):
                return f"{work}: {reason(error)}"
        return f"{WRITING}: the disk does not answer" if self.background.stuck(WRITING) else ""

    def sync_age_s(self) -> float:
        """Since recordings were last forced to the disk."""
        return self.background.age_s(SYNC)

    # ---- in the background ----------------------------------------------------------------------------------

    async def _sync(self) -> None:
        """Make what was recorded survive a power failure; in a thread, because disks are slow."""
        folder = self.settings.recordings
        found, writers = _folder_id(folder), self._writers()
        if found is None:
            raise FileNotFoundError(errno.ENOENT, "the folder was moved away", str(folder))
        if found != self._recordings_id:
            raise FolderReplacedError(errno.ENOENT, "the folder was replaced by another one", str(folder))
        if writers:
            await asyncio.to_thread(sync_recordings, folder, writers)
        elif self.background.error(SYNC) is not None:  # that round is over, the reason may not be
            await asyncio.to_thread(try_writing, folder)

    async def _try_writing(self) -> None:
        """Notice a full or read-only disk while nobody plays: rounds that are not recorded are played all the same.

        While somebody plays, saving tells whether recordings can be written.
        """
        if not self._writers():
            await asyncio.to_thread(try_writing, self.settings.recordings)

    def _writers(self) -> list[EpisodeWriter]:
        recorders = [room.round.recorder for room in self.registry.rooms.values()]
        return [recorder.writer for recorder in recorders if recorder.writer is not None]

    async def _keep_costs(self) -> None:
        await asyncio.to_thread(self.agents.costs.save)

    async def _watch_cpu(self) -> None:
        self.cpu_share += (self._process.cpu_percent() / 100.0 - self.cpu_share) / CPU_SAMPLES
        self.overload.sample()
        self._garbage.consider(any(room.phase == "playing" for room in self.registry.rooms.values()))


def _agents_of_its_own(settings: Settings) -> AgentPool:
    costs = AgentCosts(settings.data / COSTS)
    return AgentPool(
        settings.agent_workers,
        costs=costs,
        thread_cores=settings.agent_thread_cores,
        slow_agents=settings.slow_agents,
    )


def _folder_id(folder: Path) -> tuple[int, int] | None:
    """The identity of the folder at this path; None if there is none."""
    try:
        about = folder.stat()
    except OSError:
        return None
    return about.st_dev, about.st_ino


def warm_up() -> None:
    """Load every map, its distance field and the engine before the first player comes."""
    for name in (*shipped_map_names(), TUTORIAL):
        the_map = load_map(name)
        paper_distances(the_map)
        World(the_map).step([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    agent_cards()
