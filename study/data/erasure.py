"""Deletes a participant, on request or at the end of retention: recordings, identity, then the rows."""

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from movingout.recordings.annotation.search import SEARCH_NAME
from movingout.recordings.annotation.verdicts import VERDICTS_NAME, forget_recordings
from movingout.recordings.errors import RecordingError
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.index import INDEX_NAME, list_recordings
from movingout.recordings.storage.listing import Summary
from movingout.recordings.storage.s3_bucket import delete_copies
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.errors import StudyError
from movingout.study.store.removal import episodes_of, remove_participant, resolve_participant
from movingout.study.store.store import Participant, Store
from movingout.study.store.tables import consents

DAY_MS = 86_400_000
_DAYS = {"d": 1, "y": 365}


@dataclass(frozen=True, slots=True)
class Erased:
    """What was removed."""

    pid: str
    rows: int
    recordings: int
    identity: bool


@dataclass(frozen=True, slots=True)
class DueForErasure:
    """Participants past the retention period."""

    identities: tuple[str, ...]  # only their identity
    trials: tuple[str, ...]  # everything


def erase(folder: StudyFolder, store: Store, name: str) -> Erased:
    """Delete a participant, named by pseudonym or completion code.

    If this is interrupted, run it again: the row in the store is deleted last.
    """
    pid = resolve_participant(store, name)
    removed = remove_recordings(folder.recordings, pid, set(episodes_of(store, pid)))
    remove_rooms(folder, pid)
    with closing(folder.open_identities()) as identities:
        known = identities.forget(pid) > 0
    return Erased(pid, remove_participant(store, pid, removed), removed, known)


def due_for_erasure(study: Study, store: Store) -> DueForErasure:
    """Who is past the retention period; it starts at arrival for participants who have not finished."""
    now = store.now()
    released = {row["pid"] for row in store.rows(consents) if '"release"' in row["boxes"]}
    identities, trials = [], []
    for one in store.everybody():
        keep = study.retention.released if one.pid in released else study.retention.trials
        if _expired(one, keep, now):
            trials.append(one.pid)
        elif _expired(one, study.retention.identity, now):
            identities.append(one.pid)
    return DueForErasure(tuple(identities), tuple(trials))


def purge(folder: StudyFolder, store: Store) -> DueForErasure:
    """Remove what is due; returns what was removed."""
    found = due_for_erasure(folder.study, store)
    with closing(folder.open_identities()) as identities:
        gone = tuple(pid for pid in found.identities if identities.forget(pid))
    for pid in found.trials:
        erase(folder, store, pid)
    store.audit("experimenter", "purge", identities=len(gone), participants=len(found.trials))
    return DueForErasure(gone, found.trials)


def _expired(one: Participant, keep: str, now: int) -> bool:
    if keep == "forever":
        return False
    since = one.finished_ms if one.finished_ms is not None else one.arrived_ms
    return now - since > int(keep[:-1]) * _DAYS[keep[-1]] * DAY_MS


def remove_recordings(folder: Path, pid: str, episodes: set[str]) -> int:
    """Delete the recordings of these rounds, and all others that name the participant (practice, unfinished games)."""
    if not folder.is_dir():
        return 0
    try:
        found, _ = list_recordings(folder)
    except RecordingError as error:
        raise StudyError(str(error)) from error
    paths = {one.path for one in found if one.id in episodes or _names(pid, one)}
    readable = {one.path for one in found}
    try:
        rest = {path for path in folder.iterdir() if path.is_file() and path not in readable}
        kept = (INDEX_NAME, SEARCH_NAME, VERDICTS_NAME)
        paths |= {path for path in rest if path.name not in kept and pid.encode() in path.read_bytes()}  # damaged ones
        delete_copies(folder.parent, [path.name for path in paths if path.suffix == SUFFIX])
        forget_recordings(folder, {path.name.partition(".")[0] for path in paths})
        for path in paths:
            path.unlink()
        (folder / SEARCH_NAME).unlink(missing_ok=True)  # who sat where; it is made again from the files
        (folder / INDEX_NAME).unlink(missing_ok=True)  # it names the participant; it is rebuilt from the files
    except RecordingError as error:
        raise StudyError(f"nothing is deleted yet, because copies are elsewhere: {error}") from None
    except OSError as error:
        raise StudyError(f"cannot delete {error.filename}: {error.strerror or error}") from None
    return len(paths)


def remove_rooms(folder: StudyFolder, pid: str) -> None:
    """Delete the saved rooms of a stopped server that name the participant, and what was answered in them."""
    try:
        # those of a cluster are in a folder per shard; *.tmp are left after a crash
        for path in [*folder.rooms.rglob("*.json"), *folder.rooms.rglob("*.tmp")]:
            if pid.encode() in path.read_bytes():
                path.unlink()
                for answers in (folder.data / "answers").glob(f"{path.stem}-*.jsonl"):
                    answers.unlink()
    except OSError as error:
        raise StudyError(f"cannot delete {error.filename}: {error.strerror or error}") from None


def _names(pid: str, recording: Summary) -> bool:
    seats = (seat.partition(" ")[2] for seat in (recording.blue, recording.red))
    return pid in (*seats, *recording.study.values())
