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
from recordings.finished import Recovery, finalise, recover
from recordings.reader import read_episode
from recordings.replay import browser_replay
from recordings.verification import Divergence, Verification, verify
from recordings.writer import EpisodeWriter

__all__ = [
    "AgentDecision",
    "Divergence",
    "Episode",
    "EpisodeHeader",
    "EpisodeWriter",
    "Event",
    "InputSample",
    "RecordingError",
    "Recovery",
    "SeatInfo",
    "TickRecord",
    "Verification",
    "browser_replay",
    "finalise",
    "read_episode",
    "recover",
    "verify",
]
