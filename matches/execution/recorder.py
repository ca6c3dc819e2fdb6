"""Records a match in the same format as a live room, so that it can be replayed, verified and exported alike."""

import re
import time
from collections.abc import Iterable, Mapping
from itertools import count
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.agents.catalogue import unseen_map
from movingout.agents.recording_metadata import cards, seat_info
from movingout.matches.match import Match, MatchResult
from movingout.recordings import AgentDecision, EpisodeHeader, EpisodeWriter, Event, TickRecord, finalise
from movingout.recordings.episode import EventKind, Outcome
from movingout.recordings.errors import BusyError, UnreadableError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX, owned, scan
from movingout.recordings.file_format.reader import episode_of_journal
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.scoring import delivered_items
from movingout.world.state import Floats, WorldState

_NAME = re.compile(rf"-([0-9a-f]{{16}})(-\d+)?(?:{re.escape(SUFFIX)}|{re.escape(JOURNAL_SUFFIX)})$")


class MatchRecorder:
    """Writes the recording of one match. Raises RecordingError when it cannot be written, or another process does so.

    A finished recording of the same match stays: the new one has a number behind its name.
    """

    def __init__(self, folder: Path, match: Match, initial: WorldState) -> None:
        the_map = match.world_map()
        name = _free_name(folder, f"{the_map.file_name[:40]}-{match.id}")
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
        self._delivered = delivered_items(the_map, initial.item_poses).tolist()
        self._whole = False  # the journal has its end

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
        journal = self._writer.close(outcome)
        self._whole = True
        return finalise(journal)

    def discard(self) -> None:
        """Remove what was recorded: the match is played again. A whole journal stays, for `recordings recover`."""
        if self._whole:
            return
        self._writer.abandon()
        self._writer.path.unlink(missing_ok=True)


def superseded(recording: Path) -> list[Path]:
    """Where earlier recordings of the match of a recording lie, if there are any, and journals of theirs."""
    named = _NAME.search(recording.name)
    last = int(named[2][1:]) if named and named[2] else 1
    stem = recording.name.removesuffix(SUFFIX).removesuffix(f"-{last}" if last > 1 else "")
    earlier = [stem, *(f"{stem}-{number}" for number in range(2, last))][: last - 1]
    return [recording.with_name(name + suffix) for name in earlier for suffix in (SUFFIX, JOURNAL_SUFFIX)]


def recorded_before(results: Iterable[MatchResult]) -> str:
    """A sentence when the folder had recordings of some of these matches already; else empty."""
    names = [named for result in results if (named := _NAME.search(Path(result.recording).name)) and named[2]]
    if not names:
        return ""
    matches = f"{len(names):,} match{'es were' if len(names) > 1 else ' was'}"
    return (
        f"{matches} recorded in this folder before: the new recordings have a number behind their names ({names[0][2]})"
    )


def _free_name(folder: Path, name: str) -> str:
    """The name, or the first of NAME-2, NAME-3, … that has no recording; an unfinished journal of a killed run goes.

    Raises BusyError where another process records this match.
    """
    for number in count(1):
        free = f"{name}-{number}" if number > 1 else name
        journal = folder / f"{free}{JOURNAL_SUFFIX}"
        if (folder / f"{free}{SUFFIX}").exists():
            continue
        if not journal.exists() or _removed_unfinished(journal):
            return free
    raise AssertionError("numbers do not end")


def _removed_unfinished(journal: Path) -> bool:
    """Remove the journal of a killed run. False for a whole one, of which `recordings recover` makes a recording."""
    try:
        with owned(journal) as data:
            if _is_whole(data, journal.name):
                return False
            journal.unlink()
    except BusyError as error:
        raise BusyError(
            f"another process records this match here ({journal}); wait until it is over, or choose another folder"
        ) from error
    return True


def _is_whole(data: bytes, name: str) -> bool:
    found = scan(data)
    try:
        return episode_of_journal(data[: found.end], name, found.damage).outcome != "interrupted"
    except UnreadableError:
        return False


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
