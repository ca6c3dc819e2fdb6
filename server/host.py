"""One running server: everything that lives as long as the process, started and stopped in order."""

import asyncio
import logging
import shutil
import time

import psutil

from movingout.agents.catalogue import agent_cards
from movingout.maps import TUTORIAL, MapSpec, MovingOutError, load_map, shipped_map_names
from movingout.maps.randomize import Split
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server import messages as m
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.background import BackgroundWork
from movingout.server.connection.admission import AdmissionControl
from movingout.server.connection.endpoint import SocketEndpoint
from movingout.server.memory import GarbageCollection
from movingout.server.notices import NOTHING, Notice
from movingout.server.own_maps.folder import MapFolder
from movingout.server.own_maps.workers import MapWorkers
from movingout.server.persistence.answer_log import AnswerLog
from movingout.server.persistence.fsync import sync_recordings
from movingout.server.persistence.recording_service import RecordingService
from movingout.server.persistence.room_snapshot import restore_room, room_file
from movingout.server.persistence.room_store import RoomStore
from movingout.server.rooms.registry import RoomRegistry
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import NOBODY_HERE
from movingout.server.rooms.scheduler import RoomScheduler
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.tokens import hash_token, new_token, token_matches
from movingout.server.settings import Settings
from movingout.world import World
from movingout.world.distance import paper_distances

log = logging.getLogger(__name__)

SYNC_S = 1.0
LEFT_BEHIND_S = 60.0  # a room that was empty for so long may give way to another one of the same address
CPU_SAMPLES = 5  # seconds that the CPU share is averaged over


