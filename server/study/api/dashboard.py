"""The state of the experimenter's page as JSON. Partners are letters here too, so that the experimenter stays blind."""

import shutil
import time
from typing import Any

import orjson

from movingout.server.study.api.participant_view import ParticipantViews
from movingout.server.study.earnings import minutes_here
from movingout.server.study.participant_session import ParticipantSession
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import RunningRound, StudyUnit

State = dict[str, Any]


class Dashboard:
    """Made at most once a second, however many pages are open."""

    def __init__(self, running: RunningStudy, views: ParticipantViews) -> None:
        self._running = running
        self._views = views
        self._made_at = -1.0
        self._made = ""

    def newest(self) -> str:
        """The state as JSON, at most a second old."""
        now = time.monotonic()
        if now - self._made_at >= 0.9:
            self._made, self._made_at = orjson.dumps(self.state()).decode(), now
        return self._made

    def state(self) -> State:
        running, now = self._running, time.monotonic()
        sessions = list(running.participants)
        rows = [self._row(session, now) for session in sessions]
        return {
            "study": {"id": running.study.id, "title": running.study.title.text(running.study.languages[0])},
            "paused": running.progress.paused,
            "counts": {
                "planned": running.study.participants,
                "finished": sum(session.record.outcome == "done" for session in sessions),
                "active": sum(not row["outcome"] and row["present"] for row in rows),
                "waiting": running.units.waiting_count,
            },
            "participants": rows,
            "waiting": [session.pid for session in sessions if running.units.waiting_since(session) is not None],
            "rooms": [unit.running_round.room.id for unit in running.units if unit.running_round],
            "alerts": running.alerts.to_json(),
            "notes": running.notes.to_json(),
            "server": self._server(),
        }

    def _server(self) -> State:
        host, rooms = self._running.host, self._running.rooms
        lateness = host.scheduler.lateness
        return {
            "late_p99_ms": round(lateness.percentile_ms(0.99), 2),
            "missed": lateness.skipped,
            "ticks": lateness.ticks,
            "disk_free_mb": round(shutil.disk_usage(host.settings.data).free / 1e6),
            "recordings": rooms.recorded,
            "partial": rooms.partial,
        }

    def _row(self, session: ParticipantSession, now: float) -> State:
        running, unit, step = self._running, self._running.units.of(session), session.step
        rounds = [one.key for one in session.steps if one.kind == "round"]
        others = unit.others(session) if unit else []
        plays = step is not None and step.kind in ("practice", "round")
        return {
            "pid": session.pid,
            "unit": session.record.unit,
            "partner_letter": self._views.letter(unit, step) if step else None,
            "partner_pid": others[0].pid if others else None,
            "seat": unit.seat_of(step, session) if unit and step and plays else None,
            "step": session.record.step,
            "kind": "code" if session.finished else step.kind if step else "waiting",
            "title": unit.running_round.room.round.map.title if unit and unit.running_round else "",
            "position": {"done": session.steps_done(), "total": len(session.steps)},
            "round": {"number": rounds.index(step.key) + 1, "of": len(rounds)} if step and step.turn else None,
            "since_s": round(_standing_since(unit, now) - session.step_since),
            "present": session.present(now) or _connected(session, unit),
            "outcome": session.record.outcome,
            "code_given": session.record.code is not None,
            "code": session.record.code,
            "minutes": minutes_here(session.record),
            "episode": unit.episode if unit else "",
            "paused": running.progress.is_paused(session),
            "unit_paused": unit is not None and unit.paused,
            "paused_s": round(now - unit.standing_since) if unit and unit.standing_since is not None else None,
            **_round_state(session, unit),
        }


def _standing_since(unit: StudyUnit | None, now: float) -> float:
    """Until when time at a step counts: it stands still in a pause."""
    return now if unit is None or unit.standing_since is None else unit.standing_since


def _round_of(session: ParticipantSession, unit: StudyUnit | None) -> RunningRound | None:
    """The round that a participant is playing."""
    return unit.running_round if unit and unit.running_round and session.pid in unit.running_round.seats else None


def _connected(session: ParticipantSession, unit: StudyUnit | None) -> bool:
    running_round = _round_of(session, unit)
    return running_round is not None and running_round.room.seats[running_round.seats[session.pid]].client is not None


def _round_state(session: ParticipantSession, unit: StudyUnit | None) -> State:
    """The fields that are empty outside a room."""
    running_round = _round_of(session, unit)
    if running_round is None:
        return {"room": None, "phase": "", "tick": None, "limit_ticks": None, "late_ms": None, "missed": None,
                "recording": "", "rtt_ms": session.rtt_ms}  # fmt: skip
    room = running_round.room
    client = room.seats[running_round.seats[session.pid]].client
    late_ms = room.round.quality.late_p99_ms() if room.round.started else None
    problem = room.round.recording_problem.message or "not recording"
    recording = "recording" if room.recording else "" if room.config.practice else problem
    return {
        "room": room.id,
        "phase": room.phase,
        "tick": room.round.state.tick,
        "limit_ticks": room.round.limit_ticks or None,
        "late_ms": None if late_ms is None else round(late_ms, 2),
        "missed": room.missed_ticks,
        "recording": recording if room.round.started else "",
        "rtt_ms": client.rtt_ms if client is not None else session.rtt_ms,
    }
