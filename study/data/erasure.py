"""Deletes a participant, on request or at the end of retention: recordings, identity, then the rows."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from movingout.recordings.annotation.search import SEARCH_NAME
from movingout.recordings.annotation.verdicts import VERDICTS_NAME, forget_recordings
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.finished import SUFFIX
from movingout.recordings.storage.index import INDEX_NAME, list_recordings
from movingout.recordings.storage.listing import Summary
from movingout.recordings.storage.s3_bucket import delete_copies
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.design.sections.retention import period_days
from movingout.study.errors import StudyError
from movingout.study.store.database import shown
from movingout.study.store.identity import CODE, IdentityStore, Leftover
from movingout.study.store.removal import (
    UNDECIDED_S,
    called,
    drop_undecided,
    episodes_of,
    remove_participant,
    undecided,
)
from movingout.study.store.store import Participant, Store, planned_done
from movingout.study.store.tables import consents

DAY_MS = 86_400_000
PART_SUFFIX = ".tmp"  # of a recording that is being written
HEAD_BYTES = 65536  # of a journal, which begins with who plays
LOOKS = 10  # at a folder in which files change their names


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

    identities: tuple[str, ...]  # only their identity, or a code that nobody has consented with
    trials: tuple[str, ...]  # everything
    may_return: int = 0  # how many of these can take part again, as somebody new, because the study still recruits
    undecided: tuple[str, ...] = ()  # who never consented, and left while no server forgot them, or not wholly


def erase(folder: StudyFolder, store: Store, name: str) -> Erased:
    """Delete a participant, named by pseudonym, completion code or the id that a platform knows them by.

    If this is interrupted, run it again, at best with the pseudonym: the row in the store is deleted last. Raises
    StudyError.
    """
    return _erase(folder, store, _named(folder, store, name))


def _erase(folder: StudyFolder, store: Store, pid: str, expired: bool = False) -> Erased:
    """By pseudonym alone: what a link said a participant's ID is may be somebody else's pseudonym."""
    removed = remove_recordings(folder.recordings, pid, set(episodes_of(store, pid)))
    remove_rooms(folder, pid)
    with folder.existing_identities() as identities:
        known = identities is not None and identities.forget(pid) > 0
    return Erased(pid, remove_participant(store, pid, removed, expired), removed, known)


def _named(folder: StudyFolder, store: Store, name: str) -> str:
    """The pseudonym. Raises StudyError unless there is exactly one, and for a code that several may have."""
    if folder.study.shares(name):
        also = "name the participant by pseudonym, or by the ID on the platform; payments.csv has both"
        raise StudyError(f"{name!r} is the code of all who end alike, as `codes` says; {also}")
    with folder.existing_identities() as identities:
        known = identities.pids(name) if identities else []
    found = sorted({*known, *called(store, name)})
    if len(found) > 1:
        raise StudyError(
            f"{name!r} is the pseudonym, code or ID of {len(found)} participants ({', '.join(found)}); name one by "
            "what no other has: payments.csv says which is whose"
        )
    return store.participant(found[0] if found else name).pid


def _due(study: Study, store: Store, kept: IdentityStore | None, *, unknown_too: bool) -> DueForErasure:
    """Who is past the retention period; for participants who have not finished it starts when they were last seen.

    Identities are due of those who are still `kept`. Raises StudyError.
    """
    now = store.now()
    known = kept.everybody() if kept else {}
    released = {row["pid"] for row in store.rows(consents) if '"release"' in row["boxes"]}
    identities, trials, visitors = list[str](), list[str](), list[str]()
    waiting, everybody = undecided(store), store.everybody()
    for one in everybody:
        if one.pid in waiting:
            visitors += [one.pid] if now - _last_heard(one) > 1e3 * UNDECIDED_S else []
            continue
        keep = study.retention.released if one.pid in released else study.retention.trials
        if _expired(one, keep, now):
            trials.append(one.pid)
        elif one.pid in known and _expired(one, study.retention.identity, now):
            identities.append(one.pid)
    taking_part = {one.pid for one in everybody}
    leftovers = kept.without(taking_part - {*visitors}) if kept else []
    if not unknown_too:
        _refuse_older(study, store, unknown_to(store, kept) if kept else [])
    codes, gone = _left_over(study, leftovers, now)
    recruits = _is_recruiting(study, store)
    identities += [] if recruits else codes  # one that was handed out long ago stays good
    visitors += [pid for pid in gone if pid not in visitors]
    returning = [pid for pid in (*identities, *trials) if pid in known and known[pid][0] != CODE]
    may_return = len(returning) if recruits else 0
    return DueForErasure(tuple(identities), tuple(trials), may_return, tuple(visitors))


def unknown_to(store: Store, kept: IdentityStore) -> list[Leftover]:
    """Identities of people who have come and whom the main database does not know, as an older one that was put back.

    Everybody is written down there before they get a page, and deleted there after their identity.
    """
    used = [one for one in kept.without(()) if one.used]  # first: who arrives meanwhile is no sign of it
    known = {one.pid for one in store.everybody()}
    unknown = [one for one in used if one.pid not in known]
    there = {one.pid for one in kept.without(known) if one.used} if unknown else set()
    return [one for one in unknown if one.pid in there]  # nor is who declined meanwhile


def _refuse_older(study: Study, store: Store, unknown: Sequence[Leftover]) -> None:
    """Raises StudyError if there are any."""
    if unknown:
        raise StudyError(
            f"{len(unknown)} of the identities are of people who opened the study, but {shown(store.database.address)} "
            f"of study {study.id} does not know them: it is older than the identities, as where a copy of before was "
            "put back. Nothing was removed. Bring the newest one back, or a whole backup into a new folder (movingout "
            "study restore). If there is no newer one, or only a server of an earlier version was killed, add --unknown"
        )


def _left_over(study: Study, leftovers: Iterable[Leftover], now: int) -> tuple[list[str], list[str]]:
    """Of the identities of nobody who takes part: codes past the retention of identities, and visitors who have gone.

    Such visitors have no row any more, where a kill came between the two databases. A code that nobody has consented
    with is kept as long as an identity.
    """
    codes, visitors = list[str](), list[str]()
    for one in leftovers:
        age_ms = now - one.at_ms
        if one.source == CODE and age_ms > period_days(study.retention.identity) * DAY_MS:
            codes.append(one.pid)
        elif (one.source != CODE or one.used) and age_ms > 1e3 * UNDECIDED_S:
            visitors.append(one.pid)
    return codes, visitors


def _is_recruiting(study: Study, store: Store) -> bool:
    """Whether a server would still let somebody in, now or once somebody on their way has left."""
    unwanted = {one.unit for one in store.everybody() if one.keep is False}
    done = [one for one in store.done_units() if one.id not in unwanted]
    return planned_done(done, study.units, study.group) < study.units


def due_now(folder: StudyFolder, store: Store, *, unknown_too: bool = False) -> DueForErasure:
    """What `purge` would remove. Raises StudyError."""
    with folder.existing_identities() as identities:
        return _due(folder.study, store, identities, unknown_too=unknown_too)


def purge(folder: StudyFolder, store: Store, *, unknown_too: bool = False) -> DueForErasure:
    """Remove what is due, also from the files where that was interrupted before; returns what was removed.

    Raises StudyError where identities are of people whom the main database does not know, unless `unknown_too`.
    """
    with folder.existing_identities() as identities:
        found = _due(folder.study, store, identities, unknown_too=unknown_too)
        gone = tuple(pid for pid in found.identities if identities and identities.forget(pid))
        if identities:
            identities.drop_visitors(found.undecided)
            identities.database.scrub_rest()
    drop_undecided(store, found.undecided)
    for pid in found.trials:
        _erase(folder, store, pid, expired=True)
    store.database.scrub_rest()
    store.audit("experimenter", "purge", identities=len(gone), participants=len(found.trials))
    return replace(found, identities=gone)


def _expired(one: Participant, keep: str, now: int) -> bool:
    since = one.finished_ms if one.finished_ms is not None else _last_heard(one)
    return now - since > period_days(keep) * DAY_MS


def _last_heard(one: Participant) -> int:
    return max(one.arrived_ms, one.heard_ms or 0)


def remove_recordings(folder: Path, pid: str, episodes: Collection[str]) -> int:
    """Delete the recordings of these rounds, and all others that name the participant (practice, unfinished games).

    Raises StudyError.
    """
    return remove_recordings_of(folder, {pid: episodes})[pid]


def remove_recordings_of(folder: Path, whose: Mapping[str, Collection[str]]) -> dict[str, int]:
    """The same for several participants with their rounds. A recording of two counts for one of them.

    Raises StudyError.
    """
    removed: dict[Path, str] = {}
    for _ in range(LOOKS):
        if not folder.is_dir():
            break
        paths, missed = _files_of(folder, whose)
        _remove(folder, set(paths))
        removed |= paths
        if not missed:
            break
    counted = Counter({_episode(path): pid for path, pid in removed.items()}.values())
    return {pid: counted[pid] for pid in whose}


def being_recorded(folder: Path, whose: Mapping[str, Collection[str]]) -> set[str]:
    """The participants, by pseudonym, whose recording may still be being written: of these rounds, or naming them."""
    try:
        paths = [path for path in folder.iterdir() if path.name.endswith((JOURNAL_SUFFIX, PART_SUFFIX))]
    except OSError:
        return set()
    wanted = _Wanted(whose)
    return {pid for path in paths for pid in wanted.in_bytes(_episode(path), _bytes(path, HEAD_BYTES))}


class _Wanted:
    """Whose recordings are looked for, by pseudonym and by round."""

    def __init__(self, whose: Mapping[str, Collection[str]]) -> None:
        self._pids = [*whose]
        self._by_word: dict[str, str] = {}
        for pid, episodes in whose.items():
            self._by_word.setdefault(pid, pid)
            for episode in episodes:
                self._by_word.setdefault(episode, pid)

    def in_summary(self, one: Summary) -> str | None:
        """Which of them this recording belongs to; None if it belongs to none."""
        seats = (seat.partition(" ")[2] for seat in (one.blue, one.red))
        words = (one.id, *seats, *one.study.values())
        return next((self._by_word[word] for word in words if word in self._by_word), None)

    def in_bytes(self, episode: str, content: bytes) -> set[str]:
        """Which of them a file belongs to, by the `episode` in its name or by whom it names."""
        named = {pid for pid in self._pids if pid.encode() in content}
        return named | ({self._by_word[episode]} if episode in self._by_word else set())


def _files_of(folder: Path, whose: Mapping[str, Collection[str]]) -> tuple[dict[Path, str], bool]:
    """The files to delete, each with one participant it belongs to, and whether a file was renamed meanwhile.

    A server may be finishing recordings.
    """
    wanted = _Wanted(whose)
    found, rest = _listed(folder)
    paths = {one.path: pid for one in found if (pid := wanted.in_summary(one))}
    for path in rest:
        if pids := wanted.in_bytes(_episode(path), _content(path)):
            paths[path] = min(pids)
    return paths, not all(path.exists() for path in (*rest, *paths))


def _listed(folder: Path) -> tuple[list[Summary], set[Path]]:
    """The readable recordings, and the other files: journals, damaged ones, and parts of some that are being written.

    Journals of rounds that are played now are long, and not read as a whole.
    """
    kept = (INDEX_NAME, SEARCH_NAME, VERDICTS_NAME)
    try:
        found, _ = list_recordings(folder, running=False)
        readable = {one.path for one in found}
        rest = {path for path in folder.iterdir() if path.name not in kept and path not in readable and path.is_file()}
    except RecordingError as error:
        raise StudyError(str(error)) from error
    except OSError as error:
        raise StudyError(f"cannot list {folder}: {error.strerror or error}") from None
    return found, rest


def _content(path: Path) -> bytes:
    """The part of a file that may say whom it belongs to: all of it, or the beginning of a journal."""
    return _bytes(path, HEAD_BYTES if path.name.endswith(JOURNAL_SUFFIX) else -1)


def _bytes(path: Path, most: int = -1) -> bytes:
    """The first bytes of a file; empty if the file is gone by now."""
    try:
        with path.open("rb") as stream:
            return stream.read(most)
    except FileNotFoundError:
        return b""
    except OSError as error:
        raise StudyError(f"cannot read {path}: {error.strerror or error}") from None


def _episode(path: Path) -> str:
    return path.name.partition(".")[0]


def _remove(folder: Path, paths: set[Path]) -> None:
    if not paths:
        return
    try:
        delete_copies(folder.parent, [path.name for path in paths if path.suffix == SUFFIX])
        forget_recordings(folder, {_episode(path) for path in paths})
        _remove_summaries(folder)  # first: once the recordings are gone, nobody would look here again
        for path in paths:
            path.unlink(missing_ok=True)
        forget_recordings(folder, {_episode(path) for path in paths})  # what was said meanwhile
        _remove_summaries(folder)  # a server may have made them again meanwhile
    except RecordingError as error:
        raise StudyError(f"nothing is deleted yet, because copies are elsewhere: {error}") from None
    except OSError as error:
        raise StudyError(f"cannot delete {error.filename}: {error.strerror or error}") from None


def _remove_summaries(folder: Path) -> None:
    """Delete the summaries, which say who sat where; they are made again from the recordings."""
    for name in (SEARCH_NAME, INDEX_NAME):
        (folder / name).unlink(missing_ok=True)


def remove_rooms(folder: StudyFolder, pid: str) -> None:
    """Delete the saved rooms of a stopped server that name the participant, and what was answered in them.

    Raises StudyError.
    """
    try:
        # those of a cluster are in a folder per shard; *.tmp are left after a crash, others were not understood
        for path in [one for ending in ("json", "tmp", "not-understood") for one in folder.rooms.rglob(f"*.{ending}")]:
            if pid.encode() in path.read_bytes():
                path.unlink()
                for answers in (folder.data / "answers").glob(f"{path.name.partition('.')[0]}-*.jsonl"):
                    answers.unlink()
    except OSError as error:
        raise StudyError(f"cannot delete {error.filename}: {error.strerror or error}") from None
