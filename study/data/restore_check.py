"""Whether a backup can be restored: it is, into a temporary folder that nobody keeps, and read there."""

import tempfile
from contextlib import closing
from pathlib import Path

from movingout.recordings.storage.index import list_recordings
from movingout.study.data.backup import IDENTITY, MAIN, STUDY_FILE, BackedUp, restore
from movingout.study.design.study_file import parse_study, plain_text
from movingout.study.errors import StudyError
from movingout.study.store.frozen_study import frozen_study
from movingout.study.store.identity import IdentityStore
from movingout.study.store.store import Store


def check_backup(backup: Path) -> BackedUp:
    """Raises StudyError for a backup of which something is damaged, missing or cannot be read."""
    try:
        with tempfile.TemporaryDirectory(prefix="movingout-restore-") as folder:  # readable for the owner alone
            data = Path(folder)
            done = restore(backup, data)
            _read_databases(data / "studies" / done.study, done)
            _read_study(backup)
            _, unreadable = list_recordings(data / "recordings")
    except OSError as error:
        raise StudyError(
            f"cannot restore into a temporary folder: {error.strerror or error}; TMPDIR names one"
        ) from None
    if unreadable:
        names = ", ".join(one.path.name for one in unreadable[:5])
        raise StudyError(f"the backup {backup} has recordings that cannot be read: {names}")
    return done


def _read_study(backup: Path) -> None:
    """A report needs it, with its maps beside it."""
    try:
        text = (backup / STUDY_FILE).read_text(encoding="utf-8")
        parse_study(plain_text(text), STUDY_FILE, backup, begun=True)
    except (OSError, ValueError, StudyError) as error:
        raise StudyError(f"the study file in the backup {backup} cannot be read: {error}") from None


def _read_databases(own: Path, done: BackedUp) -> None:
    with closing(Store(own / MAIN)) as store:
        store.everybody()
        if frozen_study(store).id != done.study:
            raise StudyError(f"the database of the backup holds the study {frozen_study(store).id}, not {done.study}")
    if done.identities:
        with closing(IdentityStore(own / IDENTITY)) as identities:
            identities.everybody()
