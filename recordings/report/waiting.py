"""When a robot waited for help: the intervals behind the metric WT."""

from dataclasses import dataclass

from movingout.recordings.report.track import Track, spans
from movingout.world.constants import TICK_SECONDS


@dataclass(frozen=True, slots=True)
class Wait:
    """An interval in which one seat alone held an undelivered middle or large item."""

    seat: int
    item: int  # index
    start: int  # first tick
    end: int  # first tick after

    @property
    def seconds(self) -> float:
        return (self.end - self.start) * TICK_SECONDS


def waits(track: Track) -> list[Wait]:
    """All waits of an episode, by start; their lengths add up to WT (`world.metrics.EpisodeMetrics`)."""
    found = [
        Wait(seat, item, *span)
        for seat in (0, 1)
        for item in range(len(track.map.items))
        if track.is_big(item)
        for span in spans(track.alone(seat, item)[:-1])  # the state after the last tick does not count
    ]
    return sorted(found, key=lambda wait: (wait.start, wait.seat))
