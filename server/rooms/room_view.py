"""What others see of a room, and do to it, wherever the room is: functions and values that can be sent there.

`PublicHost.ask(room_id, work)` does such work in the process of the room.
"""

import time
from collections.abc import Mapping
from typing import NamedTuple

from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.notices import Notice
from movingout.server.rooms import player_requests
from movingout.server.rooms.phases import IN_ROUND
from movingout.server.rooms.room import Room
from movingout.server.rooms.room_notices import NOBODY_HERE, ROOM_IDLE
from movingout.server.rooms.seat import Seat
from movingout.server.security.tokens import Hash

LEFT_BEHIND_S = 60.0  # a room that was empty for so long may give way to another one
IDLE_S = 900.0  # and so may, after those, one where somebody waits for so long


class SeatStatus(NamedTuple):
    """One seat; `agent_failure` and `agent_caution` are empty where there is nothing to say."""

    present: bool  # somebody is connected
    rtt_ms: float  # -1 unknown
    title: str
    player_name: str
    agent_failure: str
    agent_caution: str


class RoomView(NamedTuple):
    """A room at one moment."""

    id: str
    episode: str  # of its round
    study: dict[str, str]
    practice: bool
    phase: m.Phase
    held: str  # the code of why the clock is stopped
    clients: int
    seats: tuple[SeatStatus, ...]
    map_name: str
    map_title: str
    started: bool
    tick: int
    limit_ticks: int
    late_ms: float | None  # 99th percentile
    missed: int
    recording: bool
    recording_problem: str


class PlayedSeat(NamedTuple):
    """How a round went for one seat."""

    device: str
    rtt_ms: float | None
    idle_share: float | None
    hidden_s: float


class PlayedRound(NamedTuple):
    """How a round went."""

    episode: str
    practice: bool
    result: m.Result
    late_ms: float | None
    seats: tuple[PlayedSeat, ...]


def room_view(room: Room) -> RoomView:
    the_round = room.round
    return RoomView(
        id=room.id,
        episode=the_round.episode_id,
        study=room.config.study,
        practice=room.config.practice,
        phase=room.phase,
        held=room.held.code,
        clients=len(room.seating.clients),
        seats=tuple(_seat_view(seat) for seat in room.seats),
        map_name=the_round.map.name,
        map_title=the_round.map.title,
        started=the_round.started,
        tick=the_round.state.tick,
        limit_ticks=the_round.limit_ticks,
        late_ms=the_round.quality.late_p99_ms() if the_round.started else None,
        missed=room.missed_ticks,
        recording=room.recording,
        recording_problem=the_round.recorder.problem.message,
    )


def _seat_view(seat: Seat) -> SeatStatus:
    return SeatStatus(
        present=seat.client is not None,
        rtt_ms=seat.client.rtt_ms if seat.client is not None else -1.0,
        title=seat.title,
        player_name=seat.player_name,
        agent_failure=seat.agent_failure,
        agent_caution=seat.agent_caution,
    )


def played_round(room: Room, result: m.Result) -> PlayedRound:
    quality = room.round.quality
    seats = tuple(
        PlayedSeat(
            device=seat.controls.device,
            rtt_ms=quality.rtt_ms(seat.index),
            idle_share=quality.idle_share(seat.index),
            hidden_s=quality.hidden_s(seat.index),
        )
        for seat in room.seats
    )
    return PlayedRound(room.round.episode_id, room.config.practice, result, quality.late_p99_ms(), seats)


def stopped_round(room: Room, outcome: Outcome = "stopped") -> PlayedRound:
    """The round as far as it was played; one that is over already ended as it did."""
    ended = room.series.results[-1] if room.series.results else None
    if ended is not None and ended.recording in ("", room.round.episode_id):
        return played_round(room, ended)
    return played_round(room, room.round.result(0, outcome))


def hold(room: Room, notice: Notice) -> RoomView:
    """Stop the clock; only `release` ends that."""
    room.hold(notice, time.monotonic())
    return room_view(room)


def release(room: Room) -> RoomView:
    room.release(time.monotonic())
    return room_view(room)


def retire(room: Room, seat: int) -> None:
    """A player has practised enough; the other may play on."""
    player_requests.retire(room, room.seats[seat], time.monotonic())


def note_skip(room: Room, seat: int) -> None:
    room.round.note_skip(seat)


def give_keys(room: Room, keys: Mapping[int, Hash]) -> RoomView:
    """From now on these tokens open the seats."""
    for seat, key in keys.items():
        room.seats[seat].key = key
    return room_view(room)


class LeftState(NamedTuple):
    """How much a room is needed."""

    empty_s: float
    idle_s: float  # outside of a round
    joined: bool  # it was joined or is watched now
    id: str


def left_state(room: Room) -> LeftState:
    """For how long a room is empty and idle, and whether anybody ever came."""
    now = time.monotonic()
    joined = room.was_joined or bool(room.seating.clients)
    idle_s = 0.0 if room.phase in IN_ROUND else now - max(room.unchanged_since, room.seating.taken_at)
    return LeftState(empty_s=room.empty_s(now), idle_s=idle_s, joined=joined, id=room.id)


def longest_left(states: list[LeftState]) -> list[str]:
    """The rooms that may give way to others, the one that was left first before the others; then idle ones."""
    left = sorted((each for each in states if each.empty_s >= LEFT_BEHIND_S), reverse=True)
    idle = [each for each in states if each.empty_s < LEFT_BEHIND_S and each.idle_s >= IDLE_S]
    return [each.id for each in (*left, *sorted(idle, key=lambda each: each.idle_s, reverse=True))]


def end_if_left(room: Room) -> bool:
    """End a room that nobody has come back to, or that is idle; done where it is, so that nobody arrives in between."""
    state = left_state(room)
    if state.empty_s >= LEFT_BEHIND_S:
        room.close(m.CLOSE_ROOM_OVER, NOBODY_HERE)
    elif state.idle_s >= IDLE_S:
        room.close(m.CLOSE_ROOM_OVER, ROOM_IDLE)
    else:
        return False
    return True
