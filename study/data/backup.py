"""A backup of a study, made while it is served, and its restoration: databases, recordings, checksums of everything.

Recordings never change once they are finished, so a backup may link those that an earlier one holds already.
"""

import hashlib
import json
import os
import shutil
import sqlite3
from collections.abc import Collection, Iterator
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from movingout.maps.files.output_file import draft_of
from movingout.recordings.annotation.verdicts import add_verdict, verdicts_of
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.storage.finished import SUFFIX, sync
from movingout.recordings.storage.s3_bucket import add_notes
from movingout.study.data.database_copy import fill_databases, refuse_used, save_database
from movingout.study.data.map_copies import copy_own_maps
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.definition import Study
from movingout.study.design.sections.study_model import Name
from movingout.study.errors import StudyError
from movingout.study.store.database import Kind
from movingout.study.store.frozen_study import frozen_study
from movingout.study.store.identity import IdentityStore
from movingout.study.store.store import Store
from movingout.study.store.tables import rounds

MANIFEST = "manifest.json"
FORMAT = 1
STUDY_ID = TypeAdapter[str](Name)
MAIN, IDENTITY, LINK_KEY, STUDY_FILE = "study.sqlite", "identity.sqlite", "link-key", "study.yaml"


@dataclass(frozen=True, slots=True)
class BackedUp:
    """What a backup holds."""

    folder: Path
    study: str
    files: int
    size: int  # bytes
    recordings: int
    missing: tuple[str, ...]  # recordings of rounds that are not there
    identities: bool
    warnings: tuple[str, ...] = ()


