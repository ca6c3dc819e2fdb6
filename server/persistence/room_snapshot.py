"""Saving and restoring a room: after kill -9 the same people play on where the journal ends."""

import logging
from pathlib import Path
from typing import NamedTuple

import numpy as np

from movingout.maps.errors import MovingOutError
from movingout.recordings import EpisodeWriter, RecordingError
from movingout.recordings.episode import Episode
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.notices import Notice
from movingout.server.persistence.room_store import VERSION, RoomFile, SeatFile
from movingout.server.rooms.phases import IN_ROUND
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import RESTARTED
from movingout.server.rooms.round_series import RoomProgress
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import Services
from movingout.server.rooms.time_limits import RESTART_RESUME_S
from movingout.world import World
from movingout.world.state import WorldState

log = logging.getLogger(__name__)


def room_file(room: Room, saved: float) -> RoomFile:
    """What is kept of a room; `saved` is the wall clock in seconds."""
    in_round = room.phase in IN_ROUND and room.round.started and room.round.is_recorded
    return RoomFile(
        version=VERSION,
        id=room.id,
        saved=saved,
        config=room.config,
        seats=[_seat_file(seat) for seat in room.seats],
        phase=room.phase,
        reason=room.notice.message,
        reason_code=room.notice.code,
        reason_values=room.notice.values,
        index=room.series.index,
        epoch=room.series.epoch,
        episode=room.round.episode_id if in_round else "",
        results=list(room.series.results),
        next_episode="" if room.round.started else room.round.episode_id,
        joined=room.was_joined,
    )


class InterruptedRound(NamedTuple):
    """A round that goes on where its journal ends."""

    writer: EpisodeWriter
    episode: Episode


def restore_room(file: RoomFile, recordings: Path, services: Services, now: float) -> Room:
    """The room as it was, paused if it was playing. Raises MapError or AgentError when it cannot be."""
    has_begun = (recordings / f"{file.next_episode}{JOURNAL_SUFFIX}").exists()
    next_episode = "" if has_begun else file.next_episode
    return room_again(file, interrupted_round(file, recordings), services, now, next_episode=next_episode)


def room_again(
    file: RoomFile, interrupted: InterruptedRound | None, services: Services, now: float, *, next_episode: str = ""
) -> Room:
    """The same, with its round as it was read before; `next_episode` is the id of the round that has not begun."""
    seats = [_seat(index, kept, now - file.config.resume_s) for index, kept in enumerate(file.seats)]
    broken_off = file.phase in IN_ROUND
    progress = RoomProgress(
        index=file.index,
        epoch=file.epoch,
        results=tuple(file.results),
        phase="lobby" if broken_off else file.phase,
        notice=RESTARTED if broken_off else Notice(file.reason_code, file.reason, file.reason_values),
        joined=file.joined,
        next_episode=next_episode,
    )
    try:
        room = Room(room_id=file.id, config=file.config, seats=seats, services=services, now=now, progress=progress)
    except MovingOutError:
        if interrupted is not None:
            interrupted.writer.abandon()
        raise
    if interrupted is not None:
        room.resume(interrupted.episode, interrupted.writer, now + RESTART_RESUME_S)
    return room


def interrupted_round(file: RoomFile, recordings: Path) -> InterruptedRound | None:
    """The round that a room was playing, where it can go on to the bit. Takes a tenth of a second; needs no event loop.

    It holds the journal open: give it to `room_again`, or abandon its writer.
    """
    if not file.episode:
        return None
    try:
        writer, episode = EpisodeWriter.resume(recordings / f"{file.episode}{JOURNAL_SUFFIX}")
    except RecordingError as error:
        log.warning("room %s: the round cannot be resumed: %s", file.id, error)
        return None
    if not _reproduces(episode):
        log.warning("room %s: the recorded actions lead elsewhere on this machine; the round is not resumed", file.id)
        writer.abandon()
        return None
    return InterruptedRound(writer, episode)


def _reproduces(episode: Episode) -> bool:
    world = World(episode.header.map)
    for actions in episode.actions:
        world.step(actions)
    return _same(world.state(), episode.states[-1])


def _same(one: WorldState, other: WorldState) -> bool:
    fields = ("robot_poses", "robot_velocities", "held", "item_poses")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in fields)


def _seat_file(seat: Seat) -> SeatFile:
    return SeatFile(
        kind=seat.kind,
        agent_id=seat.agent_id,
        shared=seat.shared,
        name=seat.name,
        alias=seat.alias,
        token=seat.token.hex() if seat.token else "",
        previous_token=seat.previous_token.hex() if seat.previous_token else "",
        ready=seat.ready,
        gone=seat.gone,
        wants_again=seat.wants_again,
        key=seat.key.hex() if seat.key else "",
    )


def _seat(index: int, kept: SeatFile, absent_since: float) -> Seat:
    return Seat(
        index=index,
        kind=kept.kind,
        agent_id=kept.agent_id,
        shared=kept.shared,
        name=kept.name,
        alias=kept.alias,
        token=bytes.fromhex(kept.token) or None,
        previous_token=bytes.fromhex(kept.previous_token) or None,
        ready=kept.ready,
        gone=kept.gone,
        wants_again=kept.wants_again,
        key=bytes.fromhex(kept.key) or None,
        absent_since=absent_since + RESTART_RESUME_S,
    )
