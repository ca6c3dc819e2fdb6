"""The recordings in a folder: one summary each, read from the metadata alone."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import orjson

from movingout.maps.errors import MapError
from movingout.maps.files.input_file import open_input
from movingout.maps.json_format import map_from_json
from movingout.maps.library import is_generated_or_shipped
from movingout.maps.spec import MapSpec
from movingout.recordings.episode import Episode, SeatInfo, is_simulated
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.file_format.derived_topics import result
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.file_format.metadata import (
    RECORDING,
    RESULT,
    SEATS,
    STUDY,
    Entries,
    episode_record,
    seats_of,
    utc,
)
from movingout.recordings.file_format.reader import UNREADABLE, read_episode
from movingout.recordings.file_format.records import MAGIC, attachment_in, metadata_in
from movingout.recordings.storage.finished import SUFFIX
from movingout.world.metrics import from_numbers, to_numbers

MAP_FILE = "map.json"
LARGEST_MAP = 1 << 20  # bytes


@dataclass(frozen=True, slots=True)
class Summary:
    """One recording in a list."""

    path: Path
    id: str
    map: str
    title: str  # of a map of somebody's own, whose name says little; empty for the project's
    variant: str
    started: str  # UTC, ISO 8601
    source: str
    ticks: int
    outcome: str
    blue: str  # kind and name: "human P1"
    red: str
    study: dict[str, str]
    metrics: dict[str, float | None]  # delivered, items, and the metrics by key
    complete: bool
    damage: str  # one sentence, empty for none

    def to_json(self) -> dict[str, Any]:
        document = {name: getattr(self, name) for name in self.__slots__}  # asdict copies deeply
        return document | {"path": str(self.path), "metrics": to_numbers(self.metrics)}


def summary_from_json(document: Mapping[str, Any], path: Path) -> Summary:
    """What `Summary.to_json` wrote, of the file at `path`."""
    return Summary(**{**document, "path": path, "metrics": _metrics(document["metrics"])})


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A file that is named like a recording and cannot be read."""

    path: Path
    problem: str


def misnamed(path: Path) -> Unreadable | None:
    """A file whose name is not UTF-8 text, with that name escaped: no database, list or page takes it as it is."""
    try:
        path.name.encode()
    except UnicodeEncodeError:
        escaped = os.fsencode(path.name).decode(errors="backslashreplace")
        return Unreadable(path.with_name(escaped), f"{escaped}: its name is not UTF-8 text; rename it")
    return None


def recording_paths(folder: Path) -> list[Path]:
    """The recordings and journals in a folder, by name; RecordingError when there is no such folder."""
    try:
        names = [entry for entry in folder.iterdir() if entry.name.endswith((SUFFIX, JOURNAL_SUFFIX))]
    except OSError as error:
        raise cannot("list", folder, error) from error
    return sorted(names)


def recordings_below(folder: Path) -> list[Path]:
    """The recordings and journals in a folder and in those below it; RecordingError for one that cannot be listed."""

    def refuse(error: OSError) -> None:
        raise cannot("list", Path(error.filename), error) from error

    found = (Path(here, name) for here, _, names in os.walk(folder, onerror=refuse) for name in names)
    return sorted(path for path in found if path.name.endswith((SUFFIX, JOURNAL_SUFFIX)))


def read_summary(path: Path) -> Summary:
    """The summary of one recording; the messages of a finished one are not read (`verify` does that).

    Raises RecordingError.
    """
    if path.name.endswith(JOURNAL_SUFFIX):
        return _of_episode(path, read_episode(path))
    records = read_metadata(path)
    try:
        return _of_metadata(path, records)
    except (KeyError, ValueError) as error:
        raise RecordingError(f"{path.name}: its metadata is incomplete ({error})") from error


class Players(NamedTuple):
    """Who played an episode, and on which map."""

    episode_id: str
    seats: tuple[SeatInfo, SeatInfo]
    map: str = ""
    simulated: bool = False  # in a rehearsal of a study: its participants were programs


def read_players(path: Path) -> Players:
    """Who played, without opening the messages of a finished recording. Raises RecordingError."""
    if path.name.endswith(JOURNAL_SUFFIX):
        header = read_episode(path).header
        return Players(header.episode_id, header.seats, header.map.name, header.simulated)
    records = read_metadata(path)
    try:
        record = recorded_as(path, records)
        study = records.get(STUDY, {})
        return Players(record["episode_id"], seats_of(records), record.get("map", ""), is_simulated(study))
    except (KeyError, ValueError) as error:
        raise RecordingError(f"{path.name}: its metadata is incomplete ({error})") from error


