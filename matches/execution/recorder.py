"""Records a match in the same format as a live room, so that it can be replayed, verified and exported alike."""

import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.agents.catalogue import unseen_map
from movingout.agents.recording_metadata import cards, seat_info
from movingout.matches.match import Match
from movingout.recordings import AgentDecision, EpisodeHeader, EpisodeWriter, Event, TickRecord, finalise
from movingout.recordings.episode import EventKind, Outcome
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.state import Floats, WorldState


class MatchRecorder:
    """Writes the recording of one match. Raises RecordingError when it cannot be written."""

    def __init__(self, folder: Path, match: Match, initial: WorldState) -> None:
        the_map = match.world_map()
        name = f"{the_map.file_name[:40]}-{match.id}"
        for suffix in (SUFFIX, JOURNAL_SUFFIX):  # left by a run that was killed before it wrote the result
            (folder / f"{name}{suffix}").unlink(missing_ok=True)
        blue, red = (seat_info(agent_id) for agent_id in match.seats)
        header = EpisodeHeader(
            name, the_map, match.seed, match.ticks, (blue, red), time.time_ns(), "match", {"match": match.id}
        )
        self._writer = EpisodeWriter.create(folder, header, initial, cards(header.seats))
        self._writer.event(Event(0, "start"))
        for seat, agent_id in enumerate(match.seats):
            if caution := unseen_map(agent_id, the_map.name):
                self._writer.event(Event(0, "unseen_map", seat, -1, caution))
        self._held = [-1, -1]
        self._delivered = [False] * len(the_map.items)

    def tick(self, actions: Floats, after: WorldState, delivered: list[bool]) -> None:
        """Record a tick: the world actions (2, 3) and the state after them."""
        held = after.held.tolist()
        for kind, seat, item in hand_events(self._held, held, actions[:, 2] > 0.5):
            self._writer.event(Event(after.tick, kind, seat, item))
        for item, (was, now) in enumerate(zip(self._delivered, delivered, strict=True)):
            if was != now:
                self._writer.event(Event(after.tick, "delivered" if now else "undelivered", -1, item))
        self._held, self._delivered = held, delivered
        self._writer.tick(TickRecord(actions, ("agent", "agent"), (-1, -1), after, tuple(delivered), 0.0))

    def decision(self, seat: int, tick: int, detail: Mapping[str, object]) -> None:
        """Record what an agent says about its decision for a tick."""
        self._writer.agent(AgentDecision(tick, seat, -1.0, False, detail))

    def close(self, outcome: Outcome, tick: int, seat: int = -1, detail: str = "") -> Path:
        """Close and finalise the recording; returns its path."""
        if outcome == "error":
            self._writer.event(Event(tick, "agent_error", seat, -1, detail))
        self._writer.event(Event(tick, "end", -1, -1, outcome))
        return finalise(self._writer.close(outcome))

    def discard(self) -> None:
        """Remove what was recorded: the match is played again."""
        self._writer.abandon()
        self._writer.path.unlink(missing_ok=True)


def hand_events(
    before: list[int], after: list[int], pressed: npt.NDArray[np.bool_]
) -> list[tuple[EventKind, int, int]]:
    """Grabs, releases and failed grabs of a tick: (kind, seat, item)."""
    events: list[tuple[EventKind, int, int]] = []
    for seat, (was, now) in enumerate(zip(before, after, strict=True)):
        if was < 0 <= now:
            events.append(("grab", seat, now))
        elif now < 0 <= was:
            events.append(("release", seat, was))
        elif np.any(pressed[seat]):
            events.append(("grab_failed", seat, -1))
    return events
