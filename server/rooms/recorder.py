"""The recording of one round, which may fail without stopping the game.

A full disk or a lost folder ends the recording, never the round: `active` turns False, `problem` says why, and
everybody in the room sees "not recording".
"""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from movingout.recordings import AgentDecision, EpisodeWriter, Event, InputSample, RecordingError, TickRecord
from movingout.recordings.episode import Outcome

Sample = TypeVar("Sample")
log = logging.getLogger(__name__)


class Recorder:
    """Passes everything to an EpisodeWriter until a write fails."""

    def __init__(self, writer: EpisodeWriter | None, problem: str = "") -> None:
        self._writer = writer
        self.problem = problem

    @property
    def active(self) -> bool:
        return self._writer is not None

    def input(self, sample: InputSample) -> None:
        if self._writer is not None:
            self._attempt(self._writer.input, sample)

    def tick(self, record: TickRecord) -> None:
        if self._writer is not None:
            self._attempt(self._writer.tick, record)

    def event(self, event: Event) -> None:
        if self._writer is not None:
            self._attempt(self._writer.event, event)

    def agent(self, decision: AgentDecision) -> None:
        if self._writer is not None:
            self._attempt(self._writer.agent, decision)

    def sync(self) -> None:
        """fdatasync; blocks, so call it in a thread. A failure shows at the next write."""
        if self._writer is not None:
            self._writer.sync()

    def close(self, outcome: Outcome) -> Path | None:
        """End the episode; returns the journal to finalise, None without a recording."""
        if self._writer is None:
            return None
        try:
            return self._writer.close(outcome)
        except RecordingError as error:
            self._give_up(error)
            return None
        finally:
            self._writer = None

    def abandon(self) -> None:
        """Close the journal as it is, to be resumed."""
        if self._writer is not None:
            self._writer.abandon()
            self._writer = None

    def _attempt(self, write: Callable[[Sample], None], value: Sample) -> None:
        try:
            write(value)
        except RecordingError as error:
            self._give_up(error)

    def _give_up(self, error: RecordingError) -> None:
        self.problem = str(error)
        log.error("recording stopped: %s", error)
        if self._writer is not None:
            self._writer.abandon()
            self._writer = None
