"""Which recordings have been verified already: finished files never change, so once is enough."""

import json
from collections.abc import Iterable
from pathlib import Path

from movingout.maps.files.output_file import draft_of

LIST = ".verified.json"  # in the folder of the recordings


def not_verified(paths: Iterable[Path]) -> list[Path]:
    """Those that are not in the list of their folder as they are now; what is not there is among them."""
    known: dict[Path, dict[str, list[int]]] = {}
    found = []
    for path in paths:
        if path.parent not in known:
            known[path.parent] = _read(path.parent)
        stamp = _stamp(path)
        if stamp is None or known[path.parent].get(path.name) != stamp:
            found.append(path)
    return found


def never_verified(path: Path) -> bool:
    """Whether it is a folder in which nothing was ever verified. An empty one then had no recordings yet."""
    return path.is_dir() and next(path.rglob(LIST), None) is None


def note_verified(paths: Iterable[Path]) -> None:
    """Add these to the lists of their folders; files that are gone leave them. Raises OSError."""
    folders: dict[Path, list[Path]] = {}
    for path in paths:
        folders.setdefault(path.parent, []).append(path)
    for folder, fresh in folders.items():
        rows = {name: row for name, row in _read(folder).items() if (folder / name).exists()}
        rows |= {path.name: stamp for path in fresh if (stamp := _stamp(path)) is not None}
        with draft_of(folder / LIST) as draft:
            draft.write_text(json.dumps(rows), encoding="utf-8")


def _stamp(path: Path) -> list[int] | None:
    """Size and time of the last change in ns; None when it cannot be seen."""
    try:
        about = path.stat()
    except OSError:
        return None
    return [about.st_size, about.st_mtime_ns]


def _read(folder: Path) -> dict[str, list[int]]:
    """A list that cannot be read is empty: everything is verified once more."""
    try:
        rows = json.loads((folder / LIST).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return rows if isinstance(rows, dict) else {}
