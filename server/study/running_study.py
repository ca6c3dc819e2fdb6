"""A study that is being run: who is where, and who plays with whom.

Everything is in the store before anybody is told so; what is here can be made again from the store after a crash.
One lock lets one thing happen at a time, so that the two of a pair cannot overtake each other.
"""

import asyncio
import logging
import secrets
import time
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from movingout.server.host import Host
from movingout.server.study.alerts import Alerts
from movingout.server.study.database_thread import Records
from movingout.server.study.participant_session import Guest
from movingout.server.study.study_rooms import Playing
from movingout.server.study.unit import Crew, Over
from movingout.server.study.waiting_room import WaitingRoom
from movingout.study.data.erasure import remove_recordings
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import assign
from movingout.study.design.definition import Outcome
from movingout.study.design.review import earned
from movingout.study.design.step_order import LAST_ALONE, WAITING, blocks_over, following
from movingout.study.design.steps import steps
from movingout.study.errors import StudyError
from movingout.study.store import Unit
from movingout.study.store.removal import clear, episodes_of, has_deeds
from movingout.study.store.store import Participant
from movingout.study.store.tables import notes

log = logging.getLogger(__name__)

CODE_LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
CODE_LENGTH = 10
PAUSED = "The experimenter has paused the study. Please wait."

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class RunningStudy:
    """One study in one server. `start` and `stop` run inside the event loop, after and before the host's."""

    def __init__(
        self, folder: StudyFolder, file_text: str, host: Host, needs_code: bool = False, simulated: bool = False
    ) -> None:
        self.folder = folder
        self.study = folder.study
        self.host = host
        self.needs_code = needs_code
        self.simulated = simulated
        self.alerts = Alerts()
        self.records = Records(folder, file_text, self.alerts, simulated)
        self.lock = asyncio.Lock()
        self.waiting = WaitingRoom(self.study.pairing.wait_s)
        self.guests: dict[str, Guest] = {}
        self.crews: dict[int, Crew] = {}
        self.notes: list[dict[str, Any]] = []  # the newest first
        self.paused = False
        names = {"study": self.study.id, **({"simulated": "yes"} if simulated else {})}
        self.playing = Playing(self.study, names, host, self.records, self.alerts, self.lock, self._played)
        self._alone = steps(self.study, assign(self.study, 0))
        self._removals: set[asyncio.Task[None]] = set()

    # ---- from start to stop -----------------------------------------------------------------------------------

    async def start(self) -> None:
        """Bring everybody back to where they were."""
        store = self.records.store
        known = await self.run(self.records.identities.everybody)
        for one in await self.run(store.everybody):
            self.add(one, known.get(one.pid, ("", ""))[0])
        self.paused = await self.run(store.paused)
        self.notes = [self._note(row) for row in reversed(await self.run(store.rows, notes))]
        newest = await self.run(self.records.rounds.newest_episodes)
        for unit in await self.run(store.units_on_their_way):
            self._add_crew(unit, [self.guests[pid] for pid in unit.pids], newest.get(unit.id, ""))
        await self.playing.take_up(self.crews)
        self._hold_rooms()
        async with self.lock:
            for crew in list(self.crews.values()):
                await self._catch_up(crew)
                await self.bring_in(crew)
        for guest in self.guests.values():
            if guest.place.keep is False and guest.finished:
                self.remove_data(guest)

    def _note(self, row: dict[str, Any]) -> dict[str, Any]:
        pids = [pid for pid, guest in self.guests.items() if row["unit"] and guest.place.unit == row["unit"]]
        return {"at": row["at_ms"] / 1e3, "text": row["text"], "pid": " and ".join(pids) or None}

    async def stop(self) -> None:
        await self.playing.finish()
        await asyncio.gather(*self._removals, return_exceptions=True)
        self.records.close()

    def now(self) -> float:
        """Seconds of a clock that never jumps."""
        return time.monotonic()

    async def run(self, work: Callable[Arguments, Result], *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        """Ask the databases."""
        return await self.records.run(work, *args, **kwargs)

    def add(self, place: Participant, source: str) -> Guest:
        """Somebody takes part from now on."""
        guest = Guest(place, self._alone, heard_at=self.now(), since=self.now(), source=source)
        self.guests[place.pid] = guest
        return guest

    def crew_of(self, guest: Guest) -> Crew | None:
        return None if guest.place.unit is None else self.crews.get(guest.place.unit)

    def stays(self, guest: Guest) -> bool:
        """Whether the experimenter has paused this participant."""
        crew = self.crew_of(guest)
        return self.paused or (crew is not None and crew.paused)

    def worth(self, guest: Guest) -> dict[str, Any] | None:
        """What the time of somebody who has finished is paid; None where nothing is."""
        pay, place = self.study.pay, guest.place
        if pay is None or place.finished_ms is None:
            return None
        minutes = max(0, place.finished_ms - place.arrived_ms) / 60_000
        return {"minutes": round(minutes, 1), "amount": earned(self.study, minutes), "currency": pay.currency}

    def push(self, *guests: Guest) -> None:
        """Tell open pages to look again."""
        for guest in guests:
            for push in list(guest.pushes):
                push({"changed": True})

    # ---- pausing (the lock is held) ---------------------------------------------------------------------------

    async def pause(self, paused: bool, crew: Crew | None = None) -> None:
        """Stop the clock of a crew or of everybody, or let it go on; a restart of the server changes nothing."""
        await self.run(self.records.store.pause, paused, None if crew is None else crew.unit.id)
        if crew is None:
            self.paused = paused
        else:
            crew.paused = paused
        self._hold_rooms()
        if not paused:
            self._begin_waits_anew(crew)
        self.push(*self.guests.values())

    def _begin_waits_anew(self, crew: Crew | None) -> None:
        """A pause does not count: nobody who went away meanwhile is gone, nobody has waited too long."""
        for guest in self.guests.values() if crew is None else crew.guests:
            guest.heard_at = self.now()
        self.waiting.begin_anew(self.now())

    def _hold_rooms(self) -> None:
        for crew in self.crews.values():
            room, still = crew.game and crew.game.room, self.paused or crew.paused
            if room and still and not room.held:
                room.hold(PAUSED, self.now())
            elif room and room.held and not still:
                room.release(self.now())

    # ---- from step to step (the lock is held) -----------------------------------------------------------------

    async def advance(self, guest: Guest) -> None:
        """On to the step that follows."""
        rounds, unit = self.records.rounds, guest.place.unit
        over, played = frozenset[str](), frozenset[str]()
        if unit is not None and any(block.limit_minutes for block in self.study.blocks):
            over = blocks_over(self.study, await self.run(rounds.block_seconds, unit))
            played = await self.run(rounds.finished_steps, unit)
        step = following(guest.way, guest.place.step, over, played)
        if step.kind == "code":
            await self._finish(guest, "done")
        else:
            await self.move(guest, step.key)

    async def move(self, guest: Guest, key: str) -> None:
        await self.run(self.records.store.move, guest.pid, key)
        await self.refresh(guest)

    async def refresh(self, guest: Guest) -> None:
        """Read again what the store says of them."""
        before = guest.place.step
        guest.place = await self.run(self.records.store.participant, guest.pid)
        if guest.place.step != before:
            guest.since = self.now()

    async def _played(self, crew: Crew, over: Over) -> None:
        """A round or the practice has ended; one that was broken off is begun again."""
        for guest in crew.at(over.step) if over.counts else []:
            await self.advance(guest)
        self.push(*crew.guests)

    async def _catch_up(self, crew: Crew) -> None:
        """After a crash: a round that was finished and not yet counted as such is."""
        finished = await self.run(self.records.rounds.finished_steps, crew.unit.id)
        for guest in crew.guests:
            while not guest.finished and guest.place.step in finished:
                await self.advance(guest)

    # ---- pairs (the lock is held) -----------------------------------------------------------------------------

    async def form(self, guests: list[Guest]) -> None:
        """Give one or two a slot, and let them begin what depends on it."""
        unit = await self.run(self.records.store.form_unit, [guest.pid for guest in guests])
        self._add_crew(unit, guests)
        for guest in guests:
            await self.refresh(guest)
        await self.bring_in(self.crews[unit.id])
        if unit.slot >= self.study.units:
            self.alerts.raise_("full", f"There are more participants than planned: slot {unit.slot + 1} was given.")
        self.push(*guests)

    def _add_crew(self, unit: Unit, guests: list[Guest], episode: str = "") -> None:
        self.crews[unit.id] = Crew(unit, guests, paused=unit.paused, episode=episode)
        for guest in guests:
            guest.way = steps(self.study, assign(self.study, unit.slot))

    async def bring_in(self, crew: Crew) -> None:
        """Nobody of a unit is left before its first step, also when a kill or the database came between."""
        for guest in crew.guests:
            if guest.on_the_way:
                await self.move(guest, following(guest.way, LAST_ALONE).key)

    async def match(self) -> None:
        """Pair those who wait, and let nobody wait for ever."""
        now = self.now()
        for guest in self.guests.values():
            if guest.place.step == WAITING and guest.place.unit is None and not guest.finished:
                self.waiting.enter(guest.pid, guest.since, guest.place.screen)
            if guest.pushes and guest.present(now):
                self.waiting.heard(guest.pid, now)
        while (pair := self.waiting.pair(now)) is not None:
            await self.form([self.guests[pid] for pid in pair])
        for pid in self.waiting.over(now):
            guest = self.guests[pid]
            if self.study.pairing.otherwise == "agent" and guest.present(now):
                await self.form([guest])
            else:
                await self._finish(guest, "no-partner")
                self.push(guest)
            self.waiting.leave(pid)

    # ---- going (the lock is held) -----------------------------------------------------------------------------

    async def dismiss(self, guest: Guest, outcome: Outcome, keep: bool = True) -> None:
        """Somebody leaves before the end; a partner is free to go, and paid."""
        if guest.finished:
            return
        if not keep:
            await self.run(self.records.store.keep_data, guest.pid, False)
        await self._finish(guest, outcome)
        self.waiting.leave(guest.pid)
        self.push(guest)
        crew = self.crew_of(guest)
        if crew is not None:
            await self.part(crew)
        if not keep:
            self.remove_data(guest)

    async def part(self, crew: Crew) -> None:
        """Somebody of them has left: nobody else is kept waiting for rounds that cannot be."""
        self.playing.close(crew, "The round was ended, because somebody left the study.", "left")
        for other in crew.guests:
            if not other.finished and other.plays_on():
                await self._finish(other, "partner-left")
                self.push(other)

    async def _finish(self, guest: Guest, outcome: Outcome) -> None:
        """Give the one and only code."""
        await self.run(self.records.store.finish, guest.pid, outcome, self._code(outcome))
        await self.refresh(guest)

    def _code(self, outcome: Outcome) -> str:
        fixed = {} if self.study.codes == "unique" else self.study.codes
        return fixed.get(outcome) or "".join(secrets.choice(CODE_LETTERS) for _ in range(CODE_LENGTH))

    def remove_data(self, guest: Guest) -> None:
        """Delete what they did, soon; a server that is killed before does it when it starts again."""
        task = asyncio.create_task(self._withdraw(guest))
        self._removals.add(task)
        task.add_done_callback(self._removals.discard)

    async def _withdraw(self, guest: Guest) -> None:
        """Delete answers and recordings once the last recording is on the disk. The code stays, to be paid."""
        await self.playing.finish()
        await self.host.archive.settled()
        store = self.records.store
        try:
            if await self.run(has_deeds, store, guest.pid):
                episodes = await self.run(episodes_of, store, guest.pid)
                removed = await asyncio.to_thread(remove_recordings, self.folder.recordings, guest.pid, set(episodes))
                await self.run(clear, store, guest.pid, removed)
        except StudyError as error:
            self.alerts.raise_("deletion", f"The data of {guest.pid} could not be deleted: {error}")
