"""Writes one episode while it is played: each tick goes into the journal with one write.

Called from the room's tick, so nothing here waits for the disk; `sync` is for a thread, `finalise` for another
process. The derived topics (metrics, scene, transforms) are made when the journal is finalised.
"""

import time
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import TypeVar

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import AgentDecision, Episode, EpisodeHeader, Event, InputSample, Outcome, TickRecord
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format import payloads
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX, Journal, head, message, metadata_record
from movingout.recordings.file_format.metadata import END, EPISODE_ID, header_metadata
from movingout.recordings.file_format.reader import episode_of_journal
from movingout.recordings.file_format.topics import CHANNELS, TICK_NS
from movingout.recordings.versions import versions
from movingout.world.contact import collision_speed
from movingout.world.scoring import delivered_items
from movingout.world.state import WorldState

_AT_ONCE = frozenset({"pause", "resume", "drop", "return", "end"})  # no tick may follow that would carry them
Sample = TypeVar("Sample")


def _may_fail(write: "Callable[[EpisodeWriter, Sample], None]") -> "Callable[[EpisodeWriter, Sample], None]":
    """Where an error goes: to the caller, or to whom `tolerate_errors` named."""

    @wraps(write)
    def attempt(writer: "EpisodeWriter", sample: Sample) -> None:
        try:
            write(writer, sample)
        except RecordingError as error:
            writer.fail(error)

    return attempt


