"""The state of the experimenter's page as JSON. Partners are letters here too, so that the experimenter stays blind."""

import asyncio
import time
from collections.abc import Iterator, Sequence
from typing import Any

import orjson

from movingout.server.rooms.lateness import Lateness
from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.earnings import minutes_here
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import RunningRound, StudyUnit
from movingout.study.store.rounds import LastRound

State = dict[str, Any]
ROWS_AT_ONCE = 200  # made, or sent, before the games have their turn
GONE_FOR = 120  # versions, of a second or more: a page that has seen none of them is sent everything


class Dashboard:
    """Made at most once a second, however many pages are open, in steps between which the games go on.

    Whoever has finished costs nothing any more, until their last round is marked or their data are deleted, and a page
    is sent the rows that have changed.
    """

    def __init__(self, running: RunningStudy, views: ParticipantViews) -> None:
        self._running = running
        self._views = views
        self._made_at = -1.0
        self._making = asyncio.Lock()
        self._lateness = Lateness()
        self._rows: dict[str, State] = {}
        self._last_rounds: dict[str, LastRound | None] = {}  # that the rows were made with
        self._changed: dict[str, int] = {}  # at which version each row was last another one
        self._gone: dict[str, int] = {}  # at which version each went, of the last GONE_FOR
        self.version = 0

    async def newest(self) -> bytes:
        """The whole state as JSON, at most a second old."""
        await self.refresh()
        return orjson.dumps(self._head([*self._rows.values()]) | {"participants": [*self._rows.values()]})

    async def refresh(self) -> None:
        """Bring the rows up to date, unless that was done in the last second."""
        async with self._making:
            if time.monotonic() - self._made_at < 0.9:
                return
            self.version += 1
            await self._look()
            sessions = list(self._running.participants)
            for first in range(0, len(sessions), ROWS_AT_ONCE):
                self._update(sessions[first : first + ROWS_AT_ONCE], time.monotonic())
                await asyncio.sleep(0)
            for pid in self._rows.keys() - {session.pid for session in sessions}:
                del self._rows[pid], self._last_rounds[pid], self._changed[pid]
                self._gone[pid] = self.version
            self._gone = {pid: at for pid, at in self._gone.items() if at > self.version - GONE_FOR}
            self._made_at = time.monotonic()

    async def _look(self) -> None:
        """Ask the rooms, which may be in other processes."""
        await self._running.rooms.refresh(self._running.units)
        self._lateness = await self._running.host.lateness()

    def _update(self, sessions: Sequence[ParticipantSession], now: float) -> None:
        for session in sessions:
            known, last_round = self._rows.get(session.pid), self._running.units.last_round(session)
            same = self._last_rounds.get(session.pid) == last_round and known and known["kept"] == _kept(session)
            if known is not None and known["outcome"] and session.finished and same:
                continue
            self._last_rounds[session.pid] = last_round
            row = self._row(session, now)
            if row != known:
                self._rows[session.pid], self._changed[session.pid] = row, self.version
                self._gone.pop(session.pid, None)

    def news(self, since: int) -> Iterator[str]:
        """What a page has to know that has seen version `since`, -1 for nothing: documents of few rows each.

        The first one has everything but the rows of the others, which are named `more`.
        """
        partial = since >= 0 and since >= self.version - GONE_FOR
        rows = [self._rows[pid] for pid, version in self._changed.items() if version > since or not partial]
        gone = [pid for pid, version in self._gone.items() if version > since and partial]
        head = self._head([*self._rows.values()])
        head |= {"participants": rows[:ROWS_AT_ONCE], "partial": partial, "gone": gone}
        yield orjson.dumps(head).decode()
        for first in range(ROWS_AT_ONCE, len(rows), ROWS_AT_ONCE):
            yield orjson.dumps({"more": rows[first : first + ROWS_AT_ONCE]}).decode()

    async def state(self) -> State:
        """The whole state, as of now."""
        await self._look()
        rows = [self._row(session, time.monotonic()) for session in self._running.participants]
        return self._head(rows) | {"participants": rows}

    def _head(self, rows: Sequence[State]) -> State:
        running = self._running
        sessions = list(running.participants)
        return {
            "study": {
                "id": running.study.id,
                "title": running.study.title.text(running.study.languages[0]),
                "titles": {language: running.study.title.text(language) for language in running.study.languages},
            },
            "paused": running.progress.paused,
            "counts": {
                "planned": running.study.units,
                "finished": running.participants.complete_units,
                "group": running.study.group,
                "active": sum(not row["outcome"] and row["present"] for row in rows),
                "waiting": running.units.waiting_count,
            },
            "waiting": [session.pid for session in sessions if running.units.waiting_since(session) is not None],
            "rooms": [unit.running_round.room for unit in running.units if unit.running_round],
            "alerts": running.alerts.to_json(),
            "notes": running.notes.to_json(),
            "server": self._server(),
        }

    def _server(self) -> State:
        host, rooms = self._running.host, self._running.rooms
        lateness = self._lateness
        return {
            "late_p99_ms": round(lateness.percentile_ms(0.99), 2),
            "missed": lateness.skipped,
            "ticks": lateness.ticks,
            "disk_free_mb": round(host.disk_free() / 1e6),
            "recordings": rooms.finished.left,
            "partial": rooms.finished.partial,
        }

    def _row(self, session: ParticipantSession, now: float) -> State:
        running, unit, step = self._running, self._running.units.of(session), session.step
        rounds = [one.key for one in session.steps if one.kind == "round"]
        others = unit.others(session) if unit else []
        plays = step is not None and step.kind in ("practice", "round")
        room = unit.running_round.view if unit and unit.running_round else None
        return {
            "pid": session.pid,
            "unit": session.record.unit,
            "partner_letter": self._views.letter(unit, step) if step else None,
            "partner_pid": others[0].pid if others else None,
            "seat": unit.seat_of(step, session) if unit and step and plays else None,
            "step": session.record.step,
            "kind": "code" if session.finished else step.kind if step else "waiting",
            "map": room.map_name if room else "",
            "title": room.map_title if room else "",
            "position": {"done": session.steps_done(), "total": len(session.steps)},
            "round": {"number": rounds.index(step.key) + 1, "of": len(rounds)} if step and step.turn else None,
            "since_s": round(_standing_since(unit, now) - session.step_since),
            "present": _is_here(session, unit, now),
            "outcome": session.record.outcome,
            "kept": _kept(session),
            "device_bound": running.device_bound(session),
            "code_given": session.record.code is not None,
            "code": session.record.code,
            "minutes": minutes_here(session.record),
            "episode": unit.episode if unit else "",
            "last_round": self._last_round(session, rounds),
            "paused": running.progress.is_paused(session),
            "unit_paused": unit is not None and unit.paused,
            "paused_s": round(now - unit.standing_since) if unit and unit.standing_since is not None else None,
            **_round_state(session, unit),
        }

    def _last_round(self, session: ParticipantSession, rounds: Sequence[str]) -> State | None:
        """The newest round that has ended, which is the one that can be marked, with its number among these steps."""
        last = self._running.units.last_round(session)
        if last is None or last.step not in rounds:
            return None
        name, title = self._running.rooms.shown_map(last.map)
        number = rounds.index(last.step) + 1
        return {"episode": last.episode, "number": number, "map": name, "title": title, "valid": last.valid}


