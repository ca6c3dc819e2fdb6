"""Which episodes in a data folder do not count for the study that they were played in.

A recording never changes once it is finished, so that a round which an experimenter marks as invalid later, and the
rounds of somebody who declines to have their data kept, are known to the database of the study alone. It lies beside
the recordings: data/recordings and data/studies/*/study.sqlite; in a backup BACKUP/recordings and BACKUP/study.sqlite.
A study in PostgreSQL has none but in its backups.
"""

import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_summary

_QUERY = """
    SELECT episode FROM rounds WHERE NOT valid OR outcome IS NULL OR outcome NOT IN ('delivered', 'time')
        OR unit IN (SELECT unit FROM participants WHERE keep = 0)
"""  # the opposite of what `movingout study export` makes a training set of


def uncounted_episodes(recordings: Iterable[Path]) -> frozenset[str]:
    """Ids of the episodes that the studies beside these recordings do not count. Raises RecordingError."""
    folders = {Path(os.path.realpath(path)).parents[1] for path in recordings}  # resolve() refuses loops
    databases = {found for folder in folders for found in folder.glob("studies/*/study.sqlite")}
    backups = {folder / "study.sqlite" for folder in folders if (folder / "manifest.json").is_file()}
    databases |= {database for database in backups if database.is_file()}
    return frozenset(episode for database in sorted(databases) for episode in _of_study(database))


def uncounted_in(folder: Path) -> frozenset[str]:
    """The same for all recordings in a folder. Raises RecordingError."""
    return uncounted_episodes([folder / f"any{SUFFIX}"])


def counted_recordings(files: Sequence[Path]) -> list[Path]:
    """Those but of episodes that a study beside them does not count; other files, and unreadable ones, stay.

    Raises RecordingError.
    """
    uncounted = uncounted_episodes(files)
    return [file for file in files if _episode(file) not in uncounted] if uncounted else list(files)


def _episode(file: Path) -> str:
    """Empty where it cannot be read: whoever reads the file says so."""
    try:
        return read_summary(file).id if file.name.endswith((SUFFIX, JOURNAL_SUFFIX)) else ""
    except RecordingError:
        return ""


def _of_study(database: Path) -> Iterator[str]:
    try:
        with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as connection:
            yield from (str(episode) for (episode,) in connection.execute(_QUERY))
    except sqlite3.Error as error:
        raise RecordingError(
            f"cannot read {database}, which says which rounds count ({error}); copy the recordings elsewhere to use "
            "them all"
        ) from error
