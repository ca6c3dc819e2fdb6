"""A server whose rooms live in other processes: pages, API, recordings and replays are here, no tick is."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import Any, Concatenate

from movingout.agents.errors import AgentsBusyError
from movingout.maps import MapSpec
from movingout.recordings.episode import Outcome
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.agent_workers.agent_use import AgentUse
from movingout.server.agent_workers.capacity import COSTS
from movingout.server.background import BackgroundWork
from movingout.server.connection.admission import AdmissionControl
from movingout.server.garbage_collection import GarbageCollection
from movingout.server.monitoring.overload import ProcessHealth
from movingout.server.monitoring.status import process_report, server_report
from movingout.server.notices import Notice
from movingout.server.processes import agent_service, room_process
from movingout.server.processes.agent_link import AgentLink
from movingout.server.processes.agent_service import StartAgents
from movingout.server.processes.channel import ProcessGone
from movingout.server.processes.expected_connections import ExpectedConnections
from movingout.server.processes.handover import AGENTS
from movingout.server.processes.homes import home_of
from movingout.server.processes.room_link import RoomLink
from movingout.server.processes.room_process import Start
from movingout.server.processes.template import TemplateProcess
from movingout.server.public_host import ROOMS_AT_ONCE, Found, Given, PublicHost
from movingout.server.room_host import warm_up
from movingout.server.rooms.lateness import Lateness
from movingout.server.rooms.prepared_maps import PreparedMaps, Variant
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import RoomConfig
from movingout.server.security.certificate import Certificate
from movingout.server.settings import Settings

log = logging.getLogger(__name__)

START_S = 90.0
TRIES = 2  # of a call whose process ends meanwhile


class Front(PublicHost):
    """`keep` is the descriptor of the data folder's lock, which lasts as long as any process of this server."""

    def __init__(self, settings: Settings, processes: int, keep: int, certificate: Certificate | None = None) -> None:
        super().__init__(settings)
        together = replace(settings.limits, sockets=settings.limits.sockets * processes)
        self.admission = AdmissionControl(
            together, time.monotonic, lambda: [link.sockets for link in self.links], settings.admin_token
        )
        self.background = BackgroundWork()
        self.stopping = False
        self._garbage = GarbageCollection()
        self._template = TemplateProcess(keep)
        self._prepared_maps = PreparedMaps()  # every process has them, too
        start = Start(
            settings=replace(settings, admin_token="-"),
            certificate=certificate,
            index=0,
            processes=processes,
        )
        self.links = [RoomLink(index, replace(start, index=index), self._template, self) for index in range(processes)]
        agents = StartAgents(
            settings.agent_workers, settings.data / COSTS, settings.log_format, settings.agent_thread_cores
        )
        self.agents = AgentLink(agents, self._connect_agents)
        self.expected = ExpectedConnections()
        self._recovering: asyncio.Task[None] | None = None

    async def start(self) -> None:
        """Restore the rooms of the last run, each in its process, and start to tick."""
        self._start_public()
        self._template.start()
        self.agents.begin()
        for link in self.links:
            link.begin()
        warm_up()
        await asyncio.gather(*(link.ready(START_S) for link in self.links))
        await self._recover_left()
        self._garbage.start()
        self.background.repeat("collecting garbage", self._collect, 10.0)

    async def suspend(self) -> None:
        """Have rooms and rounds kept as they are for the next run."""
        if self.stopping:
            return
        self.stopping = True
        await self.background.stop()
        if self._recovering is not None:
            self._recovering.cancel()
        await asyncio.gather(*(link.stop() for link in self.links))
        await self.agents.stop()

    async def stop(self) -> None:
        await self.suspend()
        await self._stop_public()
        self._template.close()
        self._garbage.stop()

    def link_of(self, room_id: str) -> RoomLink:
        return self.links[home_of(room_id, len(self.links))]

    # ---- rooms ----------------------------------------------------------------------------------------------

    @property
    def room_count(self) -> int:
        return sum(len(link.rooms) for link in self.links)

    @property
    def most_rooms(self) -> int:
        return self.settings.limits.rooms * len(self.links)

    def health(self) -> ProcessHealth:
        """A new room goes to the process that is least busy; a fault is one wherever it is."""
        ready = [link.health for link in self.links if link.is_ready]
        return ProcessHealth(
            cpu_share=min((each.cpu_share for each in ready), default=0.0),
            busy=bool(ready) and all(each.busy for each in ready),
            agents=any(each.agents for each in ready),
            faults=(
                *(fault for link in self.links for fault in link.faults()),
                *self.agents.faults(),
                *self.background.faults(),
            ),
            unwritable=min((each.unwritable for each in ready), default=""),  # empty where one process can write
        )

    async def open_room(self, config: RoomConfig, seats: list[Seat]) -> str:
        """In the process with the fewest rooms; where its agents are all busy, in the next. Raises as PublicHost.

        Rounds of a study begin in no process that cannot record them.
        """
        busy: AgentsBusyError | ProcessGone | None = None
        able = [link for link in self.links if not (config.study and link.health.unwritable)]
        for link in sorted(able, key=lambda each: (not each.is_ready, each.health.busy, len(each.rooms))):
            try:
                room_id: str = await link.call(room_process.open_room, config, seats)
            except (AgentsBusyError, ProcessGone) as error:
                busy = busy or error
                continue
            link.rooms.add(room_id)
            return room_id
        raise busy or ProcessGone("no process can take a room at the moment; try again")

    async def ask(
        self,
        room_id: str,
        work: Callable[Concatenate[Room, Given], Found],
        *args: Given.args,
        **kwargs: Given.kwargs,
    ) -> Found:
        found: Found = await self._call(room_id, room_process.ask, room_id, work, *args, **kwargs)
        return found

    async def close_room(self, room_id: str, code: int, notice: Notice, outcome: Outcome = "stopped") -> PlayedRound:
        played: PlayedRound = await self._call(room_id, room_process.close_room, room_id, code, notice, outcome)
        return played

    async def look(self, rooms: Collection[str]) -> dict[str, RoomView | None]:
        """Some rooms at a time, so that no tick waits for the others."""
        found: dict[str, RoomView | None] = {}
        for link in [link for link in self.links if link.is_ready]:
            here = [room_id for room_id in rooms if self.link_of(room_id) is link]
            with contextlib.suppress(ProcessGone):
                for first in range(0, len(here), ROOMS_AT_ONCE):
                    found |= await link.call(room_process.look, here[first : first + ROOMS_AT_ONCE])
        return found

    def reaches(self, room_id: str) -> bool:
        return self.link_of(room_id).is_ready

    async def study_rooms(self) -> list[str]:
        found = await asyncio.gather(*(link.call(room_process.study_rooms) for link in self.links))
        return [room_id for each in found for room_id in each]

    @property
    def prepared_maps(self) -> PreparedMaps:
        return self._prepared_maps

    async def lateness(self) -> Lateness:
        whole, ready = Lateness(), [link for link in self.links if link.is_ready]
        for each in await asyncio.gather(*(link.call(room_process.lateness) for link in ready), return_exceptions=True):
            if not isinstance(each, BaseException):
                whole.include(each)
        return whole

    async def rounds_left(self) -> int:
        found = await asyncio.gather(
            *(link.call(room_process.hold_rounds) for link in self.links), return_exceptions=True
        )
        return sum(each if isinstance(each, int) else 1 for each in found)  # a process being replaced has some, perhaps

    async def room_reports(self) -> list[dict[str, Any]]:
        there = [link for link in self.links if link.is_ready]
        reports = await asyncio.gather(*(link.call(room_process.report) for link in there), return_exceptions=True)
        found = zip(there, reports, strict=True)
        return [each | {"process": link.index} for link, each in found if isinstance(each, dict)]

    async def other_reports(self) -> dict[str, dict[str, Any]]:
        agents = await self.agents.report()
        return {"front": process_report()} | ({} if agents is None else {"agents": agents})

    async def report(self) -> dict[str, Any]:
        whole = server_report(self, await self.room_reports())
        whole["agents"] = (await self.agents.report() or {"agents": []})["agents"]
        whole["processes"] = [
            {
                "pid": link.pid,
                "rooms": len(link.rooms),
                "cpu_percent": round(100 * link.health.cpu_share, 1),
                "restarts": link.restarts,
                "ready": link.is_ready,
            }
            for link in self.links
        ]
        return whole

    async def agent_use(self, wanted: Collection[str], taken: Collection[str]) -> AgentUse:
        found: AgentUse = await self.agents.call(agent_service.use, wanted, taken)
        return found

    async def reset_measurements(self) -> None:
        await asyncio.gather(*(link.call(room_process.reset_measurements) for link in self.links))

    def keep_map(self, variant: Variant, made: MapSpec) -> None:
        """Every process gets it: the room may be opened in any of them."""
        super().keep_map(variant, made)
        for link in self.links:
            link.tell(room_process.keep_map, variant, made)

    async def _call(self, room_id: str, work: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """Once more when the process ends meanwhile: its rooms come back."""
        link = self.link_of(room_id)
        for left in reversed(range(TRIES)):
            try:
                return await link.call(work, *args, **kwargs)
            except ProcessGone:
                if left == 0:
                    raise

    def started(self, link: RoomLink) -> None:
        for variant, made in self.prepared_maps:
            link.tell(room_process.keep_map, variant, made)
        connection = self.agents.connection()
        if connection is not None:
            with connection, contextlib.suppress(ProcessGone):
                link.give(connection.fileno(), AGENTS)

    def _connect_agents(self) -> None:
        """There is a new agent service."""
        for link in self.links:
            if link.has_started:
                self.started(link)

    # ---- what the processes tell ----------------------------------------------------------------------------

    def arrived(self, address: str, link: RoomLink) -> None:
        self.expected.arrived(address, link)

    def flooded(self, address: str) -> None:
        self.admission.strike(address)

    def room_came_back(self, room_id: str, owner: str) -> None:
        self.admission.opened_room(owner, room_id)

    def room_closed(self, room_id: str) -> None:
        self.admission.closed_room(room_id)

    def recorded(self, room_id: str, size: int) -> None:
        self.admission.recorded(room_id, size)

    def finish_journal(self, journal: Path) -> None:
        self.recording_service.finalise(journal)

    def replaced(self) -> None:
        if not self.stopping:
            self._recovering = asyncio.create_task(self._recover_left())

    async def _recover_left(self) -> None:
        """Finish the journals of rounds that no room goes on with, here or with another study.

        The journals are listed first: a round that begins meanwhile is not among them, and one that ends meanwhile
        is known by the time its process answers.
        """
        journals = sorted(self.settings.recordings.glob(f"*{JOURNAL_SUFFIX}"))
        try:
            found = await asyncio.gather(*(link.call(room_process.episodes) for link in self.links))
        except ProcessGone:
            return  # whoever takes its place comes back here
        running = {episode for each in found for episode in each} | self._left_to_others()
        for journal in journals:
            left = journal.name.removesuffix(JOURNAL_SUFFIX) not in running and journal.exists()
            if left and not self.recording_service.knows(journal):
                self.recording_service.recover(journal)

    async def _collect(self) -> None:
        self._garbage.consider(busy=False)
