"""What happened, on disk: one MCAP file per episode, written live, recovered after a crash, verified."""

from recordings.episode import (
    AgentDecision,
    Episode,
    EpisodeHeader,
    Event,
    InputSample,
    SeatInfo,
    TickRecord,
)
from recordings.errors import RecordingError
from recordings.reader import read_episode
from recordings.writer import EpisodeWriter

__all__ = [
    "AgentDecision",
    "Episode",
    "EpisodeHeader",
    "EpisodeWriter",
    "Event",
    "InputSample",
    "RecordingError",
    "SeatInfo",
    "TickRecord",
    "read_episode",
]
