"""The recording of a round while it is played: ticks, raw inputs, answers of agents and events.

A full disk or a lost folder ends the recording, never the round: then nothing more is written, and `problem` says why.
"""

import logging
from collections.abc import Sequence
from pathlib import Path

from movingout.recordings import AgentDecision, EpisodeWriter, Event, InputSample, RecordingError, TickRecord
from movingout.recordings.episode import Outcome
from movingout.server import messages as m
from movingout.server.agent_workers.agent_seat import AgentAnswer
from movingout.server.frames import Input
from movingout.server.notices import NOTHING
from movingout.server.rooms.input_buffer import TickInput
from movingout.server.rooms.room_notices import recording_problem
from movingout.server.rooms.seat import Seat
from movingout.world.state import Floats, WorldState

log = logging.getLogger(__name__)


class RoundRecorder:
    """Writes what happens in a round, as long as there is a writer."""

    def __init__(self) -> None:
        self.writer: EpisodeWriter | None = None
        self.problem = NOTHING  # why the round is not recorded though it should be

    @property
    def is_recording(self) -> bool:
        return self.writer is not None

    def begin(self, writer: EpisodeWriter | None) -> None:
        """Write to `writer` from now on, until it fails."""
        self.writer = writer
        if writer is not None:
            writer.tolerate_errors(self._stop)

    def suspend(self) -> None:
        """Leave the recording as it is, to be resumed."""
        if self.writer is not None:
            self.writer.abandon()
            self.writer = None

    def finish(self, outcome: Outcome) -> Path | None:
        """The round is over; returns the journal to finalise, None without a recording or with one that failed."""
        if self.writer is None:
            return None
        journal = self.writer.close(outcome)
        is_whole, self.writer = self.is_recording, None
        return journal if is_whole else None

    def event(self, event: Event) -> None:
        if self.writer is not None:
            self.writer.event(event)

    def input(self, frame: Input, tick: int, rtt_ms: float) -> None:
        """A raw input for `tick`."""
        if self.writer is None:
            return
        sample = InputSample(
            tick=tick,
            seat=frame.seat,
            seq=frame.seq,
            client_ms=frame.client_ms,
            move=frame.move,
            heading=frame.heading,
            grabs=frame.grabs,
            device=m.DEVICES[frame.device],
            rtt_ms=rtt_ms,
        )
        self.writer.input(sample)

    def decision(self, answer: AgentAnswer, tick: int, seat: int) -> None:
        """An agent's answer for `tick`, if it was asked."""
        if self.writer is None or not (answer.missed or answer.latency_ms >= 0):
            return
        decision = AgentDecision(
            tick=tick,
            seat=seat,
            latency_ms=answer.latency_ms,
            missed=answer.missed,
            detail=answer.detail,
        )
        self.writer.agent(decision)

    def tick(
        self,
        actions: Floats,
        inputs: Sequence[TickInput],
        seats: Sequence[Seat],
        state: WorldState,
        delivered: tuple[bool, ...],
        late_ms: float,
    ) -> None:
        """A tick: what each seat did, (2, 3), and the state after it."""
        if self.writer is None:
            return
        (blue, red), (blue_seat, red_seat) = inputs, seats
        record = TickRecord(
            actions=actions,
            sources=(blue_seat.source(blue), red_seat.source(red)),
            input_seqs=(blue.seq, red.seq),
            state=state,
            delivered=delivered,
            late_ms=late_ms,
            slack_ms=(blue.slack_ms, red.slack_ms),
            rtt_ms=(blue_seat.rtt_ms, red_seat.rtt_ms),
        )
        self.writer.tick(record)

    def _stop(self, error: RecordingError) -> None:
        log.error("recording stopped: %s", error)
        self.writer, self.problem = None, recording_problem(error)
