"""The map files that a study names, beside a copy of its file: so that the copy can be read wherever it lies."""

import shutil
from contextlib import suppress
from pathlib import Path

from movingout.maps.symmetry import split_name
from movingout.study.design.definition import Study


def copy_own_maps(study: Study, folder: Path) -> None:
    """Copy them to where the study's file names them, seen from `folder`; nothing there is overwritten.

    Those that it names from elsewhere, by `/` or `..`, stay where they are; so does what can no longer be read, as
    recordings hold their maps, too.
    """
    for name in dict.fromkeys(split_name(name)[0] for name in study.own_maps):
        inside = Path(name)
        target = folder / inside
        if inside.is_absolute() or ".." in inside.parts or target.exists():
            continue
        with suppress(OSError):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(study.map_source(name), target)
