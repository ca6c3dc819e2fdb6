"""The server's state for the admin page and the load test."""

import os
import shutil
import time
from typing import TYPE_CHECKING, Any

import msgspec
import psutil

from movingout.server.rooms.room import Room

if TYPE_CHECKING:
    from movingout.server.host import Host


def report(host: "Host") -> dict[str, Any]:
    """One JSON document; times in ms, sizes in bytes unless the name says otherwise."""
    rooms = list(host.registry.rooms.values())
    lateness = host.scheduler.lateness
    refusal = host.refusal()
    disk = shutil.disk_usage(host.settings.data)
    return {
        "uptime_s": round(time.time() - host.started_at, 1),
        "cpu_percent": round(100 * host.cpu_share, 1),
        "rss_mb": round(psutil.Process().memory_info().rss / 1e6, 1),
        "load": os.getloadavg()[0],
        "ticks": lateness.ticks,
        "missed_ticks": lateness.skipped,
        "late_ms": lateness.report(),
        "deadline_misses": host.registry.deadline_misses(),
        "sockets": host.admission.sockets,
        "bytes_sent": host.endpoint.total_bytes_sent(),
        "cpu_seconds": round(time.process_time(), 3),
        "disk_free_mb": round(disk.free / 1e6),
        "finalising": host.recording_service.pending,
        "unfinished": host.recording_service.unfinished,
        "refusal": refusal.message,
        "refusal_code": refusal.code,
        "refusal_values": refusal.values,
        "agents": host.agents.report(),
        "rooms": [_room(room) for room in rooms],
    }


def _room(room: Room) -> dict[str, Any]:
    return {
        "room": room.id,
        "phase": room.phase,
        "reason": room.notice.message,
        "reason_code": room.notice.code,
        "reason_values": room.notice.values,
        "map": room.round.map.name,
        "round": room.series.index + 1,
        "rounds": len(room.config.maps),
        "tick": room.round.state.tick,
        "limit_ticks": room.round.limit_ticks,
        "delivered": sum(room.round.delivered),
        "items": len(room.round.delivered),
        "seats": msgspec.to_builtins(room.state().seats),
        "spectators": room.seating.spectators,
        "recording": room.recording,
        "recording_problem": room.round.recording_problem.message,
        "recording_problem_code": room.round.recording_problem.code,
        "episode": room.round.episode_id,
        "missed_ticks": room.missed_ticks,
        "deadline_misses": room.round.deadline_misses,
    }