def _kept(session: ParticipantSession) -> bool:
    """Whether their data stay; not of those who asked for the deletion."""
    return session.record.keep is not False


def _standing_since(unit: StudyUnit | None, now: float) -> float:
    """Until when time at a step counts: it stands still in a pause."""
    return now if unit is None or unit.standing_since is None else unit.standing_since


def _round_of(session: ParticipantSession, unit: StudyUnit | None) -> RunningRound | None:
    """The round that a participant is playing."""
    return unit.running_round if unit and unit.running_round and session.pid in unit.running_round.seats else None


def _is_here(session: ParticipantSession, unit: StudyUnit | None, now: float) -> bool:
    """Whether their page is open; once their round has begun, whether it is connected to the room."""
    running_round = _round_of(session, unit)
    if running_round is None:
        return session.present(now)
    connected = running_round.view.seats[running_round.seats[session.pid]].present
    return connected or (not running_round.view.started and session.present(now))


def _round_state(session: ParticipantSession, unit: StudyUnit | None) -> State:
    """The fields that are empty outside a room."""
    running_round = _round_of(session, unit)
    if running_round is None:
        return {"room": None, "phase": "", "tick": None, "limit_ticks": None, "late_ms": None, "missed": None,
                "recording": "", "rtt_ms": session.rtt_ms, "waits_for": []}  # fmt: skip
    room = running_round.view
    seat = room.seats[running_round.seats[session.pid]]
    recording = "recording" if room.recording else "" if room.practice else room.recording_problem or "not recording"
    return {
        "room": room.id,
        "phase": room.phase,
        "tick": room.tick,
        "limit_ticks": room.limit_ticks or None,
        "late_ms": None if room.late_ms is None else round(room.late_ms, 2),
        "missed": room.missed,
        "recording": recording if room.started else "",
        "rtt_ms": seat.rtt_ms if seat.present else session.rtt_ms,
        "waits_for": [pid for pid, index in running_round.seats.items() if not room.seats[index].present],
    }
