"""The server's state for the admin page and the load test: what each process with rooms reports, taken together."""

import os
import resource
import time
from collections import Counter
from typing import TYPE_CHECKING, Any

import msgspec
import psutil

from movingout.server.rooms.lateness import Lateness
from movingout.server.rooms.room import Room

if TYPE_CHECKING:
    from movingout.server.public_host import PublicHost
    from movingout.server.room_host import RoomHost

SUMS = ("missed_ticks", "deadline_misses", "sockets", "bytes_sent", "cpu_seconds", "rss_mb")


def process_report() -> dict[str, Any]:
    """What any process says of itself."""
    process = psutil.Process()
    return {
        "pid": os.getpid(),
        "rss_mb": round(process.memory_info().rss / 1e6, 1),
        "cpu_seconds": round(time.process_time(), 3),
        "open_files": process.num_fds(),
        "most_files": resource.getrlimit(resource.RLIMIT_NOFILE)[0],
    }


def room_report(host: "RoomHost") -> dict[str, Any]:
    """What one process says of its rooms. `late` is its measurement of lateness, as `Lateness.counts` gives it."""
    lateness = host.scheduler.lateness
    return process_report() | {
        "process": 0,  # its number, which the front of several processes knows
        "cpu_percent": round(100 * host.cpu_share, 1),
        "late": lateness.counts(),
        "missed_ticks": lateness.skipped,
        "deadline_misses": host.registry.deadline_misses(),
        "sockets": host.admission.sockets,
        "bytes_sent": host.endpoint.total_bytes_sent(),
        "tick_share": round(host.overload.tick_share, 4),
        "agent_decisions": host.agents.decisions,
        "agent_decisions_late": host.agents.missed,
        "rounds_unrecorded": host.registry.unrecorded,
        "rooms_not_opened": len(host.not_opened),
        "sync_age_s": round(host.sync_age_s(), 2),
        "refusals": dict(host.admission.refusals),
        "agents": host.agents.report(),
        "rooms": [_room(room) for room in host.registry.rooms.values()],
    }


def server_report(host: "PublicHost", reports: list[dict[str, Any]]) -> dict[str, Any]:
    """One JSON document; times in ms, sizes in bytes unless the name says otherwise."""
    lateness = Lateness()
    for each in reports:
        lateness.include(each["late"])
    refusal = host.refusal()
    return {
        "uptime_s": round(time.monotonic() - host.started_at, 1),
        "cpu_percent": max((each["cpu_percent"] for each in reports), default=0.0),  # of the busiest process
        "load": os.getloadavg()[0],
        "ticks": lateness.ticks,
        "late_ms": lateness.report(),
        **{name: round(sum(each[name] for each in reports), 3) for name in SUMS},
        "disk_free_mb": round(host.disk_free() / 1e6),
        "finalising": host.recording_service.pending,
        "faults": host.faults(),
        "refusals": dict(sum(refused(host, reports).values(), Counter())),
        "unfinished": host.recording_service.unfinished,
        "uploads": None if host.uploads is None else {"waiting": host.uploads.waiting, "problem": host.uploads.problem},
        "refusal": refusal.message,
        "refusal_code": refusal.code,
        "refusal_values": refusal.values,
        "agents": [worker for each in reports for worker in each["agents"]],
        "rooms": [
            room | {"rooms_of_address": len(host.admission.rooms_owned_by(host.admission.owner_of(room["room"])))}
            for each in reports
            for room in each["rooms"]
        ],
    }


def refused(host: "PublicHost", reports: list[dict[str, Any]]) -> dict[str, Counter[str]]:
    """What was refused, by process and reason: by those with rooms, and by the front where it is another one."""
    found = {str(each["process"]): Counter(each["refusals"]) for each in reports}
    if all(each["pid"] != os.getpid() for each in reports):
        found["front"] = Counter(host.admission.refusals)
    return found


def _room(room: Room) -> dict[str, Any]:
    return {
        "room": room.id,
        "phase": room.phase,
        "reason": room.notice.message,
        "reason_code": room.notice.code,
        "reason_values": room.notice.values,
        "map": room.round.map.name,
        "title": room.round.map.title,
        "round": room.series.index + 1,
        "rounds": len(room.config.maps),
        "tick": room.round.state.tick,
        "limit_ticks": room.round.limit_ticks,
        "delivered": sum(room.round.delivered),
        "items": len(room.round.delivered),
        "seats": msgspec.to_builtins(room.state().seats),
        "spectators": room.seating.spectators,
        "recording": room.recording,
        "recording_problem": room.round.recorder.problem.message,
        "recording_problem_code": room.round.recorder.problem.code,
        "episode": room.round.episode_id,
        "missed_ticks": room.missed_ticks,
        "deadline_misses": room.round.deadline_misses,
    }
