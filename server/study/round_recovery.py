"""How a round went, from its recording: for rounds whose end a killed server did not live to write down."""

from pathlib import Path
from typing import NamedTuple

from movingout.recordings import read_episode
from movingout.recordings.storage.listing import read_summary
from movingout.server.rooms.quality import RoundHealth
from movingout.study.store.rounds import RoundOutcome
from movingout.world.metrics import Metrics


class Recovered(NamedTuple):
    """What the row of a round and of its players wants to know; players by seat."""

    played: RoundOutcome
    rtt_ms: tuple[float | None, float | None]
    idle_share: tuple[float | None, float | None]


def recovered(path: Path) -> Recovered:
    """Read a finished recording. Raises RecordingError."""
    summary, health = read_summary(path), RoundHealth()
    for tick in read_episode(path).ticks:
        health.tick(tick.actions, tick.rtt_ms, tick.late_ms)
    metrics = Metrics.of(summary.metrics)
    played = RoundOutcome(
        outcome=summary.outcome,
        ticks=summary.ticks,
        tcr=metrics.tcr,
        nfd=metrics.nfd,
        wt_s=metrics.wt_s or 0.0,
        ac=metrics.ac,
        late_ms=health.late_p99_ms(),
    )
    return Recovered(played, (health.rtt_ms(0), health.rtt_ms(1)), (health.idle_share(0), health.idle_share(1)))