def back_up(
    folder: StudyFolder, target: Path, now: float, *, identities: bool = True, previous: Path | None = None
) -> BackedUp:
    """Write a backup into the new folder `target`. Raises StudyError; then `target` does not exist."""
    if target.exists():
        raise StudyError(f"{target} exists already and is not overwritten; choose another name with -o")
    folder.check_was_run()
    if identities and not folder.has_identities:
        raise StudyError(
            f"{folder.identity_file}, which says who is who, is not there; --no-identities backs up everything else"
        )
    part = target.with_name(f"{target.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    try:
        part.mkdir(parents=True, mode=0o700)
        done = _write(folder, part, target, identities, previous, now)
        part.rename(target)
    except (OSError, sqlite3.Error) as error:
        raise StudyError(f"the backup failed and nothing is left of it: {error}") from None
    finally:
        shutil.rmtree(part, ignore_errors=True)  # also where it was stopped
    return done


def _write(
    folder: StudyFolder, part: Path, target: Path, identities: bool, previous: Path | None, now: float
) -> BackedUp:
    _copy_databases(folder, part, identities)
    rows, warnings = _copy_study(folder, part)
    _fold_in(part / MAIN)
    episodes = [str(row["episode"]) for row in rows]
    absent = tuple(_copy_recordings(folder.recordings, part / "recordings", episodes, previous))
    unplayed = {row["episode"] for row in rows if row["ticks"] == 0}
    missing = tuple(episode for episode in absent if episode not in unplayed)
    for line in verdicts_of(folder.recordings):
        if line.recording in set(episodes):
            add_verdict(part, line)
    files = _write_manifest(part, folder.study.id, identities, now)
    for path in (*part.rglob("*"), part):
        if path.is_file() or path.is_dir():
            sync(path)
    size = sum(path.stat().st_size for path in part.rglob("*") if path.is_file())
    copied = len(set(episodes)) - len(absent)
    return BackedUp(target, folder.study.id, files, size, copied, missing, identities, warnings)


def _copy_databases(folder: StudyFolder, part: Path, identities: bool) -> None:
    """Copy the main database and, if `identities` are wanted, those who had a page before it was copied."""
    if identities:
        _save(folder.identities, folder.own / IDENTITY, "identity", part / IDENTITY)
        before = _opened(part / IDENTITY)
        (part / IDENTITY).unlink()
    _save(folder.database, folder.own / MAIN, "main", part / MAIN)
    if identities:
        _save(folder.identities, folder.own / IDENTITY, "identity", part / IDENTITY)
        _leave_out_arrivals(part, before)
        with suppress(FileNotFoundError):
            shutil.copy2(folder.own / LINK_KEY, part / LINK_KEY)


def _copy_study(folder: StudyFolder, part: Path) -> tuple[list[dict[str, Any]], tuple[str, ...]]:
    """Write the study's file, notes and maps beside its copied database; returns its rounds and warnings."""
    with closing(Store(part / MAIN)) as store:
        frozen = frozen_study(store)
        if frozen.id != folder.study.id:
            raise StudyError(f"the database holds the study {frozen.id}, not {folder.study.id}")
        (part / STUDY_FILE).write_text(frozen.file_text, encoding="utf-8")
        (part / MANIFEST).touch()  # a map of that name has no place here
        add_notes(folder.data, part)
        study, warnings = _begun(folder, store)
        copy_own_maps(study, part)
        return store.rows(rounds), warnings


def _write_manifest(part: Path, study_id: str, identities: bool, now: float) -> int:
    """Write the size and the digest of each file of the backup; returns how many there are."""
    files = {
        str(path.relative_to(part)): {"bytes": path.stat().st_size, "sha256": _digest(path)}
        for path in sorted(part.rglob("*"))
        if path.is_file() and path != part / MANIFEST
    }
    about = {"format": FORMAT, "study": study_id, "made": round(now), "identities": identities, "files": files}
    (part / MANIFEST).write_text(json.dumps(about, indent=1), encoding="utf-8")
    return len(files)


def _opened(identity_file: Path) -> set[str]:
    """The pseudonyms in a file of identities that have opened a page of the study."""
    with closing(IdentityStore(identity_file)) as kept:
        return {one.pid for one in kept.without(()) if one.used}


def _leave_out_arrivals(part: Path, before: Collection[str]) -> None:
    """Remove identities that came after the main database was copied, as if both copies were of the same moment.

    Otherwise the main one would look like an older one that was put back, and `study purge` would refuse it.
    """
    with closing(Store(part / MAIN)) as store, closing(IdentityStore(part / IDENTITY)) as kept:
        left = kept.without({one.pid for one in store.everybody()})
        kept.drop_visitors([one.pid for one in left if one.used and one.pid not in before])
        kept.database.scrub_rest()
    _fold_in(part / IDENTITY)


def _begun(folder: StudyFolder, store: Store) -> tuple[Study, tuple[str, ...]]:
    """The study as it began, whose maps its text names, and what is to be known about it.

    A backup is made all the same where a map is gone: everything else is worth keeping.
    """
    try:
        begun = folder.as_frozen(store, folder.study.place).study
    except StudyError as error:
        return folder.study, (f"the study of the backup cannot be read as it began: {error}",)
    changed = "the study file has changed since the study began; the backup has the one from then"
    return begun, () if begun == folder.study.allocated_by(begun.allocation) else (changed,)


def _save(address: str | None, file: Path, kind: Kind, target: Path) -> None:
    """Save a database as an SQLite file; with an address it is a PostgreSQL database."""
    if address is None:
        _copy_database(file, target)
    else:
        save_database(address, kind, target)
        _fold_in(target)


def _copy_database(source: Path, target: Path) -> None:
    """A consistent copy of a database that may be in use."""
    address = f"{source.absolute().as_uri()}?mode=ro"  # in which a folder's "#", "?" and "%" are quoted
    with closing(sqlite3.connect(address, uri=True)) as old, closing(sqlite3.connect(target)) as new:
        old.backup(new)
    _fold_in(target)


def _fold_in(database: Path) -> None:
    """Leave one file, without a write-ahead log beside it."""
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")


def _copy_recordings(source: Path, target: Path, episodes: list[str], previous: Path | None) -> Iterator[str]:
    """The recordings of these episodes, those of running rounds as journals; yields what is not there."""
    target.mkdir()
    for episode in dict.fromkeys(episodes):
        for suffix in (SUFFIX, JOURNAL_SUFFIX, SUFFIX):  # it may be finished between the first two
            path = source / f"{episode}{suffix}"
            try:
                _copy_or_link(path, target / path.name, previous)
                break
            except FileNotFoundError:
                continue
        else:
            yield episode


def _copy_or_link(path: Path, target: Path, previous: Path | None) -> None:
    """A finished file that the previous backup holds too, with the same size and time, takes no room twice."""
    older = previous / "recordings" / path.name if previous is not None and path.suffix == SUFFIX else None
    if older is not None and older.is_file():
        now, then = path.stat(), older.stat()
        if (now.st_size, now.st_mtime_ns) == (then.st_size, then.st_mtime_ns):
            with suppress(OSError):  # another file system
                os.link(older, target)
                return
    shutil.copy2(path, target)


# ---- restoring ------------------------------------------------------------------------------------------------------


def checked_manifest(backup: Path) -> dict[str, Any]:
    """The manifest of a backup of which every byte is as it was written. Raises StudyError."""
    try:
        if not backup.exists():
            raise StudyError(f"cannot read {backup}: there is no such file or folder; check the name")
        about: dict[str, Any] = json.loads((backup / MANIFEST).read_text(encoding="utf-8"))
        files = dict(about["files"])
        if about["format"] != FORMAT:
            raise StudyError(f"{backup} was written by a newer version; use that one")
        if "identities" not in about:
            raise KeyError("identities")
        STUDY_ID.validate_python(about["study"])  # its folder is named by it
        wrong = [name for name, known in files.items() if not _as_written(backup, name, known)]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise StudyError(f"{backup} is no backup of a study: it has no whole {MANIFEST}") from None
    if wrong:
        raise StudyError(f"the backup {backup} is damaged: {', '.join(wrong[:5])} changed or missing")
    return about


def restore(backup: Path, data: Path, database: str | None = None, identities: str | None = None) -> BackedUp:
    """Put a backup into a data folder that does not have the study yet. Raises StudyError, and changes nothing then.

    `database` and `identities` are addresses of empty PostgreSQL databases, where these are to be used.
    """
    about = checked_manifest(backup)
    study, files = str(about["study"]), about["files"]
    own = data / "studies" / study
    if own.exists():
        raise StudyError(f"{data} has data of the study {study} already; choose another folder with --data")
    addresses = _addresses(database, identities)
    refuse_used(addresses)
    recordings = _recordings(files)
    for name in recordings:
        there = data / name
        if there.exists() and _digest(there) != files[str(name)]["sha256"]:
            raise StudyError(f"{there} is another recording of that name; choose another folder with --data")
    try:
        _place(backup, data, own, files, addresses)
    except OSError as error:
        raise StudyError(f"cannot restore into {data}: {error.strerror or error}") from None
    size = sum(one["bytes"] for one in files.values())
    return BackedUp(backup, study, len(files), size, len(recordings), (), bool(about["identities"]))


def _place(backup: Path, data: Path, own: Path, files: Collection[str], addresses: dict[Kind, str]) -> None:
    """Put everything where it belongs; if interrupted, leave nothing of it. Raises OSError and StudyError."""
    part = own.with_name(f"{own.name}.part")
    with ExitStack() as undo:
        undo.callback(shutil.rmtree, part, ignore_errors=True)
        shutil.rmtree(part, ignore_errors=True)
        part.mkdir(parents=True, mode=0o700)
        (data / "recordings").mkdir(parents=True, exist_ok=True)
        for name in _recordings(files):
            if not (data / name).exists():
                undo.callback((data / name).unlink, missing_ok=True)
                _put(backup / name, data / name)
        for kept in (MAIN, IDENTITY, LINK_KEY):
            if kept in files:
                _put(backup / kept, part / kept)
        said = set(verdicts_of(data / "recordings"))
        for line in verdicts_of(backup):
            if line not in said:
                add_verdict(data / "recordings", line)
        add_notes(backup, data)
        _fill(part, addresses)
        part.rename(own)
        undo.pop_all()


def _recordings(files: Collection[str]) -> list[Path]:
    return [Path(name) for name in files if Path(name).parts[0] == "recordings"]


def _addresses(database: str | None, identities: str | None) -> dict[Kind, str]:
    given: dict[Kind, str | None] = {"main": database, "identity": identities}
    return {kind: address for kind, address in given.items() if address is not None}


def _fill(restored: Path, addresses: dict[Kind, str]) -> None:
    """Move the restored SQLite files into the PostgreSQL databases that have an address."""
    names: dict[Kind, str] = {"main": MAIN, "identity": IDENTITY}
    files: dict[Kind, Path] = {kind: restored / names[kind] for kind in addresses if (restored / names[kind]).exists()}
    fill_databases(files, addresses)
    for file in files.values():
        for path in restored.glob(f"{file.name}*"):
            path.unlink()


def _as_written(backup: Path, name: str, known: dict[str, Any]) -> bool:
    path = backup / name
    inside = not Path(name).is_absolute() and ".." not in Path(name).parts and not path.is_symlink()
    return inside and path.is_file() and path.stat().st_size == known["bytes"] and _digest(path) == known["sha256"]


def _put(source: Path, target: Path) -> None:
    """Copy a file so that nothing incomplete ever has its name."""
    with draft_of(target) as draft:
        shutil.copy2(source, draft)
        sync(draft)


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
