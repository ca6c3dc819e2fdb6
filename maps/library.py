"""Maps by name (shipped or generated) or by path (your own), as designed or in one of their symmetries."""

import json
import os
from functools import lru_cache
from pathlib import Path
from typing import Any

from movingout.maps.errors import MapError
from movingout.maps.files.composed_name import as_stored
from movingout.maps.files.input_file import read_input
from movingout.maps.files.list_file import LIST
from movingout.maps.generated.names import PREFIX, is_generated, read_name
from movingout.maps.json_format import map_from_json
from movingout.maps.official import is_official, map_from_official
from movingout.maps.spec import MapSpec
from movingout.maps.suggestion import known_names
from movingout.maps.symmetry import SEPARATOR, SYMMETRY_NAMES, Symmetry, read_symmetry, split_name, transformed

PRACTICE = "Simple"
TUTORIAL = "Tutorial"  # loads by name, but is played in tutorials only and never offered

_FOLDER = Path(__file__).parent
_PAPER = (
    "HandOff",
    "PassOrSplit",
    "EfficientRoutes",
    "PriorityPick",
    "CornerDecision",
    "DistancePriority",
    "TopBottomPriority",
    "AdaptiveAssist",
    "LeftRight",
    "SingleRotation",
    "FourCorners",
    "SequentialRotations",
)


def map_names() -> tuple[str, ...]:
    """The paper's twelve maps in their order: what `all` means in matches, studies and training."""
    return _PAPER


def shipped_map_names() -> tuple[str, ...]:
    """Every map that is offered: the paper's, then further files of this folder, then the practice map."""
    files = {path.stem for path in _FOLDER.glob("*.json") if not path.name.endswith(".schema.json")}
    return (*_PAPER, *sorted(files - {*_PAPER, PRACTICE, TUTORIAL}), PRACTICE)


def loadable_map_names() -> tuple[str, ...]:
    """Every map that a command takes by name: those that are offered, and the tutorial's."""
    return (*shipped_map_names(), TUTORIAL)


def load_map(name_or_path: str | os.PathLike[str]) -> MapSpec:
    """The map of a name, or of a path to a map file in our JSON or in the official format.

    `generated:awareness:12` is a generated map (`maps.generated`), `generated:awareness:12:hard` a hard one. After name
    or path may stand symmetries of the square, such as `:mirror` or `:rot90` (`maps.symmetry`).
    Raises MapError with what would work when there is no such map, or with the JSON path of the fault.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise MapError(f"a map is named by its name or the path of its file, not by {name_or_path!r:.80}")
    base, symmetry = _split(os.fspath(name_or_path))
    the_map = _designed(base)
    return transformed(the_map, symmetry) if symmetry.names else the_map


def is_shipped(name: str) -> bool:
    """Whether a name, with a symmetry or without, is that of a shipped map; a path never is."""
    base, *names = name.split(SEPARATOR)
    return base in shipped_map_names() and all(name in SYMMETRY_NAMES for name in names)


def is_generated_or_shipped(name: str) -> bool:
    """Whether a name is that of a map that comes with the project, from a file or from the generator."""
    return is_generated(name) or is_shipped(name) or name in loadable_map_names()


def is_reserved(name: str) -> bool:
    """Whether no map of one's own can have this name: its rounds would be taken for rounds on a shipped map."""
    return name.partition(SEPARATOR)[0] in (*loadable_map_names(), PREFIX)


def _split(text: str) -> tuple[str, Symmetry]:
    """`HandOff:mirror:rot90` as the map's name or path and the symmetry. Raises MapError for an unknown symmetry."""
    if is_generated(text):
        base, names = split_name(text)
        return base, read_symmetry(names)
    base, *names = text.split(SEPARATOR)
    if base not in shipped_map_names():  # a path may have such a sign in itself
        names = []
        while (parts := text.rpartition(SEPARATOR))[2] in SYMMETRY_NAMES:
            text, names = parts[0], [parts[2], *names]
        base = text
    try:
        return base, read_symmetry(names)
    except KeyError as error:
        raise MapError(f"unknown symmetry {error} of {base}; {known_names(error.args[0], SYMMETRY_NAMES)}") from None


def _designed(text: str) -> MapSpec:
    if text in loadable_map_names():
        return _shipped(text)
    if is_generated(text):
        from movingout.maps.generated.generator import generate  # needs numpy, which names and --help do without

        named = read_name(text)
        return generate(named.seed, named.mode, named.difficulty)
    text = as_stored(text)
    path = Path(text)
    if os.path.isdir(text):
        raise MapError(f"{text} is a folder; name the files in it, as {path / 'NAME.json'}")
    before, _, word = text.rpartition(SEPARATOR)
    if os.path.isfile(before) and not os.path.exists(text):
        raise MapError(f"unknown symmetry {word!r} of {before}; {known_names(word, SYMMETRY_NAMES)}")
    if path.suffix == ".json" or len(path.parts) > 1 or os.path.isfile(text):
        return _read(path)
    raise MapError(_unknown(text))


@lru_cache(maxsize=64)
def _shipped(name: str) -> MapSpec:
    return _read(_FOLDER / f"{name}.json")


def map_from_text(text: str | bytes, path: Path | str) -> MapSpec:
    """The map of a file's text, in our JSON or in the official format; `path` is what errors call it.

    Raises MapError with the JSON path of the fault.
    """
    document = map_document(text, path)
    try:
        return map_from_official(document, Path(path).stem) if is_official(document) else map_from_json(document)
    except MapError as error:
        raise MapError(f"{path}: {error}") from error


def map_document(text: str | bytes, path: Path | str) -> Any:
    """The JSON document of a map file. Raises MapError where it is none, or a name stands twice in one object."""
    try:
        return json.loads(text, object_pairs_hook=_each_once)
    except MapError as error:
        raise MapError(f"{path}: {error}") from None
    except (ValueError, RecursionError) as error:
        yaml = "; a map is a JSON file, not YAML" if Path(path).suffix in (".yaml", ".yml") else ""
        raise MapError(f"{path} is not JSON: {error}{yaml}") from error


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The object of these pairs, of which JSON would keep the last of those with one name."""
    document: dict[str, Any] = {}
    for name, value in pairs:
        if name in document:
            raise MapError(f"{name} stands twice in one object")
        document[name] = value
    return document


def _read(path: Path) -> MapSpec:
    try:
        text = read_input(path)
    except OSError as error:
        raise MapError(f"cannot read the map file {path}: {error.strerror or error}") from error
    return map_from_text(text, path)


def _unknown(name: str) -> str:
    if name in ("all", "all:symmetries") or name.startswith(LIST):
        return f"{name!r} names several maps; name each of them"
    return f"unknown map {name!r}; {known_names(name, loadable_map_names())}"
