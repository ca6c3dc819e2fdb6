"""The data folder of a server: that it can be written to, and that one server alone uses it."""

import shlex
import tempfile
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from movingout.maps.errors import MovingOutError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.server.persistence.room_store import episodes_of_other_studies, episodes_of_rooms
from movingout.server.settings import NODES

LOCK = "serving.lock"
WRITTEN = ("recordings", "rooms", "answers")  # folders inside


class BadDataFolder(MovingOutError):
    """The data folder cannot be used."""


@contextmanager
def exclusive_data_folder(folder: Path) -> Iterator[int]:
    """Create the folder and hold it for this process: a second server would restore the rooms of the first one.

    Yields the descriptor of the lock: the folder stays locked until every process that keeps it open has ended.
    Writes a byte into each folder of its own, so that an error shows now and not after the first game. Raises
    BadDataFolder.
    """
    lock = FileLock(folder / LOCK, blocking=False, thread_local=False)
    try:
        _write_to(folder)
        lock.acquire()
        descriptor: int = lock._context.lock_file_fd or 0
    except Timeout:
        problem = f"the data folder {folder} is in use by another server; stop that one or choose another: --data DIR"
        raise BadDataFolder(problem) from None
    except OSError as error:
        problem = f"cannot write to the data folder {folder} ({error.strerror}); choose another one: --data DIR"
        raise BadDataFolder(problem) from None
    try:
        for name in WRITTEN:
            if (folder / name).exists():
                _check_inside(folder / name)
        yield descriptor
    finally:
        lock.release()


def _check_inside(inside: Path) -> None:
    try:
        _write_to(inside)
    except OSError as error:
        problem = (
            f"cannot write to {inside} ({error.strerror}); move it away, or choose another data folder: --data DIR"
        )
        raise BadDataFolder(problem) from None


def _write_to(folder: Path) -> None:
    """Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder) as probe:
        probe.write(b"x")
        probe.flush()


@contextmanager
def _looking_at(folder: Path) -> Iterator[None]:
    """Raises BadDataFolder where the system does not let this program look, or knows no such name."""
    try:
        yield
    except OSError as error:
        problem = f"cannot look at the data folder {folder} ({error.strerror}); choose another one: --data DIR"
        raise BadDataFolder(problem) from None


def refuse_study_folder(folder: Path) -> None:
    """Raise BadDataFolder where a study keeps its data: a server for games would show its recordings.

    Whoever was refused before a study began has left its lock at most. A key of links counts: of a study in PostgreSQL
    no other file is here.
    """
    with _looking_at(folder):
        studies = sorted(
            path.name for path in folder.glob("studies/*") if path.is_dir() and _holds_more_than_lock(path)
        )
    if studies:
        raise BadDataFolder(
            f"the data folder {folder} holds a study ({', '.join(studies)}), whose recordings are not for players; "
            "choose another one for games: --data DIR, or open the study: movingout study serve"
        )


def _holds_more_than_lock(folder: Path) -> bool:
    return any(path.name != LOCK for path in folder.iterdir())


def refuse_cluster_folder(folder: Path) -> None:
    """Raise BadDataFolder where nodes of a cluster keep their rooms: a server of its own would take them."""
    with _looking_at(folder):
        nodes = sorted(path.parent.name for path in folder.glob(f"{NODES}/*/{LOCK}"))
    if nodes:
        raise BadDataFolder(
            f"the data folder {folder} belongs to nodes of a cluster ({', '.join(nodes)}); start one of these with "
            "--cluster and --node, or choose another folder: --data DIR"
        )


def refuse_served_folder(folder: Path) -> None:
    """Raise BadDataFolder where a server that is no node of a cluster uses the folder."""
    with _looking_at(folder):
        if not (folder / LOCK).exists():
            return
        try:
            with FileLock(folder / LOCK, timeout=2.0):  # another node that starts looks for a moment, too
                pass
        except Timeout:
            raise BadDataFolder(
                f"the data folder {folder} is in use by a server that is no node of a cluster; stop that one or choose "
                "another: --data DIR"
            ) from None


def told_of_other_studies(folder: Path, study: str) -> str:
    """What to say at the start about rounds of other studies, which wait until those are served; empty for none."""
    others = episodes_of_other_studies(folder / "rooms", study)
    waiting = Counter(others[episode] for episode in others.keys() & _unfinished(folder))
    return "\n".join(
        f"1 round of the study {id} was interrupted; it goes on when that study is served again."
        if count == 1
        else f"{count} rounds of the study {id} were interrupted; they go on when that study is served again."
        for id, count in sorted(waiting.items())
    )


def _unfinished(folder: Path) -> set[str]:
    """The episodes of all journals."""
    return {path.name.removesuffix(JOURNAL_SUFFIX) for path in (folder / "recordings").glob(f"*{JOURNAL_SUFFIX}")}


def told_interrupted(folder: Path, study: str = "") -> str:
    """What to say at the end about rounds that were being played, empty for none; other studies' than `study` wait."""
    unfinished, others = _unfinished(folder), episodes_of_other_studies(folder / "rooms", study).keys()
    journals = unfinished - others
    if not journals:
        return ""
    going_on = len(episodes_of_rooms(folder / "rooms").intersection(journals))
    ended = len(journals) - going_on  # their recording had stopped, or was just being finished
    rounds = {
        "1 round was interrupted; it goes on when the server is started again.": going_on == 1,
        f"{going_on} rounds were interrupted; they go on when the server is started again.": going_on > 1,
        "1 recording is not finished; the next start finishes it.": ended == 1,
        f"{ended} recordings are not finished; the next start finishes them.": ended > 1,
    }
    said = " ".join(sentence for sentence, holds in rounds.items() if holds)
    ending = _ending(folder / "recordings", journals if others & unfinished else None, going_on > 0)
    return f"{said} To end now: movingout recordings recover {ending}"


def _ending(recordings: Path, alone: Collection[str] | None, going_on: bool) -> str:
    """What `recover` is to be given: the folder, or the journals of these rounds where others must go on."""
    if alone is not None and going_on:
        return " ".join(shlex.quote(str(recordings / f"{episode}{JOURNAL_SUFFIX}")) for episode in sorted(alone))
    return f"{shlex.quote(str(recordings))}{' --all' if going_on else ''}"
