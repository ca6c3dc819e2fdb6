"""What a report needs to know about one recording: small and plain, so that it can be sent between processes."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.maps.spec import MapSpec
from movingout.recordings.episode import FINISHED, Episode, EpisodeHeader, Outcome, SeatInfo, player_label
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.derived_topics import result
from movingout.recordings.file_format.metadata import utc
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.occupancy import occupancy
from movingout.recordings.play_hash import play_hash
from movingout.recordings.report.failures import Failure, failures
from movingout.recordings.report.track import Track
from movingout.recordings.report.waiting import Wait, waits
from movingout.recordings.storage.listing import Unreadable
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.metrics import tick_consistency
from movingout.world.own_metrics import own_values
from movingout.world.state import Floats

Pair = tuple[str, str]  # blue, red


def _players(header: EpisodeHeader) -> Pair:
    blue, red = (player_label(seat.kind, seat.name, header.simulated) for seat in header.seats)
    return blue, red


def _name(seat: SeatInfo) -> str:
    return seat.name or seat.kind


def _agent(seat: SeatInfo) -> str:
    return seat.name if seat.kind == "agent" else ""


def _seats(label: Callable[[SeatInfo], str], header: EpisodeHeader) -> Pair:
    return label(header.seats[0]), label(header.seats[1])


GROUPINGS: dict[str, Callable[[EpisodeHeader], Pair]] = {
    "agent": _players,
    "seat": partial(_seats, _name),
    "kind": partial(_seats, lambda seat: seat.kind),
    "source": lambda header: (header.source, header.source),
}
"""How recordings are grouped into populations: by agent id without options, with all people as one, and those of
rehearsals as simulated; by full name; by kind of seat (human, agent, remote, ghost, idle); by origin of the recording
(live, match, scripted, import)."""


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeFacts:
    """The facts of one recording."""

    path: Path
    id: str
    map: MapSpec
    population: Pair
    started: str  # UTC, ISO 8601
    outcome: Outcome
    complete: bool
    ticks: int
    metrics: dict[str, float | None]  # delivered, items, and the metrics by key
    waits: tuple[Wait, ...]
    failures: tuple[Failure, ...]
    consistency: Floats  # (S, 2) per second: sum and count of the ticks' action consistency
    presence: npt.NDArray[np.float32]  # (2, 48, 48) seconds of each seat in each cell
    tutorial: bool = False
    simulated: bool = False  # in a rehearsal of a study: its participants were programs
    agents: Pair = ("", "")  # the ids of those who are agents, where populations are named without options
    played: str = ""  # equal for episodes that are equal action by action; empty where that is not known

    @property
    def finished(self) -> bool:
        """Whether it was delivered or ran out of time; only such recordings enter averages."""
        return self.complete and self.outcome in FINISHED


def facts_of(path: Path, grouping: str) -> EpisodeFacts | Unreadable:
    """The facts of a recording, or why it cannot be read."""
    try:
        return _facts(path, read_episode(path), GROUPINGS[grouping])
    except RecordingError as error:
        return Unreadable(path, str(error))


def _facts(path: Path, episode: Episode, population: Callable[[EpisodeHeader], Pair]) -> EpisodeFacts:
    header, track = episode.header, Track.of(episode)
    return EpisodeFacts(
        path=path,
        id=header.episode_id,
        map=header.map,
        population=population(header),
        tutorial=header.source == "tutorial",
        simulated=header.simulated,
        agents=_seats(_agent, header) if population is _players else ("", ""),
        played=play_hash(episode),
        started=utc(header.started_ns),
        outcome=episode.outcome,
        complete=episode.complete,
        ticks=len(episode.ticks),
        metrics=result(episode) | own_values(episode.header.map, episode.states, episode.actions),
        waits=tuple(waits(track)),
        failures=tuple(failures(track)),
        consistency=consistency_per_second(track, episode.actions),
        presence=np.array([occupancy(episode.states, seat) for seat in (0, 1)], dtype=np.float32),
    )


def consistency_per_second(track: Track, actions: Floats) -> Floats:
    """(S, 2) sum and count, in each second, of the terms of AC: ticks in which both held one middle or large item."""
    sums = np.zeros((-(-len(actions) // TICKS_PER_SECOND), 2))
    for tick, (blue, red) in enumerate(track.held[:-1].tolist()):
        if blue == red != -1 and track.is_big(blue):
            term = tick_consistency(track.robots[tick], actions[tick])
            if term is not None:
                sums[tick // TICKS_PER_SECOND] += (term, 1.0)
    return sums
