"""The operator's own maps: the map files of one folder (`--maps DIR`), looked through again while the server runs.

A file that cannot be offered is left out with a sentence about it for the operator; visitors only hear how many.
Only plain files directly in the folder are opened, none through a link, and none above MAX_BYTES.
"""

import logging
import os
import stat
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import NamedTuple

from movingout.maps import MapError, MapSpec, is_reserved
from movingout.maps.check import check_map
from movingout.maps.commands.map_cautions import is_shipped_as
from movingout.maps.generated.names import is_generated
from movingout.maps.library import map_from_text
from movingout.maps.symmetry import SEPARATOR, SYMMETRY_NAMES, read_symmetry, transformed

log = logging.getLogger(__name__)

MAX_FILES = 200
MAX_BYTES = 64 * 1024
LOOK_S = 1.0  # the folder is not looked through more often

Stamp = tuple[int, int, int]  # inode, time of change, size
Outcome = MapSpec | str  # a map, or the sentence that says why there is none
Reader = Callable[[Path], Awaitable[Outcome]]


class FolderError(MapError):
    """The folder of maps cannot be used."""


class _ReadFile(NamedTuple):
    stamp: Stamp
    outcome: Outcome


class MapFolder:
    """The maps of a folder by name, and what is wrong with the other files. Without a folder there are none."""

    def __init__(self, folder: Path | None, clock: Callable[[], float] = time.monotonic) -> None:
        self.folder = folder
        self.maps: dict[str, MapSpec] = {}
        self.problems: dict[str, str] = {}  # by file name: one sentence
        self._clock = clock
        self._looked = -LOOK_S
        self._entries: dict[str, _ReadFile] = {}

    def read(self) -> None:
        """Read every file now. Raises FolderError when the folder cannot be opened."""
        if self.folder is None:
            return
        stamps = map_files(self.folder)
        for name in list(stamps)[:MAX_FILES]:
            self._entries[name] = _ReadFile(stamps[name], read_map_file(self.folder / name))
        self._sort_out(stamps)

    async def refresh(self, read: Reader) -> None:
        """Read what has changed since the last look, with `read`, which does so where it delays no tick."""
        if self.folder is None or self._clock() - self._looked < LOOK_S:
            return
        self._looked = self._clock()
        try:
            stamps = map_files(self.folder)
        except FolderError as error:
            log.warning("%s; its maps are offered as they were", error)
            return
        entries = dict(self._entries)
        for name in list(stamps)[:MAX_FILES]:
            if name not in entries or entries[name].stamp != stamps[name]:
                entries[name] = _ReadFile(stamps[name], await read(self.folder / name))
        self._entries = entries
        before = self.problems
        self._sort_out(stamps)
        for sentence in self.problems.values():
            if sentence not in before.values():
                log.warning("own map: %s", sentence)

    def find(self, name: str) -> MapSpec | None:
        """The map of a name, which may end with symmetries; None when the folder has none such."""
        base, *names = name.split(SEPARATOR)
        if name in self.maps:
            return self.maps[name]
        if base not in self.maps or not set(names) <= set(SYMMETRY_NAMES):
            return None
        return transformed(self.maps[base], read_symmetry(names))

    def _sort_out(self, stamps: dict[str, Stamp]) -> None:
        """Each name once, the first file of the alphabet first; what is no longer there is forgotten."""
        self._entries = {name: entry for name, entry in sorted(self._entries.items()) if name in stamps}
        maps: dict[str, MapSpec] = {}
        problems: dict[str, str] = {}
        files: dict[str, str] = {}  # by the name of the map
        for file, (_, outcome) in self._entries.items():
            if isinstance(outcome, str):
                problems[file] = outcome
            elif outcome.name in maps:
                problems[file] = f"{shown(file)}: {files[outcome.name]} has the name {outcome.name} already; change one"
            else:
                maps[outcome.name], files[outcome.name] = outcome, shown(file)
        if len(stamps) > MAX_FILES:
            problems[""] = f"the folder has {len(stamps)} map files; only the first {MAX_FILES} are offered"
        self.maps, self.problems = maps, problems


def read_map_file(path: Path) -> Outcome:
    """The map of a file, or a sentence that says what keeps it from being played."""
    name = shown(path.name)
    try:
        spec = map_from_text(_text(path), name)
    except MapError as error:
        return str(error)
    except OSError as error:
        return f"{name} cannot be read: {error.strerror or error}"
    if is_reserved(spec.name):
        return _shipped_twice(spec, name)
    faults = check_map(spec)
    if faults:
        more = f" (and {len(faults) - 1} more; movingout maps check lists them)" if len(faults) > 1 else ""
        return f"{name}: {faults[0]}{more}"
    return spec


def shown(name: str) -> str:
    """A file's name as it can be printed: signs that no terminal should get are replaced."""
    return "".join(sign if sign.isprintable() else "\N{REPLACEMENT CHARACTER}" for sign in name)


def _shipped_twice(spec: MapSpec, file: str) -> str:
    if is_shipped_as(spec):
        return f"{file}: this is the shipped map {spec.name}, which is offered anyway"
    whose = "names maps of the generator" if is_generated(spec.name) else "is the name of a shipped map"
    return f"{file}: {spec.name} {whose}; give this one another name"


def _text(path: Path) -> bytes:
    """The content of a plain file; a link is not followed, and neither a pipe nor a device is waited for."""
    handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    try:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise MapError(f"{shown(path.name)} is no plain file")
        with os.fdopen(handle, "rb", closefd=False) as file:
            content = file.read(MAX_BYTES + 1)
    finally:
        os.close(handle)
    if len(content) > MAX_BYTES:
        raise MapError(f"{shown(path.name)} is larger than {MAX_BYTES // 1024} KiB, which no map is")
    return content


def map_files(folder: Path) -> dict[str, Stamp]:
    """The files of a folder whose names end in .json, in order, with what tells a change. Raises FolderError."""
    found: dict[str, Stamp] = {}
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name.lower().endswith(".json") and not entry.name.startswith("."):
                    at = entry.stat(follow_symlinks=False)
                    found[entry.name] = (at.st_ino, at.st_mtime_ns, at.st_size)
    except OSError as error:
        raise FolderError(f"cannot read the folder of maps {folder}: {error.strerror or error}") from None
    return dict(sorted(found.items()))
