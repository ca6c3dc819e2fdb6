"""`movingout maps check`: the faults and hints of map files, one by one or a whole folder."""

import argparse
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from movingout.maps.check import MapFault, check_map
from movingout.maps.commands.map_cautions import map_hints
from movingout.maps.document_check import check_document
from movingout.maps.errors import MapError
from movingout.maps.files.composed_name import as_stored
from movingout.maps.files.input_file import read_input
from movingout.maps.library import is_generated_or_shipped, load_map, map_document
from movingout.maps.official import is_official


class _Checked(NamedTuple):
    """What was found in one file; `error` says why it is no map at all."""

    file: str
    faults: tuple[MapFault, ...] = ()
    hints: tuple[MapFault, ...] = ()
    error: str = ""

    @property
    def code(self) -> int:
        """As exit code of a command: 0 playable, 1 faulty, 2 no map."""
        return 2 if self.error else 1 if self.faults else 0

    @property
    def summary(self) -> str:
        count = {0: "no faults", 1: "1 fault"}.get(len(self.faults), f"{len(self.faults)} faults")
        return self.error or f"{self.file}: {count}"

    @property
    def details(self) -> list[str]:
        return [*map(str, self.faults), *(f"hint: {hint}" for hint in self.hints)]

    @property
    def document(self) -> dict[str, Any]:
        found, hinted = ([{"path": one.path, "message": one.message} for one in ones] for ones in self[1:3])
        if self.error:
            found = [{"path": "the map", "message": self.error}]
        return {"map": self.file, "playable": self.code == 0, "faults": found, "hints": hinted}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "maps",
        nargs="+",
        metavar="FILE",
        help="map files in our JSON or in the official format, folders of them, or names of maps",
    )
    parser.add_argument(
        "--json",
        action="store_true",
        help="one JSON document on standard output; for several files or a folder, a list of them",
    )


def perform(args: argparse.Namespace) -> int:
    """Print what was found; the worst exit code of the files. Raises MapError for a single file that is no map."""
    maps = [*map(as_stored, args.maps)]
    if len(maps) == 1 and not _is_folder(maps[0]):
        one = _Checked(maps[0], *_findings(maps[0]))
        print(json.dumps(one.document, indent=2) if args.json else "\n".join([*one.details, one.summary]))
        return one.code
    every = [_checked(file) for file in dict.fromkeys(_files(maps))]
    if args.json:
        print(json.dumps({"maps": [one.document for one in every]}, indent=2))
    else:
        print("\n".join(line for one in every for line in (one.summary, *(f"  {detail}" for detail in one.details))))
    return max(one.code for one in every)


def _files(named: list[str]) -> Iterator[str]:
    """Each name, and of each folder the files that `play --maps` would read."""
    for name in named:
        if not _is_folder(name):
            yield name
            continue
        try:
            files = [file for file in sorted(Path(name).iterdir()) if file.name.lower().endswith(".json")]
        except OSError as error:
            raise MapError(f"cannot read the folder {name}: {error.strerror or error}") from None
        files = [file for file in files if not file.name.startswith(".")]
        if not files:
            raise MapError(f"the folder {name} has no map files; their names end in .json")
        yield from map(str, files)


def _is_folder(name: str) -> bool:
    return name != "" and os.path.isdir(name) and not is_generated_or_shipped(name)


def _checked(name_or_path: str) -> _Checked:
    try:
        return _Checked(name_or_path, *_findings(name_or_path))
    except MapError as error:
        return _Checked(name_or_path, error=str(error))


def _findings(name_or_path: str) -> tuple[tuple[MapFault, ...], tuple[MapFault, ...]]:
    """The faults of a map, and the hints; MapError when there is nothing that could be a map."""
    try:
        spec = load_map(name_or_path)
    except MapError as error:
        document = _document(Path(name_or_path))
        if document is None:
            raise
        if is_official(document):
            return (MapFault("the map", str(error).removeprefix(f"{name_or_path}: ")),), ()
        return check_document(document), ()
    return check_map(spec), map_hints(name_or_path)


def _document(path: Path) -> object:
    """The JSON document of a file, None when there is none."""
    try:
        return map_document(read_input(path), path)
    except (OSError, MapError):
        return None
