"""The rooms of this process: opens, finds, ticks and closes them, and provides their `Services`."""

import logging
import time
from collections.abc import Awaitable, Callable, Collection
from pathlib import Path

from movingout.agents.recording_metadata import cards
from movingout.maps import MapSpec
from movingout.maps.randomize import Split
from movingout.recordings import EpisodeHeader, EpisodeWriter
from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.rooms.prepared_maps import PreparedMaps
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView, room_view, stopped_round
from movingout.server.rooms.scheduler import RoomScheduler, ScheduledRoom
from movingout.server.rooms.seat import AgentSource, Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.tokens import new_id, new_token
from movingout.world.state import WorldState

log = logging.getLogger(__name__)

ROOM_FAILED = Notice("room_failed", "Something went wrong in this room; the recording is kept.")
RoundWatcher = Callable[[str, str, m.Result], None]  # room, episode


class RoomRegistry:
    """The rooms by id. `on_change(room)` reports what a restart needs, `on_journal` a journal to finalise.

    A room that this process does not own for the moment, as `owns` says, does not tick. `make_map` makes a randomised
    map that a later round misses.
    """

    def __init__(
        self,
        recordings: Path,
        agents: AgentSource,
        scheduler: RoomScheduler,
        clock: Callable[[], float],
        on_change: Callable[[Room], None],
        on_closed: Callable[[str], None],
        on_journal: Callable[[Path], None],
        new_room_id: Callable[[], str] = new_id,
        owns: Callable[[str], bool] = lambda room_id: True,
        make_map: Callable[[MapSpec, int, Split], Awaitable[MapSpec]] | None = None,
    ) -> None:
        self.rooms: dict[str, Room] = {}
        self.prepared_maps = PreparedMaps(make_map)
        self.unrecorded = 0  # rounds that should have been recorded, and were not to their end
        self._recordings = recordings
        self._agents = agents
        self._scheduler = scheduler
        self._clock = clock
        self._entries: dict[str, ScheduledRoom] = {}
        self._on_change = on_change
        self._on_closed = on_closed
        self._on_journal = on_journal
        self._new_room_id = new_room_id
        self._owns = owns
        self._round_watchers: list[RoundWatcher] = []

    def open(self, config: RoomConfig, seats: list[Seat]) -> Room:
        """A new room that ticks from now on. Raises MapError and AgentError."""
        room = Room(room_id=self._new_room_id(), config=config, seats=seats, services=self, now=self._clock())
        self.add(room)
        return room

    def add(self, room: Room) -> None:
        self.rooms[room.id] = room
        self._entries[room.id] = self._scheduler.add(
            lambda now, due, skipped: self._tick(room, now, due, skipped), room.beat
        )
        self.changed(room.id)

    def watch_rounds(self, watcher: RoundWatcher) -> None:
        """Call `watcher(room_id, episode_id, result)` when a round is over, within its last tick."""
        self._round_watchers.append(watcher)

    def remove(self, room: Room) -> None:
        """Forget a closed room."""
        if self.let_go(room):
            self._on_closed(room.id)

    def let_go(self, room: Room) -> bool:
        """Tick a room no more, without a word to anybody: it lives on elsewhere. False when it is not here."""
        if self.rooms.pop(room.id, None) is None:
            return False
        self._scheduler.remove(self._entries.pop(room.id))
        return True

    def deadline_misses(self) -> int:
        """Agent decisions that came too late, in the rounds being played."""
        return sum(room.round.deadline_misses for room in self.rooms.values())

    def _tick(self, room: Room, now: float, due: float, skipped: int) -> None:
        if not self._owns(room.id):
            return
        try:
            room.tick(now, due, skipped)
        except Exception:  # a fault in one room must not stop the others
            log.exception("room %s failed and is closed", room.id)
            room.close(m.CLOSE_ROOM_OVER, ROOM_FAILED, "error")
        if room.phase == "closed":
            self.remove(room)

    # ---- Services -------------------------------------------------------------------------------------------

    @property
    def agents(self) -> AgentSource:
        return self._agents

    def world_map(self, designed: MapSpec, seed: int | None, split: Split) -> MapSpec:
        return self.prepared_maps.world_map(designed, seed, split)

    def map_is_ready(self, designed: MapSpec, seed: int | None, split: Split) -> bool:
        return self.prepared_maps.is_ready(designed, seed, split)

    def open_recording(self, header: EpisodeHeader, initial: WorldState) -> EpisodeWriter:
        return EpisodeWriter.create(self._recordings, header, initial, cards(header.seats))

    def archive(self, journal: Path) -> None:
        self._on_journal(journal)

    def ended(self, room_id: str, episode_id: str, result: m.Result) -> None:
        room = self.rooms.get(room_id)
        self.unrecorded += room is not None and bool(room.round.recorder.problem)
        for watcher in self._round_watchers:
            watcher(room_id, episode_id, result)

    def new_id(self) -> str:
        return new_id(20)

    def new_episode_id(self, room_id: str) -> str:
        return room_id[:1] + new_id(19)

    def new_token(self) -> str:
        return new_token()

    def wall_ns(self) -> int:
        return time.time_ns()

    def changed(self, room_id: str) -> None:
        room = self.rooms.get(room_id)
        if room is not None:
            self._on_change(room)


def close(registry: RoomRegistry, room: Room, code: int, notice: Notice, outcome: Outcome = "stopped") -> PlayedRound:
    """Close a room and forget it; how its round went."""
    room.close(code, notice, outcome)
    played = stopped_round(room, outcome)
    registry.remove(room)
    return played


def views(registry: RoomRegistry, wanted: Collection[str]) -> dict[str, RoomView | None]:
    """These rooms as they are, None for those that are gone."""
    found = {room_id: registry.rooms.get(room_id) for room_id in wanted}
    return {room_id: None if room is None else room_view(room) for room_id, room in found.items()}


def study_rooms(registry: RoomRegistry) -> list[str]:
    return [room.id for room in registry.rooms.values() if room.config.study]