def read_map(path: Path) -> MapSpec:
    """The map that was played, of a finished recording without its messages. Raises RecordingError."""
    try:
        with open_input(path) as stream:
            text = attachment_in(stream, MAP_FILE, LARGEST_MAP)
        return map_from_json(orjson.loads(text or b""))
    except (OSError, *UNREADABLE, MapError):
        return read_episode(path).header.map  # of a journal; of a damaged file, this says what is wrong


def is_tutorial(path: Path) -> bool:
    """Whether a recording is of a tutorial; False for what cannot be read."""
    try:
        if path.name.endswith(JOURNAL_SUFFIX):
            return read_episode(path).header.source == "tutorial"
        return episode_record(read_metadata(path)).get("source") == "tutorial"
    except RecordingError:
        return False


def read_metadata(path: Path) -> Mapping[str, Entries]:
    """All metadata records of a finished recording, by name. Raises RecordingError."""
    try:
        with open_input(path) as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise RecordingError(f"{path.name} is {'not an MCAP file' if path.stat().st_size else 'empty'}")
            return metadata_in(stream)
    except OSError as error:
        raise cannot("read", path, error) from error
    except UNREADABLE as error:
        raise RecordingError(f"{path.name} is incomplete or damaged: its index is not complete") from error


def recorded_as(path: Path, records: Mapping[str, Entries]) -> Entries:
    """The record of its episode. Raises RecordingError, naming the file, where there is none."""
    try:
        return episode_record(records)
    except RecordingError as error:
        raise RecordingError(f"{path.name}: {error}") from error


def _of_metadata(path: Path, records: Mapping[str, Entries]) -> Summary:
    episode = recorded_as(path, records)
    closing = records[RECORDING]
    return Summary(
        path=path,
        id=episode["episode_id"],
        map=episode["map"],
        title="" if is_generated_or_shipped(episode["map"]) else _title_in(path),
        variant=episode["map_variant"],
        started=episode["started_utc"],
        source=episode["source"],
        ticks=_count(closing["ticks"]),
        outcome=closing["outcome"],
        blue=seat_title(records[SEATS[0]]["kind"], records[SEATS[0]]["name"]),
        red=seat_title(records[SEATS[1]]["kind"], records[SEATS[1]]["name"]),
        study=dict(records.get(STUDY, {})),
        metrics=_metrics({name: _finite(value) for name, value in records[RESULT].items()}),
        complete=closing["complete"] == "true",
        damage=closing["damage"],
    )


def _title_in(path: Path) -> str:
    """The title of the map that a finished recording has in it; empty where it cannot be read."""
    try:
        with open_input(path) as stream:
            text = attachment_in(stream, MAP_FILE, LARGEST_MAP)
        title = orjson.loads(text or b"{}").get("title")
    except (OSError, *UNREADABLE, ValueError, AttributeError):
        return ""  # `verify` says what is wrong with it; here its name is enough
    return title if isinstance(title, str) else ""


def _count(text: str) -> int:
    """Raises ValueError for what is no number of ticks: beyond 32 bits no recording is, and JSON and SQLite end."""
    count = int(text)
    if not 0 <= count < 1 << 32:
        raise ValueError(f"{text:.40} ticks")
    return count


def _finite(text: str) -> float:
    """Raises ValueError for infinity and NaN, which JSON has no words for."""
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"a metric is {text:.40}")
    return number


def _metrics(numbers: Mapping[str, float]) -> dict[str, float | None]:
    return {"delivered": numbers["delivered"], "items": numbers["items"], **from_numbers(numbers)}


def _of_episode(path: Path, episode: Episode) -> Summary:
    header = episode.header
    blue, red = (seat_title(seat.kind, seat.name) for seat in header.seats)
    return Summary(
        path=path,
        id=header.episode_id,
        map=header.map.name,
        title="" if is_generated_or_shipped(header.map.name) else header.map.title,
        variant=header.map.variant,
        started=utc(header.started_ns),
        source=header.source,
        ticks=len(episode.ticks),
        outcome=episode.outcome,
        blue=blue,
        red=red,
        study=dict(header.study),
        metrics=result(episode),
        complete=episode.complete,
        damage=episode.damage,
    )


def seat_title(kind: str, name: str) -> str:
    """`human P1`, `agent scripted`; the name of a replayed seat says already what it is."""
    return name if name.startswith(f"{kind}:") else f"{kind} {name}"
