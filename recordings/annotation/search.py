"""Looks for failure cases in a folder of recordings. What was found is kept beside them."""

import hashlib
import os
import sqlite3
import time
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import orjson

from movingout.maps.files.ownership import make_file
from movingout.recordings.annotation.finding import Finding, SearchedRecording, SearchedSeat
from movingout.recordings.episode import FINISHED
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.play_hash import play_hash
from movingout.recordings.progress import with_progress
from movingout.recordings.report.failures import failures
from movingout.recordings.report.method import rules
from movingout.recordings.report.track import Track
from movingout.recordings.report.words import Words
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.index import Stamp, file_stamp
from movingout.recordings.storage.listing import misnamed
from movingout.world.metrics import EpisodeMetrics

SEARCH_NAME = ".findings.sqlite"
_TABLE = "CREATE TABLE IF NOT EXISTS searched (name TEXT PRIMARY KEY, size INTEGER, changed_ns INTEGER, found TEXT)"
_KEPT = sorted(SearchedRecording.__slots__)
_RULES = int(
    hashlib.sha256(repr((_KEPT, rules(Words()))).encode()).hexdigest()[:7], 16
)  # other rules find other things


@dataclass(frozen=True, slots=True)
class FailureSearch:
    """What was found so far."""

    recordings: list[SearchedRecording]  # finished ones, by file name
    left_out: int  # unfinished, tutorials, unreadable
    remaining: int  # recordings that were not searched for want of time
    copies: int = 0  # of recordings that are among them


def search_failures(folder: Path, most_s: float | None = None) -> FailureSearch:
    """Search new and changed recordings of a folder for about `most_s` seconds, and tell all that is known.

    Raises RecordingError when there is no such folder.
    """
    files, nameless = _files(folder)
    with suppress(OSError):  # an unwritable folder
        make_file(folder / SEARCH_NAME)
    try:
        found = _search(folder / SEARCH_NAME, folder, files, most_s)
    except sqlite3.DatabaseError as error:  # an unwritable folder, a locked or broken file: recordings are the truth
        if not isinstance(error, sqlite3.OperationalError):
            (folder / SEARCH_NAME).unlink(missing_ok=True)
        found = _search(":memory:", folder, files, None)
    return replace(found, left_out=found.left_out + nameless)


def _search(where: Path | str, folder: Path, files: dict[str, Stamp], most_s: float | None) -> FailureSearch:
    with closing(sqlite3.connect(where, timeout=5.0)) as database, database:
        _prepare(database)
        known = {
            name: (size, changed)
            for name, size, changed in database.execute("SELECT name, size, changed_ns FROM searched")
        }
        database.executemany("DELETE FROM searched WHERE name = ?", ((name,) for name in known.keys() - files.keys()))
        fresh = [name for name, stamp in files.items() if known.get(name) != stamp]
        ends = None if most_s is None else time.monotonic() + most_s
        done = 0
        for name in with_progress(fresh, len(fresh), "searching"):
            if ends is not None and time.monotonic() > ends:
                break
            found = _searched(folder / name)
            text = orjson.dumps(found.to_json()).decode() if found else ""
            database.execute("INSERT OR REPLACE INTO searched VALUES (?, ?, ?, ?)", (name, *files[name], text))
            done += 1
        rows = [text for (text,) in database.execute("SELECT found FROM searched ORDER BY name")]
        found_in = [SearchedRecording.from_json(orjson.loads(text)) for text in rows if text]
        recordings = list({one.id: one for one in reversed(found_in)}.values())[::-1]  # the first of each episode
        copies = len(found_in) - len(recordings)
        return FailureSearch(recordings, len(rows) - len(found_in), len(fresh) - done, copies)


def _prepare(database: sqlite3.Connection) -> None:
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if version != _RULES:
        database.execute("DROP TABLE IF EXISTS searched")
        database.execute(f"PRAGMA user_version = {_RULES}")
    database.execute(_TABLE)


def _searched(path: Path) -> SearchedRecording | None:
    """What the rules find in a recording; None for one that is left out of every analysis."""
    try:
        episode = read_episode(path)
    except RecordingError:
        return None
    header = episode.header
    if header.source == "tutorial" or not (episode.complete and episode.outcome in FINISHED):
        return None
    blue, red = (SearchedSeat(seat.kind, seat.name) for seat in header.seats)
    study = header.study.get("study", "")
    found = tuple(Finding.of(header.episode_id, failure) for failure in failures(Track.of(episode)))
    metrics = EpisodeMetrics(header.map)
    metrics.update_episode(list(episode.states), episode.actions)
    return SearchedRecording(
        header.episode_id, header.map.name, study, (blue, red), found,
        waiting_share=metrics.waiting_share, official_ac=metrics.official_ac, played=play_hash(episode),
        simulated=header.simulated,
        agent_errors=tuple(event.detail for event in episode.events if event.kind == "agent_error"),
    )  # fmt: skip


def _files(folder: Path) -> tuple[dict[str, Stamp], int]:
    """The recordings with their stamps, and how many more have names that no database takes."""
    found: dict[str, Stamp] = {}
    nameless = 0
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name.endswith(SUFFIX) and misnamed(folder / entry.name):
                    nameless += 1
                elif entry.name.endswith(SUFFIX):
                    with suppress(FileNotFoundError):  # deleted meanwhile
                        found[entry.name] = file_stamp(entry)
    except OSError as error:
        raise cannot("list", folder, error) from error
    return dict(sorted(found.items())), nameless
