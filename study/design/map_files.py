"""Where the maps are that a study names: those that come with the project by name, others as files beside the study."""

import os
from dataclasses import dataclass, field
from pathlib import Path

from movingout.maps import MapSpec, load_map
from movingout.maps.files.composed_name import as_stored
from movingout.maps.library import is_generated_or_shipped
from movingout.maps.symmetry import split_name

ELSEWHERE = "maps-elsewhere"


def kept_place(file: str) -> Path:
    """Where a copy of a study has a map, seen from its file: as it is named, or in ELSEWHERE where by `/` or `..`."""
    parts = Path(file).parts
    if not Path(file).is_absolute() and ".." not in parts:
        return Path(file)
    return Path(ELSEWHERE, *({Path(file).anchor: "root", "..": "up"}.get(part, part) for part in parts))


@dataclass(frozen=True, slots=True)
class MapFiles:
    """The maps of a study file in `folder`; of a text without a file, None.

    The folder is no part of what a study says, so studies are equal wherever their files lie.
    """

    folder: Path | None = field(default=None, compare=False)

    def source(self, name: str) -> str:
        """The path of a file beside the study, also with symmetries after it; else the name as it is.

        A path that leads nowhere from there begins in the current folder, as every path did when earlier versions
        began studies. In a backup or an export, the copy is meant of what is named by `/` or `..`.
        """
        if self.folder is None or is_generated_or_shipped(name):
            return name
        file = split_name(name)[0]
        for beside in (kept_place(file), Path(file)):
            path = as_stored(str(self.folder / beside))
            if os.path.isfile(path):
                return f"{path}{name[len(file) :]}"
        return name

    def load(self, name: str) -> MapSpec:
        """The map that a study names. Raises MapError."""
        return load_map(self.source(name))
