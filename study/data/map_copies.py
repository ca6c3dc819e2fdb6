"""The map files that a study names, beside a copy of its file: so that the copy can be read wherever it lies."""

import shutil
from contextlib import suppress
from pathlib import Path

from movingout.maps.symmetry import split_name
from movingout.study.design.definition import Study
from movingout.study.design.map_files import kept_place


def copy_own_maps(study: Study, folder: Path) -> None:
    """Copy them to where a study whose file lies in `folder` looks for them; nothing there is overwritten.

    What can no longer be read stays out, as recordings hold their maps, too.
    """
    for name in dict.fromkeys(split_name(name)[0] for name in study.own_maps):
        target = folder / kept_place(name)
        if target.exists():
            continue
        with suppress(OSError):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(study.map_source(name), target)
