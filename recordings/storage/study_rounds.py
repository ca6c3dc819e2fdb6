"""Which episodes in a data folder do not count for the study that they were played in.

A recording never changes once it is finished, so that a round which an experimenter marks as invalid later, and the
rounds of somebody who declines to have their data kept, are known to the database of the study alone. It lies beside
the recordings: data/recordings and data/studies/*/study.sqlite; in a backup BACKUP/recordings and BACKUP/study.sqlite.
A study in PostgreSQL has none but in its backups.

What was exported of such an episode, and imported, does not count either: it equals a recording that is left out.
"""

import os
import re
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.copies import imports_of
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.listing import read_summary

_EPISODE_ID = re.compile("[a-km-np-z2-9]{20}")  # as rooms make them (`server/security/tokens.py`)
_QUERY = """
    SELECT episode FROM rounds WHERE NOT valid OR outcome IS NULL OR outcome NOT IN ('delivered', 'time')
        OR unit IN (SELECT unit FROM participants WHERE keep = 0)
"""  # the opposite of what `movingout study export` makes a training set of


def uncounted_episodes(recordings: Iterable[Path]) -> frozenset[str]:
    """Ids of the episodes that the studies beside these recordings do not count. Raises RecordingError."""
    folders = _data_folders(recordings)
    databases = {found for folder in folders for found in folder.glob("studies/*/study.sqlite")}
    backups = {folder / "study.sqlite" for folder in folders if (folder / "manifest.json").is_file()}
    databases |= {database for database in backups if database.is_file()}
    return frozenset(episode for database in sorted(databases) for episode in _of_study(database))


def uncounted_in(folder: Path) -> frozenset[str]:
    """The same for all recordings in a folder. Raises RecordingError."""
    return uncounted_episodes([folder / f"any{SUFFIX}"])


def counted_recordings(files: Sequence[Path]) -> list[Path]:
    """Those but of episodes that a study beside them does not count, and imports of these; other files, and unreadable
    ones, stay.

    Of an import that is named alone, the recording is looked for beside the study. Raises RecordingError.
    """
    uncounted = uncounted_episodes(files)
    if not uncounted:
        return list(files)
    about = {file: _about(file) for file in files}
    left_out = {file for file, (episode, _) in about.items() if episode in uncounted}
    if imports := [file for file, (_, source) in about.items() if source == "import"]:
        beside = [file for folder in sorted(_data_folders(files)) for file in _recordings_of(uncounted, folder)]
        left_out |= imports_of([*left_out, *beside], imports)
    return [file for file in files if file not in left_out]


def _recordings_of(episodes: frozenset[str], data: Path) -> list[Path]:
    """Of these episodes beside their study; where one has no file of its name, files that were renamed are read for it.

    Most often it has none at all: it was purged, or never began.
    """
    files = {file.name.removesuffix(SUFFIX): file for file in sorted((data / "recordings").glob(f"*{SUFFIX}"))}
    found = [file for name, file in files.items() if name in episodes]
    if not episodes <= files.keys():
        renamed = [file for name, file in files.items() if name not in episodes and not _EPISODE_ID.fullmatch(name)]
        found += [file for file in renamed if _about(file)[0] in episodes]
    return found


def _data_folders(files: Iterable[Path]) -> set[Path]:
    """Where databases of studies may lie: above the folders of these files."""
    return {Path(os.path.realpath(path)).parents[1] for path in files}  # resolve() refuses loops


def _about(file: Path) -> tuple[str, str]:
    """Episode and source; empty where it cannot be read: whoever reads the file says so."""
    if not file.name.endswith((SUFFIX, JOURNAL_SUFFIX)):
        return "", ""
    try:
        summary = read_summary(file)
    except RecordingError:
        return "", ""
    return summary.id, summary.source


def _of_study(database: Path) -> Iterator[str]:
    try:
        with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as connection:
            yield from (str(episode) for (episode,) in connection.execute(_QUERY))
    except sqlite3.Error as error:
        raise RecordingError(
            f"cannot read {database}, which says which rounds count ({error}); copy the recordings elsewhere to use "
            "them all"
        ) from error
