"""What a folder of tables was begun with, in its `paper.json`; another budget or other recordings need another folder.

The folder and the recordings may be moved: names and sizes of recordings tell whether they are the same.

How many trainings and matches there are may grow: what is there already is used, and the rest is added.
"""

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from movingout.matches.errors import MatchError
from movingout.matches.paper.budgets import GROWING, Budget, budget_of
from movingout.matches.paper.data_sets import rewrite_list
from movingout.matches.paper.workspace import DATA, TIMES, Workspace
from movingout.matches.results.results_folder import write_whole
from movingout.recordings.storage.study_rounds import uncounted_episodes

BEGUN = Path("paper.json")
LOCK = Path("paper.lock")
_EARLIER: dict[str, Any] = {"groups": "random", "styles": []}  # what earlier versions did not write
FINISHED = "finished"  # key of the numbers that a label was finished with; earlier versions wrote those asked for alone
RECORDINGS = "recordings"  # key of the digest, which earlier versions did not write


@contextmanager
def exclusive_folder() -> Iterator[None]:
    """Keep other commands out of the current folder: two would record and train the same at once.

    Raises MatchError where one is at work.
    """
    lock = FileLock(LOCK.absolute(), blocking=False, thread_local=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise MatchError(
            f"another `movingout paper` is at work in {Path.cwd()}; wait for it, or choose another folder with --out"
        ) from error
    except (OSError, NotImplementedError) as error:
        raise MatchError(f"cannot lock {LOCK.absolute()}: {error}; choose another folder with --out") from error
    try:
        yield
    finally:
        lock.release()


def begin(space: Workspace) -> None:
    """Note what the current folder is begun with. Raises MatchError where something else was made in it.

    A folder in which nothing was made yet, because its recordings were refused, is begun anew.
    """
    check_beginning(space)
    note = _note(space)
    if _is_begun() and _is_elsewhere(space, _begun_with()):
        for challenge in (1, 2):
            rewrite_list(challenge, space)
    write_whole(BEGUN, json.dumps({**note, FINISHED: _finished()}, indent=1) + "\n")


def finish(space: Workspace) -> None:
    """Note that a label has been made whole, so that its numbers of trainings and matches are the least from now on."""
    sizes = {name: getattr(space.budget, name) for name in GROWING}
    write_whole(BEGUN, json.dumps({**_note(space), FINISHED: sizes}, indent=1) + "\n")


def check_beginning(space: Workspace) -> None:
    """Raises MatchError where something else was made in the current folder."""
    mine = _note(space)
    if _is_begun():
        theirs = _begun_with()
        moved = _is_elsewhere(space, theirs)
        other = [name for name in _fixed(mine) if theirs.get(name) != mine[name] and not (moved and name == "data")]
        if other:
            said = ", ".join(f"{name} {theirs.get(name)}" for name in other)
            raise MatchError(f"{Path.cwd()} was begun with {said}; choose another folder with --out")
        if RECORDINGS in theirs and not _same_recordings(space, theirs):
            raise MatchError(
                f"the recordings of --data are not those that {Path.cwd()} was begun with: since then some were added, "
                "removed, changed, or marked as invalid in their study; choose another folder with --out"
            )


def grown(budget: Budget, **asked: int | None) -> Budget:
    """A budget with as many trainings and matches as are asked for, else as the current folder has.

    Raises MatchError for fewer than a table of the folder was made with: it would lose what stands in it. What was
    asked for and stopped before that may be lowered.
    """
    theirs, finished = (_begun_with(), _finished()) if _is_begun() else ({}, {})
    sizes: dict[str, int] = {}
    for name in GROWING:
        least, wanted = finished.get(name, 0), asked.get(name)
        if wanted is not None and wanted < least:
            raise MatchError(f"{Path.cwd()} has {least} {name} of each already; --{name} is at least that here")
        sizes[name] = wanted or int(theirs.get(name, 0)) or getattr(budget, name)
    return replace(budget, trainings=sizes["trainings"], seeds=sizes["seeds"])


def begun() -> Workspace:
    """The workspace in the current folder. Raises MatchError where nothing has been made."""
    if not BEGUN.exists():
        raise MatchError(f"no table has been made in {Path.cwd()} yet: `movingout paper tables LABEL -o DIR` makes one")
    said = _begun_with() | _finished()
    try:
        budget = budget_of(said["budget"])
        return Workspace(
            budget=replace(
                budget,
                trainings=int(said.get("trainings", budget.trainings)),
                seeds=int(said.get("seeds", budget.seeds)),
            ),
            evaluation=said["evaluation"], min_tcr=said["min_tcr"],
            given=tuple(Path(path) for path in said["data"]), seed=said["seed"], grouping=said["groups"],
            styles=tuple((name, style) for name, style in said["styles"]),
        )  # fmt: skip
    except (KeyError, TypeError, ValueError) as error:
        raise MatchError(f"{BEGUN.resolve()} is damaged ({error}); choose another folder with --out") from error


def _note(space: Workspace) -> dict[str, Any]:
    return {
        "budget": space.budget.name, "evaluation": space.evaluation, "data": [str(path) for path in space.given],
        "min_tcr": space.min_tcr, "seed": space.seed, "groups": space.grouping,
        "styles": [list(pair) for pair in space.styles], RECORDINGS: _digest(space),
        **{name: getattr(space.budget, name) for name in GROWING},
    }  # fmt: skip


def _fixed(note: dict[str, Any]) -> list[str]:
    return [name for name in note if name not in (*GROWING, RECORDINGS)]


def _is_elsewhere(space: Workspace, theirs: dict[str, Any]) -> bool:
    """Whether the same recordings were given, and lie or are called otherwise by now."""
    given = [str(path) for path in space.given]
    return bool(given and theirs.get("data") and given != theirs["data"] and _same_recordings(space, theirs))


def _same_recordings(space: Workspace, theirs: dict[str, Any]) -> bool:
    """Whether a folder was begun with these. Earlier versions took them in the order of their folders."""
    found = theirs.get(RECORDINGS)
    return found == _digest(space) or found == _digest(space, in_order=True)


def _digest(space: Workspace, in_order: bool = False) -> str:
    """Of the names and sizes of given recordings, and of which of them do not count; empty where none are given."""
    if not space.given:
        return ""
    files = space.given_files()
    sizes = [[path.name, path.stat().st_size] for path in files]
    text = json.dumps([sizes if in_order else sorted(sizes), sorted(uncounted_episodes(files))])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _finished() -> dict[str, int]:
    """With how many trainings and matches a label was finished in the current folder; empty where none was."""
    if not _is_begun():
        return {}
    theirs = _begun_with()
    found = theirs.get(FINISHED, theirs)
    return {name: int(found[name]) for name in GROWING if name in found}


def _is_begun() -> bool:
    """Whether the folder has a note and more than that and notes of how long steps took."""
    folders = DATA, Path("tables"), Path("figures")
    made = (path for folder in folders for path in folder.rglob("*"))
    return BEGUN.exists() and any(path.is_file() and path != TIMES for path in made)


def _begun_with() -> dict[str, Any]:
    try:
        return _EARLIER | dict(json.loads(BEGUN.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise MatchError(f"{BEGUN.resolve()} is damaged ({error}); choose another folder with --out") from error