class Host:
    """The parts of a server. `start` and `stop` run inside the event loop. Raises FolderError for `settings.maps`."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.admin_token = settings.admin_token or new_token()
        self.scheduler = RoomScheduler(time.monotonic, settings.tick_s)
        self.admission = AdmissionControl(settings.limits, time.monotonic)
        self.agents = AgentPool(settings.agent_workers)
        self.answer_log = AnswerLog(settings.answers)
        self.store = RoomStore(settings.rooms)
        self.own_maps = MapFolder(settings.maps)
        self.own_maps.read()
        self.map_workers = MapWorkers()
        self.cpu_share = 0.0  # of one core, over the last seconds
        self.started_at = time.time()
        self.stopping = False
        self.background = BackgroundWork()
        self._garbage = GarbageCollection()
        self._process = psutil.Process()
        self._admin_hash = hash_token(self.admin_token)
        self._preparing: set[asyncio.Task[None]] = set()
        self._recording_service: RecordingService | None = None
        self.registry = RoomRegistry(
            recordings=settings.recordings,
            agents=self.agents,
            scheduler=self.scheduler,
            clock=time.monotonic,
            on_change=self.save,
            on_closed=self._forget_room,
            on_journal=lambda journal: self.recording_service.finalise(journal),
        )
        self.endpoint = SocketEndpoint(settings, self.registry, self.admission)

    @property
    def recording_service(self) -> RecordingService:
        if self._recording_service is None:
            raise RuntimeError("the server has not been started")
        return self._recording_service

    def is_admin(self, token: str) -> bool:
        return token_matches(token, self._admin_hash)

    async def start(self) -> None:
        """Restore the rooms of the last run and start to tick."""
        for folder in (self.settings.recordings, self.settings.rooms, self.settings.answers):
            folder.mkdir(parents=True, exist_ok=True)
        self._recording_service = RecordingService(self.settings.recordings)
        await self.agents.start()
        _warm_up()
        self._restore_rooms()
        self._process.cpu_percent()  # the first call begins the measurement
        self.background.keep_running("the clock of the rooms", self.scheduler.run)
        self.background.repeat("saving recordings to the disk", self._sync, SYNC_S)
        self.background.repeat("watching the load", self._watch_cpu, 1.0)
        self._garbage.start()

    async def suspend(self) -> None:
        """Keep rooms and rounds as they are for the next run, and tell the clients."""
        if self.stopping:
            return
        self.stopping = True
        await self.background.stop()
        for room in self.registry.rooms.values():
            self._keep(room)
            room.suspend()
        deadline = time.monotonic() + 2.0
        while self.endpoint.open and time.monotonic() < deadline:
            await asyncio.sleep(0.02)

    async def stop(self) -> None:
        """Finalise every recording and end the other processes."""
        await self.suspend()
        await self.recording_service.close()
        await self.agents.close()
        await self.map_workers.close()
        await asyncio.to_thread(self.store.close)
        self._garbage.stop()

    def may_open_room(self, address: str) -> bool:
        """Whether somebody at this address may open one more room now; it may take the place of one left behind."""
        limits, now = self.settings.limits, time.monotonic()
        opened = [self.registry.rooms[room] for room in self.admission.rooms_of(address)]
        if sum(not room.was_joined for room in opened) >= limits.unjoined_rooms_per_address:
            return False
        if len(opened) >= limits.open_rooms_per_address:
            left = max(opened, key=lambda room: room.empty_s(now))
            if left.empty_s(now) < LEFT_BEHIND_S:
                return False
            left.close(m.CLOSE_ROOM_OVER, NOBODY_HERE)
            self.registry.remove(left)
        return self.admission.may_open_room(address)

    def _forget_room(self, room_id: str) -> None:
        self.store.delete(room_id)
        self.admission.closed_room(room_id)

    def refusal(self, for_operator: bool = False) -> Notice:
        """Why no room can be opened now, NOTHING when one can. Some rooms are kept for the operator."""
        limits = self.settings.limits
        reserve = 0 if for_operator or not self.settings.lobby else min(limits.rooms_for_operator, limits.rooms // 10)
        most = limits.rooms - reserve
        if self.stopping:
            return Notice("restarting", "The server is being restarted; try again in a minute.")
        if len(self.registry.rooms) >= most:
            text = f"All {most} rooms are in use; close one or try again later."
            return Notice("rooms_in_use", text, {"rooms": most})
        if self.cpu_share > limits.cpu_share:
            percent = round(100 * self.cpu_share)
            text = f"The server is busy ({percent} % of a core), and running games come first; try again later."
            return Notice("busy", text, {"percent": percent})
        return self.full_disk()

    def full_disk(self) -> Notice:
        """Why nothing more can be recorded, NOTHING while there is room."""
        if shutil.disk_usage(self.settings.data).free < 50e6:
            return Notice("disk_full", "The server's disk is almost full; free some space.")
        return NOTHING

    async def prepare_maps(self, config: RoomConfig) -> None:
        """Make the randomised maps of a series in another process: wait for the first, the others follow."""
        if config.challenge2_seed is None:
            return
        seed, rounds = config.challenge2_seed, range(len(config.maps))
        wanted = [(config.designed(index), seed + index, config.split) for index in rounds]
        await self._prepare(wanted[:1])
        background = asyncio.create_task(self._prepare(wanted[1:]))
        self._preparing.add(background)
        background.add_done_callback(self._preparing.discard)

    async def _prepare(self, wanted: list[tuple[MapSpec, int, Split]]) -> None:
        for each in wanted:
            if not self.registry.has_variant(*each):
                self.registry.keep_variant(*each, await self.recording_service.variant(*each))

    # ---- restart --------------------------------------------------------------------------------------------

    def save(self, room: Room) -> None:
        """Keep what a restart needs, until the server stops: what happens then is no change of a room."""
        if not self.stopping:
            self._keep(room)

    def _keep(self, room: Room) -> None:
        """Nobody comes back to a closed room, nor to a finished round of a study."""
        if room.phase == "closed" or (room.config.study and room.phase == "series_over"):
            self.store.delete(room.id)
        else:
            self.store.save(room_file(room, time.time()))

    def _restore_rooms(self) -> None:
        for file in list(self.store.load()):
            try:
                room = restore_room(file, self.settings.recordings, self.registry, time.monotonic())
            except MovingOutError as error:
                log.warning("room %s does not come back: %s", file.id, error)
                self.store.delete(file.id)
                continue
            self.registry.add(room)
        resumed = {room.round.episode_id for room in self.registry.rooms.values() if room.round.started}
        for journal in sorted(self.settings.recordings.glob(f"*{JOURNAL_SUFFIX}")):
            if journal.name.removesuffix(JOURNAL_SUFFIX) not in resumed:
                self.recording_service.recover(journal)

    # ---- in the background ----------------------------------------------------------------------------------

    async def _sync(self) -> None:
        """Make what was recorded survive a power failure; in a thread, because disks are slow."""
        writers = [room.round.writer for room in self.registry.rooms.values() if room.round.writer is not None]
        if writers:
            await asyncio.to_thread(sync_recordings, self.settings.recordings, writers)

    async def _watch_cpu(self) -> None:
        self.cpu_share += (self._process.cpu_percent() / 100.0 - self.cpu_share) / CPU_SAMPLES
        self._garbage.consider(any(room.phase == "playing" for room in self.registry.rooms.values()))


def _warm_up() -> None:
    """Load every map, its distance field and the engine before the first player comes."""
    for name in (*shipped_map_names(), TUTORIAL):
        the_map = load_map(name)
        paper_distances(the_map)
        World(the_map).step([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    agent_cards()
