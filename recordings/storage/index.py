"""An index of a folder of recordings, so that ten thousand are listed without delay.

It lies beside the recordings, is made from them alone, and can be deleted without loss: every call notices files that
are new, changed or gone (name, size, time of change). Journals are few and change all the time: they are read directly.
"""

import os
import sqlite3
import time
from collections.abc import Iterable
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import orjson

from movingout.maps.files.ownership import make_file
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.file_format.metadata import EPISODE_ID
from movingout.recordings.progress import with_progress
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import Summary, Unreadable, misnamed, read_summary, summary_from_json

INDEX_NAME = ".index.sqlite"
_VERSION = 2  # of this table; another one is rebuilt
_TABLE = """
CREATE TABLE IF NOT EXISTS recordings (
    name TEXT PRIMARY KEY, size INTEGER, changed_ns INTEGER, problem TEXT, summary TEXT,
    map TEXT, started TEXT, outcome TEXT, blue TEXT, red TEXT, study TEXT
)
"""

_TELLS_NS = 1_000_000_000  # older times of change tell whether there was one more; two in a few ms may have the same

Stamp = tuple[int, int]  # size, time of change in ns


@dataclass(frozen=True, slots=True)
class Filter:
    """Which recordings are wanted; None is any."""

    map: str | None = None  # its name or title
    agent: str | None = None  # part of the name of either seat
    study: str | None = None  # one of the study's ids
    since: str | None = None  # first day, 2026-11-20
    until: str | None = None  # last day
    outcome: str | None = None

    def condition(self) -> tuple[str, list[str]]:
        """The SQL condition with its parameters."""
        terms = [
            ("? IN (map, json_extract(summary, '$.title'))", self.map),
            ("instr(blue || char(10) || red, ?) > 0", self.agent),
            ("EXISTS (SELECT 1 FROM json_each(study) WHERE value = ?)", self.study),
            ("substr(started, 1, 10) >= ?", self.since),
            ("substr(started, 1, 10) <= ?", self.until),
            ("outcome = ?", self.outcome),
        ]
        used = [(text, value) for text, value in terms if value is not None]
        return " AND ".join(["summary != ''", *(text for text, _ in used)]), [value for _, value in used]


def list_recordings(
    folder: Path, wanted: Filter | None = None, *, running: bool = True
) -> tuple[list[Summary], list[Unreadable]]:
    """The wanted recordings of a folder, newest first, and the files in it that cannot be read.

    Journals are read as far as they go, unless `running` is False. Raises RecordingError for a folder that cannot
    be read.
    """
    files, journals, nameless = _files(folder)
    if not running:
        journals = []
    with suppress(OSError):  # an unwritable folder
        make_file(folder / INDEX_NAME)
    try:
        found, unreadable = _look(folder / INDEX_NAME, folder, files, journals, wanted or Filter())
    except sqlite3.DatabaseError as error:  # an unwritable folder, a locked or broken index: the files are the truth
        if not isinstance(error, sqlite3.OperationalError):
            _discard(folder / INDEX_NAME)
        found, unreadable = _look(":memory:", folder, files, journals, wanted or Filter())
    return found, unreadable + nameless


def path_of(folder: Path, episode_id: str) -> Path:
    """The file of an episode id in a folder, finished or journal, whatever it is called.

    RecordingError for anything else, `../` included.
    """
    if EPISODE_ID.fullmatch(episode_id):
        for suffix in (SUFFIX, JOURNAL_SUFFIX):
            path = folder / f"{episode_id}{suffix}"
            if path.is_file():
                return path
        if renamed := renamed_file(folder, episode_id):
            return renamed
    raise RecordingError(f"there is no recording {episode_id!r} in {folder}; `movingout recordings list` names them")


def renamed_file(folder: Path, episode_id: str, *, running: bool = True) -> Path | None:
    """The file of an episode that is not called after it, as a copy under a name of somebody's own."""
    try:
        changed_ns = folder.stat().st_mtime_ns
        if time.time_ns() - changed_ns < _TELLS_NS:
            _renamed_files.cache_clear()
        found = _renamed_files(folder, changed_ns, running)
    except (OSError, RecordingError):
        return None
    return found.get(episode_id)


