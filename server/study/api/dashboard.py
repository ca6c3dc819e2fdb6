"""The experimenter's screen as one JSON document. Partners are letters here too: whoever leads stays blind."""

import shutil
from typing import Any

import orjson

from movingout.server.study.api.participant_view import Views
from movingout.server.study.participant_session import Guest
from movingout.server.study.running_study import RunningStudy
from movingout.server.study.unit import Crew, Game

State = dict[str, Any]


class Dashboard:
    """Made at most once a second, however many look at it."""

    def __init__(self, running: RunningStudy, views: Views) -> None:
        self._running = running
        self._views = views
        self._made_at = -1.0
        self._made = ""

    def newest(self) -> str:
        """As JSON, not older than a second."""
        now = self._running.now()
        if now - self._made_at >= 0.9:
            self._made, self._made_at = orjson.dumps(self.state()).decode(), now
        return self._made

    def state(self) -> State:
        running, now = self._running, self._running.now()
        guests = list(running.guests.values())
        rows = [self._row(guest, now) for guest in guests]
        return {
            "study": {"id": running.study.id, "title": running.study.title.text(running.study.languages[0])},
            "paused": running.paused,
            "counts": {
                "planned": running.study.participants,
                "finished": sum(guest.place.outcome == "done" for guest in guests),
                "active": sum(not row["outcome"] and row["present"] for row in rows),
                "waiting": len(running.waiting),
            },
            "participants": rows,
            "waiting": [guest.pid for guest in guests if running.waiting.since(guest.pid) is not None],
            "rooms": [crew.game.room.id for crew in running.crews.values() if crew.game],
            "alerts": running.alerts.to_json(),
            "notes": running.notes,
            "server": self._server(),
        }

    def _server(self) -> State:
        host, playing = self._running.host, self._running.playing
        lateness = host.ticker.lateness
        return {
            "late_p99_ms": round(lateness.percentile_ms(0.99), 2),
            "missed": lateness.skipped,
            "ticks": lateness.ticks,
            "disk_free_mb": round(shutil.disk_usage(host.settings.data).free / 1e6),
            "recordings": playing.recorded,
            "partial": playing.partial,
        }

    def _row(self, guest: Guest, now: float) -> State:
        running, crew, step = self._running, self._running.crew_of(guest), guest.step
        rounds = [one.key for one in guest.way if one.kind == "round"]
        others = crew.others(guest) if crew else []
        plays = step is not None and step.kind in ("practice", "round")
        return {
            "pid": guest.pid,
            "unit": guest.place.unit,
            "partner_letter": self._views.letter(crew, step) if step else None,
            "partner_pid": others[0].pid if others else None,
            "seat": crew.seat_of(step, guest) if crew and step and plays else None,
            "step": guest.place.step,
            "kind": "code" if guest.finished else step.kind if step else "waiting",
            "title": crew.game.room.round.map.title if crew and crew.game else "",
            "position": {"done": guest.done(), "total": len(guest.way)},
            "round": {"number": rounds.index(step.key) + 1, "of": len(rounds)} if step and step.turn else None,
            "since_s": round(now - guest.since),
            "present": guest.present(now) or _seated(guest, crew),
            "outcome": guest.place.outcome,
            "code_given": guest.place.code is not None,
            "episode": crew.episode if crew else "",
            "paused": running.stays(guest),
            **_game(guest, crew),
        }


def _playing(guest: Guest, crew: Crew | None) -> Game | None:
    """The game that somebody is in."""
    return crew.game if crew and crew.game and guest.pid in crew.game.seats else None


def _seated(guest: Guest, crew: Crew | None) -> bool:
    game = _playing(guest, crew)
    return game is not None and game.room.seats[game.seats[guest.pid]].client is not None


def _game(guest: Guest, crew: Crew | None) -> State:
    """What is only known of somebody who is in a room."""
    game = _playing(guest, crew)
    if game is None:
        return {"room": None, "phase": "", "tick": None, "limit_ticks": None, "late_ms": None, "missed": None,
                "recording": "", "rtt_ms": guest.rtt_ms}  # fmt: skip
    room = game.room
    client = room.seats[game.seats[guest.pid]].client
    late_ms = room.round.health.late_p99_ms() if room.round.started else None
    problem = room.round.recorder.problem or "not recording"
    recording = "recording" if room.recording else "" if room.config.practice else problem
    return {
        "room": room.id,
        "phase": room.phase,
        "tick": room.round.state.tick,
        "limit_ticks": room.round.limit_ticks or None,
        "late_ms": None if late_ms is None else round(late_ms, 2),
        "missed": room.missed_ticks,
        "recording": recording if room.round.started else "",
        "rtt_ms": client.rtt_ms if client is not None else guest.rtt_ms,
    }
