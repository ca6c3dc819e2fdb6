"""The metadata records of a recording: who, what, when, with which software. MCAP metadata map text to text."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import cast, get_args

from movingout.maps import MapSpec
from movingout.recordings.episode import EpisodeHeader, SeatInfo, SeatKind, Source
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.topics import FORMAT_VERSION
from movingout.world.constants import SUB_STEPS, TICK_MS

EPISODE, STUDY, SOFTWARE, END, RECORDING, RESULT = "episode", "study", "software", "end", "recording", "result"
EPISODE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")  # safe as a file name
SEATS = ("seat/0", "seat/1")

Entries = Mapping[str, str]


def utc(nanoseconds: int) -> str:
    """A wall-clock time [ns since the epoch] in ISO 8601."""
    return datetime.fromtimestamp(nanoseconds / 1e9, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _time(text: str) -> int:
    """A wall-clock time [ns since the epoch]. Raises ValueError for one that is in no calendar, which `utc` needs."""
    nanoseconds = int(text)
    try:
        utc(nanoseconds)
    except (OverflowError, OSError, ValueError):
        raise ValueError(f"the time {text:.40} is in no calendar") from None
    return nanoseconds


def header_metadata(header: EpisodeHeader, software: Entries) -> dict[str, dict[str, str]]:
    """The records at the head of a file; `header_of` reads them back."""
    records = {
        EPISODE: {
            "format": str(FORMAT_VERSION),
            "episode_id": header.episode_id,
            "map": header.map.name,
            "map_variant": header.map.variant,
            "seed": str(header.seed),
            "limit_ticks": str(header.limit_ticks),
            "tick_ms": str(TICK_MS),
            "substeps_per_tick": str(SUB_STEPS),
            "started_ns": str(header.started_ns),
            "started_utc": utc(header.started_ns),
            "source": header.source,
        },
        SOFTWARE: dict(software),
        STUDY: dict(header.study),
    }
    for name, colour, seat in zip(SEATS, ("blue", "red"), header.seats, strict=True):
        records[name] = {
            "colour": colour,
            "kind": seat.kind,
            "name": seat.name,
            "checkpoint_sha256": seat.checkpoint_sha256,
            "device": seat.device,
        }
    return records


def header_of(records: Mapping[str, Entries], the_map: MapSpec) -> EpisodeHeader:
    """The header from the metadata records and the map. Raises RecordingError."""
    episode = episode_record(records)
    try:
        return EpisodeHeader(
            episode_id=episode["episode_id"],
            map=the_map,
            seed=int(episode["seed"]),
            limit_ticks=int(episode["limit_ticks"]),
            seats=seats_of(records),
            started_ns=_time(episode["started_ns"]),
            source=_source(episode["source"]),
            study=dict(records.get(STUDY, {})),
        )
    except (KeyError, ValueError) as error:
        raise RecordingError(f"the metadata of this recording is incomplete: {error}") from error


def episode_record(records: Mapping[str, Entries]) -> Entries:
    """The record `episode`, of a format version that this program reads, with an id that can name files.

    Raises RecordingError.
    """
    if EPISODE not in records:
        raise RecordingError("this is not a Moving Out recording: it has no metadata record 'episode'")
    version = records[EPISODE].get("format", "")
    if version != str(FORMAT_VERSION):
        raise RecordingError(
            f"recording format {version or 'unknown'} is not the format {FORMAT_VERSION} of this program; update it"
        )
    episode_id = records[EPISODE].get("episode_id", "")
    if not EPISODE_ID.fullmatch(episode_id):  # exports are written under it
        raise RecordingError(f"episode id {episode_id!r:.100} in it: up to 80 letters, digits, '-' and '_' are needed")
    return records[EPISODE]


def seats_of(records: Mapping[str, Entries]) -> tuple[SeatInfo, SeatInfo]:
    """Who sat in blue and red. Raises KeyError or ValueError where it does not say."""
    return _seat(records[SEATS[0]]), _seat(records[SEATS[1]])


def _seat(record: Entries) -> SeatInfo:
    if record["kind"] not in get_args(SeatKind):
        raise ValueError(f"seat kind {record['kind']!r}")
    return SeatInfo(cast(SeatKind, record["kind"]), record["name"], record["checkpoint_sha256"], record["device"])


def _source(text: str) -> Source:
    if text not in get_args(Source):
        raise ValueError(f"source {text!r}")
    return cast(Source, text)
