"""A server in one process: pages, API and rooms, started and stopped in order."""

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, Concatenate

from movingout.recordings.episode import Outcome
from movingout.server.agent_workers.agent_use import AgentUse, agent_use
from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.monitoring.status import room_report, server_report
from movingout.server.notices import Notice
from movingout.server.public_host import Found, Given, PublicHost
from movingout.server.room_host import RoomHost, warm_up
from movingout.server.rooms.lateness import Lateness
from movingout.server.rooms.prepared_maps import PreparedMaps
from movingout.server.rooms.registry import close, study_rooms, views
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.settings import Settings


class Host(PublicHost, RoomHost):
    """The parts of a server. `start` and `stop` run inside the event loop. Raises FolderError for `settings.maps`."""

    def __init__(self, settings: Settings) -> None:
        PublicHost.__init__(self, settings)
        RoomHost.__init__(self, settings)

    async def start(self) -> None:
        """Restore the rooms of the last run and start to tick."""
        self._start_public()
        await self.agents.start()
        warm_up()
        for file in list(self.store.load()):
            await self.restore(file)
        self._recover_journals({*self.episodes()})
        await self.start_rooms()

    async def suspend(self) -> None:
        await RoomHost.suspend(self)

    async def stop(self) -> None:
        """Finalise every recording and end the other processes."""
        await self.suspend()
        await self._stop_public()
        await self.stop_rooms()

    def finish_journal(self, journal: Path) -> None:
        self.recording_service.finalise(journal)

    def recorded(self, room_id: str, size: int) -> None:
        self.admission.recorded(room_id, size)

    def health(self) -> ProcessHealth:
        return self.process_health()

    def came_back(self, room: Room) -> None:
        super().came_back(room)
        self.admission.opened_room(room.config.owner, room.id)

    def room_closed(self, room_id: str) -> None:
        super().room_closed(room_id)
        self.admission.closed_room(room_id)

    # ---- rooms ----------------------------------------------------------------------------------------------

    @property
    def room_count(self) -> int:
        return len(self.registry.rooms)

    @property
    def prepared_maps(self) -> PreparedMaps:
        return self.registry.prepared_maps

    async def open_room(self, config: RoomConfig, seats: list[Seat]) -> str:
        return (await self.open_kept(config, seats)).id

    async def ask(
        self,
        room_id: str,
        work: Callable[Concatenate[Room, Given], Found],
        *args: Given.args,
        **kwargs: Given.kwargs,
    ) -> Found:
        return work(self.room(room_id), *args, **kwargs)

    async def close_room(self, room_id: str, code: int, notice: Notice, outcome: Outcome = "stopped") -> PlayedRound:
        return close(self.registry, self.room(room_id), code, notice, outcome)

    async def look(self, rooms: Collection[str]) -> dict[str, RoomView | None]:
        return views(self.registry, rooms)

    async def study_rooms(self) -> list[str]:
        return study_rooms(self.registry)

    async def lateness(self) -> Lateness:
        return self.scheduler.lateness

    def round_over(self, room_id: str, played: PlayedRound) -> None:
        PublicHost.round_over(self, room_id, played)

    async def rounds_left(self) -> int:
        return self.hold_rounds()

    async def room_reports(self) -> list[dict[str, Any]]:
        return [room_report(self)]

    async def report(self) -> dict[str, Any]:
        return server_report(self, await self.room_reports())

    async def agent_use(self, wanted: Collection[str], taken: Collection[str]) -> AgentUse:
        return agent_use(self.agents, wanted, taken)

    async def reset_measurements(self) -> None:
        self.scheduler.lateness.clear()
