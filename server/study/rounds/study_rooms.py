"""Rooms for the rounds of a study: opened with a row in the database, and saved when they are over.

No tick can precede the row: nobody gets a key to the room before the database has accepted the round, which requires
that everybody in it has consented.
"""

import contextlib
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager
from typing import Concatenate

from movingout.agents.errors import AgentError
from movingout.maps import MapSpec
from movingout.maps.errors import MovingOutError
from movingout.recordings.episode import Outcome
from movingout.server.notices import Notice
from movingout.server.public_host import Away, Found, Given, NoRoom, PublicHost
from movingout.server.rooms import room_view
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import RESTARTED
from movingout.server.rooms.room_view import PlayedRound, RoomView
from movingout.server.security.tokens import hash_token, new_token
from movingout.server.study.alerts import Alerts
from movingout.server.study.databases import StudyDatabases
from movingout.server.study.participant_session import notify
from movingout.server.study.rounds.finished_rounds import FinishedRounds, OnSaved, close_room
from movingout.server.study.rounds.late_rounds import LateRounds
from movingout.server.study.rounds.room_setup import RoomSetup
from movingout.server.study.rounds.round_outcomes import (
    player_outcomes,
    round_outcome,
)
from movingout.server.study.rounds.round_recovery import RoundRecovery
from movingout.server.study.transaction import Transaction
from movingout.server.study.unit import FinishedRound, RunningRound, StudyUnit
from movingout.server.study.units import Units
from movingout.study.design.steps import Step
from movingout.study.store.rounds import PlayerOutcome
from movingout.study.store.tables import rounds

log = logging.getLogger(__name__)

CANNOT_START = Notice("cannot_start", "This round cannot start.")
PAUSED = Notice("study_paused", "The experimenter has paused the study. Please wait.")


