"""Recordings of episodes: one MCAP file each, written live, recovered after a crash, verified by re-simulation."""

from movingout.recordings.episode import AgentDecision, Episode, EpisodeHeader, Event, InputSample, SeatInfo, TickRecord
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.file_format.writer import EpisodeWriter
from movingout.recordings.replay import browser_replay
from movingout.recordings.storage.finished import Recovery, finalise, recover
from movingout.recordings.verification import Divergence, Verification, verify

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