class EpisodeWriter:
    """One episode's journal. Every method raises RecordingError on a disk error; the file stays recoverable.

    After such an error call `abandon` and go on without recording; or say so beforehand with `tolerate_errors`.
    """

    def __init__(
        self,
        journal: Journal,
        header: EpisodeHeader,
        last: WorldState,
        sequence: int,
        clock: Callable[[], int] = time.time_ns,
    ) -> None:
        """`last` is the newest state in the journal, or the one that it is to begin with."""
        self._journal = journal
        self._started_ns = header.started_ns
        self._item_ids = [item.id for item in header.map.items]
        self._last = last
        self._tick = last.tick
        self._sequence = sequence
        self._clock = clock
        self._pending: list[bytes] = []
        self._on_error: Callable[[RecordingError], None] | None = None

    @classmethod
    def create(
        cls,
        folder: Path,
        header: EpisodeHeader,
        initial: WorldState,
        attachments: Mapping[str, bytes] | None = None,
        clock: Callable[[], int] = time.time_ns,
        software: Mapping[str, str] | None = None,
    ) -> "EpisodeWriter":
        """Start `<folder>/<episode_id>.mcap.journal`; the folder is made when missing.

        `attachments` are small JSON files kept inside (cards, configuration); the map is always there. `software` is
        what made the states, if not this installation (imports).
        """
        if not EPISODE_ID.fullmatch(header.episode_id):
            raise RecordingError(f"episode id {header.episode_id!r}: up to 80 letters, digits, '-' and '_' are needed")
        if (folder / f"{header.episode_id}.mcap").exists():
            raise RecordingError(f"{header.episode_id}.mcap exists already in {folder}; choose another episode id")
        journal = Journal.create(folder / f"{header.episode_id}{JOURNAL_SUFFIX}")
        writer = cls(journal, header, initial, sequence=0, clock=clock)
        try:
            writer._begin(header, initial, attachments or {}, versions() if software is None else software)
        except RecordingError:
            writer.abandon()
            journal.path.unlink(missing_ok=True)  # nothing whole is in it
            raise
        return writer

    @classmethod
    def resume(cls, journal: Path, clock: Callable[[], int] = time.time_ns) -> tuple["EpisodeWriter", Episode]:
        """Go on with an interrupted journal after its last whole tick, with what it holds so far."""
        opened, data, _ = Journal.reopen(journal)
        try:
            episode = episode_of_journal(data, journal.name)
            if episode.outcome != "interrupted":
                raise RecordingError(f"{journal.name} belongs to an episode that has ended ({episode.outcome})")
        except RecordingError:
            opened.close()
            raise
        return cls(opened, episode.header, episode.states[-1], 4 * len(data), clock), episode

    @property
    def path(self) -> Path:
        """The journal."""
        return self._journal.path

    def tolerate_errors(self, on_error: Callable[[RecordingError], None]) -> None:
        """From now on a write that fails ends the recording and calls `on_error` instead of raising."""
        self._on_error = on_error

    def fail(self, error: RecordingError) -> None:
        """A write has failed: raises `error`, unless errors are tolerated."""
        if self._on_error is None:
            raise error
        self.abandon()
        self._on_error(error)

    @_may_fail
    def input(self, sample: InputSample) -> None:
        """A raw input; written with the next tick."""
        self._add("/inputs", sample.tick, payloads.finite(payloads.write_input(sample)))

    @_may_fail
    def agent(self, decision: AgentDecision) -> None:
        """An agent's answer; written with the next tick."""
        self._add(f"/agent/{SEAT_COLOURS[decision.seat]}", decision.tick, payloads.write_agent(decision))

    @_may_fail
    def event(self, event: Event) -> None:
        """An event; written with the next tick, or at once when it stops the clock."""
        self._add("/events", event.tick, payloads.write_event(event))
        if event.kind in _AT_ONCE:
            self.flush()

    @_may_fail
    def tick(self, record: TickRecord) -> None:
        """One tick and all that came before it, with the collision that the states show. Ticks are consecutive."""
        number = record.state.tick
        if number != self._tick + 1:
            raise RecordingError(f"tick {number} cannot follow tick {self._tick}")
        speed = collision_speed(self._last, record.state)
        if speed > 0:
            self.event(Event(number, "collision", detail=f"{speed:.2f} units/s"))
        self._add("/actions", number, payloads.finite(payloads.write_actions(record)))
        self._add(
            "/state", number, payloads.finite(payloads.write_state(record.state, record.delivered, self._item_ids))
        )
        self._add("/timing", number, payloads.finite(payloads.write_timing(record)))
        self._tick, self._last = number, record.state
        self.flush()

    def flush(self) -> None:
        """Write what is waiting for the next tick."""
        records, self._pending = b"".join(self._pending), []
        if records:
            self._journal.append(records, self._tick, self._log_ns(self._tick))

    def sync(self) -> None:
        """fdatasync: what was written survives a power failure. Takes milliseconds: call it in a thread, at 1 Hz."""
        self._journal.sync()

    def close(self, outcome: Outcome) -> Path:
        """End the episode; give the journal's path to `finalise` in another process."""
        self._pending.append(metadata_record(END, {"outcome": outcome, "ended_ns": str(self._clock())}))
        try:
            self.flush()
        except RecordingError as error:
            self.fail(error)
        finally:
            self._journal.close()
        return self.path

    def abandon(self) -> None:
        """Let go of the journal as it is; it is resumed or recovered later."""
        self._journal.close()

    def _begin(
        self,
        header: EpisodeHeader,
        initial: WorldState,
        attachments: Mapping[str, bytes],
        software: Mapping[str, str],
    ) -> None:
        the_map = payloads.write_map(header.map)
        entries = header_metadata(header, software)
        self._pending.append(
            head(
                f"movingout {versions()['movingout']}", entries, {"map.json": the_map, **attachments}, header.started_ns
            )
        )
        self._add("/map", 0, the_map)
        delivered = delivered_items(header.map, initial.item_poses).tolist()
        start = payloads.write_state(initial, delivered, self._item_ids)
        self._add("/state", 0, payloads.finite(start))
        self.flush()

    def _add(self, topic: str, tick: int, payload: bytes) -> None:
        self._sequence += 1
        self._pending.append(message(CHANNELS[topic], self._sequence, self._log_ns(tick), self._clock(), payload))

    def _log_ns(self, tick: int) -> int:
        """Even time of play: pauses do not stretch the timeline; publish time is the wall clock."""
        return self._started_ns + tick * TICK_NS
