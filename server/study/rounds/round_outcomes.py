"""How a round went: from the room it was played in, or from its recording where a killed server could not save it."""

from pathlib import Path
from typing import NamedTuple

from movingout.recordings import read_episode
from movingout.recordings.storage.listing import read_summary
from movingout.server.rooms.room_view import PlayedRound
from movingout.server.rooms.rounds.quality import RoundQuality
from movingout.server.study.unit import RunningRound, StudyUnit
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome
from movingout.world.metrics import Metrics, from_numbers

NOT_RECORDED = RoundOutcome(outcome="interrupted", ticks=0, tcr=0.0, nfd=0.0, wt_s=0.0, ac=None)
"""The outcome of a round without a recording: it never had a tick."""


class RecoveredRound(NamedTuple):
    """What a recording says of a round and of its players; players by seat."""

    outcome: RoundOutcome
    rtt_ms: tuple[float | None, float | None]
    idle_share: tuple[float | None, float | None]


def recovered_round(path: Path) -> RecoveredRound:
    """Read a finished recording. Raises RecordingError."""
    summary, quality = read_summary(path), RoundQuality()
    for tick in read_episode(path).ticks:
        quality.tick(tick.actions, tick.rtt_ms, tick.late_ms)
    metrics = Metrics.of(summary.metrics)
    outcome = RoundOutcome(
        outcome=summary.outcome,
        ticks=summary.ticks,
        tcr=metrics.tcr,
        nfd=metrics.nfd,
        wt_s=metrics.wt_s or 0.0,
        ac=metrics.ac,
        late_ms=quality.late_p99_ms(),
    )
    return RecoveredRound(
        outcome, (quality.rtt_ms(0), quality.rtt_ms(1)), (quality.idle_share(0), quality.idle_share(1))
    )


def recovered_players(recovered: RecoveredRound, unit: StudyUnit | None) -> list[PlayerOutcome]:
    """How a recovered round, which is the current step of the unit, went for its participants."""
    if unit is None:
        return []
    players = []
    for session in unit.members:
        if session.step is not None:
            seat = unit.seat_of(session.step, session)
            rtt_ms, idle_share = recovered.rtt_ms[seat], recovered.idle_share[seat]
            # the device stays that of the round's start
            players.append(PlayerOutcome(session.pid, seat, "", rtt_ms=rtt_ms, idle_share=idle_share))
    return players


def round_outcome(played: PlayedRound) -> RoundOutcome:
    result = played.result
    return RoundOutcome(
        outcome=result.outcome,
        ticks=result.ticks,
        tcr=result.tcr,
        nfd=result.nfd,
        wt_s=result.wt_s,
        ac=from_numbers({"ac": result.ac})["ac"],
        late_ms=played.late_ms,
    )


def player_outcomes(running: RunningRound, played: PlayedRound) -> tuple[PlayerOutcome, ...]:
    """How the round went for each participant in it."""
    return tuple(
        PlayerOutcome(
            pid=pid,
            seat=seat,
            device=played.seats[seat].device,
            rtt_ms=played.seats[seat].rtt_ms,
            idle_share=played.seats[seat].idle_share,
            hidden_s=played.seats[seat].hidden_s,
        )
        for pid, seat in running.seats.items()
    )