class StudyRooms:
    """All rooms of a study in which a round is played; `finished` has those whose round is over."""

    def __init__(
        self,
        setup: RoomSetup,
        host: PublicHost,
        databases: StudyDatabases,
        alerts: Alerts,
        transaction: Callable[[], AbstractAsyncContextManager[Transaction]],
        on_saved: OnSaved,
        on_recovered: Callable[[Transaction, StudyUnit], Awaitable[None]],
    ) -> None:
        self._setup = setup
        self._host = host
        self._databases = databases
        self._recovery = RoundRecovery(host, databases, alerts)
        self._alerts = alerts
        self.finished = FinishedRounds(host, databases, transaction, on_saved)
        self._late = LateRounds(self._recovery, on_recovered)
        self._units: dict[str, StudyUnit] = {}  # by room
        host.round_watchers.append(self._end)

    # ---- before a round -----------------------------------------------------------------------------------------

    async def prepare(self, step: Step) -> str:
        """Make the randomised map of a round ahead, in another process; why it has none, else "". Raises Busy."""
        return await self._setup.prepare(step)

    def map_of(self, step: Step) -> MapSpec:
        """The map of a round or of the practice, after `prepare`."""
        return self._setup.map_of(step)

    def map_name(self, step: Step) -> str:
        """The map's name in the study file."""
        return self._setup.config(step).maps[0]

    def shown_map(self, name: str) -> tuple[str, str]:
        """Name and title of a map that the study file names, as its rooms show it."""
        return self._setup.shown_map(name)

    async def open(self, tx: Transaction, unit: StudyUnit, step: Step) -> None:
        """Open a room for the unit. If that fails, the reason is in `unit.problem`, and the monitor tries again."""
        tx.check()
        unit.problem, hidden = self._host.cannot_record().message or self._late.problem_of(unit), ""
        if not unit.problem:
            try:
                await self._open(tx, unit, step)
            except AgentError as error:  # which may name the agent in any way, such as by its file
                unit.problem, hidden = self._setup.unloaded(step), str(error)
            except MovingOutError as error:
                unit.problem = str(error)
        if unit.problem:
            text, why = f"Unit {unit.record.id} cannot play yet.", self._setup.blinded(step, unit.problem)
            if self._alerts.add("room", text, why, unit=unit.record.id) and hidden:
                log.warning("unit %d: %s", unit.record.id, hidden)

    async def _open(self, tx: Transaction, unit: StudyUnit, step: Step) -> None:
        members = unit.members_at(step)
        keys = {session.pid: new_token() for session in members}
        room_id = await self._host.open_room(self._setup.config(step, unit), self._setup.seats(unit, step, keys))
        try:
            view = await self._host.ask(room_id, room_view.room_view)
            if step.turn is not None:
                players = [PlayerOutcome(one.pid, unit.seat_of(step, one), one.device) for one in members]
                await tx.run(self._databases.rounds.begin, unit.record, step, view.episode, players)
        except MovingOutError:
            with contextlib.suppress(Away):
                await close_room(self._host, room_id, CANNOT_START)
            raise
        self._enter(unit, view, step, keys)

    def _enter(self, unit: StudyUnit, view: RoomView, step: Step, keys: dict[str, str]) -> None:
        seats = {one.pid: unit.seat_of(step, one) for one in unit.members_at(step)}
        unit.running_round = RunningRound(view, step, keys, seats)
        unit.episode = view.episode if step.turn else unit.episode
        unit.ready -= set(keys)
        self._units[view.id] = unit
        self._alerts.settle("room", unit=unit.record.id)

    # ---- during a round -----------------------------------------------------------------------------------------

    async def ask(
        self,
        tx: Transaction,
        unit: StudyUnit,
        work: Callable[Concatenate[Room, Given], Found],
        *args: Given.args,
        **kwargs: Given.kwargs,
    ) -> Found | None:
        """What `work(room, ...)` returns for the room of a unit, None when it has none (any more). Raises Away."""
        tx.check()
        if unit.running_round is None:
            return None
        try:
            return await self._host.ask(unit.running_round.room, work, *args, **kwargs)
        except NoRoom:
            return None

    async def hold(self, tx: Transaction, unit: StudyUnit, paused: bool) -> None:
        """Stop the clock of a unit's room, or let it go on, unless its process is being replaced."""
        tx.check()
        running = unit.running_round
        if running is None or not self._host.reaches(running.room):
            return
        held = running.view.held
        with contextlib.suppress(Away):
            if paused and not held:
                running.view = await self.ask(tx, unit, room_view.hold, PAUSED) or running.view
            elif held == PAUSED.code and not paused:
                running.view = await self.ask(tx, unit, room_view.release) or running.view

    async def refresh(self, units: Units) -> dict[str, RoomView | None]:
        """Look at the rooms of all units; None for those that are gone."""
        views = await self._host.look([unit.running_round.room for unit in units if unit.running_round])
        for unit in units:
            running = unit.running_round
            view = views.get(running.room) if running else None
            if running is not None and view is not None and _same_round(running, view):
                running.view = view
        return views

    # ---- the end of a round -------------------------------------------------------------------------------------

    async def close(self, tx: Transaction, unit: StudyUnit, notice: Notice, outcome: Outcome = "stopped") -> None:
        """End the round of a unit now. Raises Away."""
        tx.check()
        if unit.running_round is not None:
            room_id = unit.running_round.room
            played = await close_room(self._host, room_id, notice, outcome)
            if played is not None:
                self._end(room_id, played)
            elif unit.running_round is not None:
                await self._lost(tx, unit, unit.running_round)

    def _end(self, room_id: str, played: PlayedRound) -> None:
        """Take the unit out of the room and begin to save the round. Does nothing the second time.

        Told by the room within its last tick, which cannot wait for a transaction.
        """
        unit = self._units.get(room_id)
        running = unit.running_round if unit else None
        if unit is None or running is None or (running.step.turn and played.episode != running.view.episode):
            return
        self.finished.count(played)
        finished = FinishedRound(running.step, played.episode, round_outcome(played), player_outcomes(running, played))
        self._finish(unit, room_id, finished)
        self.finished.save_soon(unit)

    def _finish(self, unit: StudyUnit, room_id: str, finished: FinishedRound) -> None:
        del self._units[room_id]
        self.finished.add(unit, room_id, finished)

    async def _lost(self, tx: Transaction, unit: StudyUnit, running: RunningRound) -> None:
        """The room has ended with its process: what is in its journal counts, as after a restart of the server."""
        finished = await self._recovery.lost(unit, running)
        if finished is not None and unit.running_round is running:  # the room may have told of its end meanwhile
            self.finished.count_recovered(finished.outcome)
            self._finish(unit, running.room, finished)
            await self.finished.save(tx, unit)

    # ---- each second --------------------------------------------------------------------------------------------

    async def look(self, tx: Transaction, units: Units) -> None:
        """Notice rooms that are gone or closed by themselves."""
        tx.check()
        views = await self.refresh(units)
        for unit in units:
            running = unit.running_round
            if running is None or running.room not in views:  # its process is being replaced
                continue
            view = views[running.room]
            if view is not None and not _same_round(running, view):
                await close_room(self._host, running.room, RESTARTED)
                view = None
            if view is None:
                await self._lost(tx, unit, running)
            elif view.phase in ("series_over", "closed"):
                played = await self.ask(tx, unit, room_view.stopped_round)
                if played is not None:
                    self._end(running.room, played)

    async def check(self, tx: Transaction, units: Units, now: float, may_begin: bool) -> None:
        """Repeat what failed before, and close the rooms that everybody has left."""
        tx.check()
        if self._late.episodes:
            await self._find_late(units)
        for outcome in await self._late.save(tx, units, now):
            self.finished.count_recovered(outcome)
        for unit in units:
            if unit.finished_round is not None:
                await self.finished.save(tx, unit)
            elif unit.problem and may_begin and not unit.paused:
                await self._open_again(tx, unit)
        await self.finished.close_left(now)

    async def _open_again(self, tx: Transaction, unit: StudyUnit) -> None:
        unit.problem = ""
        steps = [session.step for session in unit.members if session.pid in unit.ready]
        ready = next((step for step in steps if step is not None and unit.all_ready(step)), None)
        if unit.running_round is None and ready is not None:
            await self.open(tx, unit, ready)

    # ---- after a start of the server ----------------------------------------------------------------------------

    async def resume(self, tx: Transaction, units: Units) -> None:
        """Resume the rounds whose rooms were restored; close the other rooms, and save how their rounds ended."""
        unfinished = await tx.run(self._databases.rounds.open_episodes)
        for view in await self._study_views():
            if not await self._take_back(units, unfinished, view):
                await close_room(self._host, view.id, RESTARTED)
        if not self._host.shares_recordings:
            await self._host.recording_service.settled()
        self.finished.count_stored(await tx.run(self._databases.store.rows, rounds))
        resumed = {unit.episode for unit in units if unit.running_round}
        for episode in [one for one in unfinished if one not in resumed]:
            if self._late.add(episode, unfinished[episode]):
                continue
            outcome = await self._recovery.save(tx, episode, units.get(unfinished[episode]))
            self.finished.count_recovered(outcome)

    async def _study_views(self) -> list[RoomView]:
        found = await self._host.look(await self._host.study_rooms())
        return [view for view in found.values() if view is not None]

    async def _take_back(self, units: Units, unfinished: Mapping[str, int], view: RoomView) -> bool:
        """Whether a round goes on in the room where it was."""
        unit = units.get(unfinished.get(view.episode))
        step = unit.members[0].step if unit else None
        if unit and step and view.started and view.study.get("step") == step.key:
            await self._adopt(unit, view, step)
            return True
        return False

    async def _find_late(self, units: Units) -> None:
        """Rooms that were nowhere when the study was begun here, because another node had not opened them yet."""
        late = self._late.episodes
        for view in [one for one in await self._study_views() if one.episode in late and one.id not in self._units]:
            unit = units.get(late[view.episode])
            with contextlib.suppress(Away, NoRoom):
                if unit is None or unit.running_round or not await self._take_back(units, late, view):
                    await close_room(self._host, view.id, RESTARTED)
                else:
                    unit.problem = ""
                    self._late.goes_on(view.episode)
                    notify(unit.members)

    async def _adopt(self, unit: StudyUnit, view: RoomView, step: Step) -> None:
        keys = {session.pid: new_token() for session in unit.members_at(step)}
        hashes = {unit.seat_of(step, one): hash_token(keys[one.pid]) for one in unit.members_at(step)}
        self._enter(unit, await self._host.ask(view.id, room_view.give_keys, hashes), step, keys)


def _same_round(running: RunningRound, view: RoomView) -> bool:
    """Whether a room still is where the round is played: one that had not begun may have come back as another one."""
    return running.step.turn is None or view.episode == running.view.episode