@lru_cache(4)
def _renamed_files(folder: Path, changed_ns: int, running: bool) -> dict[str, Path]:
    """By episode id. A folder changes when a file in it comes, goes or gets another name."""
    found: dict[str, Path] = {}
    for entry in list_recordings(folder, running=running)[0]:
        if entry.path.name not in (f"{entry.id}{SUFFIX}", f"{entry.id}{JOURNAL_SUFFIX}"):
            found.setdefault(entry.id, entry.path)
    return found


def _look(
    where: Path | str, folder: Path, files: dict[str, Stamp], journals: list[str], wanted: Filter
) -> tuple[list[Summary], list[Unreadable]]:
    with closing(sqlite3.connect(where, timeout=5.0)) as database, database:
        _prepare(database)
        _refresh(database, folder, files)
        database.execute("CREATE TEMP TABLE journals AS SELECT * FROM recordings LIMIT 0")
        database.executemany(_insert("journals"), (_row(folder / name, (0, 0)) for name in journals))
        database.execute(
            "CREATE TEMP VIEW everything AS SELECT * FROM main.recordings UNION ALL SELECT * FROM journals"
        )
        condition, values = wanted.condition()
        query = f"SELECT name, summary FROM everything WHERE {condition} ORDER BY started DESC, name"
        summaries = [
            summary_from_json(orjson.loads(text), folder / name) for name, text in database.execute(query, values)
        ]
        problems = database.execute("SELECT name, problem FROM everything WHERE summary = '' ORDER BY name")
        return summaries, [Unreadable(folder / name, problem) for name, problem in problems]


def _files(folder: Path) -> tuple[dict[str, Stamp], list[str], list[Unreadable]]:
    """The recordings with their stamps, the journals, and those among both whose names nothing else takes."""
    files: dict[str, Stamp] = {}
    journals: list[str] = []
    nameless: list[Unreadable] = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name.endswith((SUFFIX, JOURNAL_SUFFIX)) and (bad := misnamed(folder / entry.name)):
                    nameless.append(bad)
                elif entry.name.endswith(SUFFIX):
                    with suppress(FileNotFoundError):  # deleted meanwhile
                        files[entry.name] = file_stamp(entry)
                elif entry.name.endswith(JOURNAL_SUFFIX):
                    journals.append(entry.name)
    except OSError as error:
        raise cannot("list", folder, error) from error
    return files, journals, nameless


def file_stamp(entry: os.DirEntry[str]) -> Stamp:
    """Of a link that leads nowhere, the link's own: it counts among the files that cannot be read.

    Raises FileNotFoundError for a file that was deleted meanwhile.
    """
    try:
        found = entry.stat()
    except OSError:
        found = entry.stat(follow_symlinks=False)
    return found.st_size, found.st_mtime_ns


def _prepare(database: sqlite3.Connection) -> None:
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if version != _VERSION:
        database.execute("DROP TABLE IF EXISTS recordings")
        database.execute(f"PRAGMA user_version = {_VERSION}")
    database.execute(_TABLE)


def _refresh(database: sqlite3.Connection, folder: Path, files: dict[str, Stamp]) -> None:
    known = {name: (size, changed) for name, size, changed in _stamps(database)}
    gone = known.keys() - files.keys()
    database.executemany("DELETE FROM recordings WHERE name = ?", ((name,) for name in gone))
    fresh = [(folder / name, stamp) for name, stamp in files.items() if known.get(name) != stamp]
    rows = (_row(path, stamp) for path, stamp in with_progress(fresh, len(fresh), "indexing"))
    database.executemany(_insert("recordings"), rows)


def _stamps(database: sqlite3.Connection) -> Iterable[tuple[str, int, int]]:
    return database.execute("SELECT name, size, changed_ns FROM recordings")


def _insert(table: str) -> str:
    return f"INSERT OR REPLACE INTO {table} VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"


def _row(path: Path, stamp: Stamp) -> tuple[str | int, ...]:
    try:
        entry = read_summary(path)
    except RecordingError as error:
        problem = str(error).encode(errors="backslashreplace").decode()  # it may name a folder that is not UTF-8
        return (path.name, *stamp, problem, "", "", "", "", "", "", "{}")
    text = orjson.dumps(entry.to_json() | {"path": path.name}).decode()
    study = orjson.dumps(entry.study).decode()
    return (
        *(path.name, *stamp, "", text),
        *(entry.map, entry.started, entry.outcome, entry.blue, entry.red, study),
    )


def _discard(index: Path) -> None:
    try:
        index.unlink(missing_ok=True)
    except OSError:
        return  # a read-only folder keeps its index; this look does without
