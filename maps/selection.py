"""Which maps a command means by the words of its option `--map`."""

import os
from pathlib import Path

from movingout.maps.errors import MapError
from movingout.maps.files.list_file import LIST, listed_lines
from movingout.maps.generated.names import MODE_WORDS, PREFIX, SPLITS, is_generated
from movingout.maps.generated.proved import in_turn, proved_maps
from movingout.maps.library import load_map, map_names
from movingout.maps.suggestion import known_names
from movingout.maps.symmetry import ALL_SYMMETRIES, SEPARATOR

HELP = (
    "a map's name, several joined by commas, all (the paper's twelve), all:symmetries (these mirrored and turned), "
    "generated:test, generated:test:60 (so many of them), @FILE or @FILE:60 (a list: one of these per line)"
)


def selected_maps(text: str | os.PathLike[str]) -> list[str]:
    """The names of the maps that are meant, each once; those of single maps are not checked. Raises MapError."""
    if not isinstance(text, str | os.PathLike):
        raise MapError(f"a map is named by its name or the path of its file, not by {text!r:.80}")
    text = os.fspath(text)
    if os.path.isfile(text):  # whose name may have a comma; unlike `Path`, this takes a list too long to be a name
        return [text]
    return list(dict.fromkeys(name for word in text.split(",") for name in _meant(word)))


def _meant(word: str) -> list[str]:
    base, _, rest = word.partition(SEPARATOR)
    if word == "all":
        return list(map_names())
    if word == "all:symmetries":
        return [SEPARATOR.join((name, *one.names)) for one in ALL_SYMMETRIES if one.names for name in map_names()]
    if word.startswith(LIST):
        return _listed(word[1:])
    split, _, count = rest.partition(SEPARATOR)
    if base == PREFIX and split in (*SPLITS, ""):
        if count and not count.isdecimal():
            raise MapError(f"{word}: how many maps is a whole number, not {count!r}")
        return list(proved_maps(split or "test", int(count) if count else None))
    if base == PREFIX and split not in MODE_WORDS.values():
        raise MapError(f"unknown maps {word}; {known_names(split, (*SPLITS, *MODE_WORDS.values()))}")
    return [word]


def _listed(text: str) -> list[str]:
    """The maps of a file, or the first so many; of generated ones the modes in turn. Raises MapError for none."""
    file, separator, count = text.rpartition(SEPARATOR)
    if not (separator and count.isdecimal()):
        file, count = text, ""
    names = list(dict.fromkeys(name for line in _lines(file) for name in _on_line(*line, file)))
    if all(map(is_generated, names)):
        names = in_turn(names)
    if not names:
        raise MapError(f"the list of maps {file} names none")
    if count and not 1 <= int(count) <= len(names):
        raise MapError(f"{file} has 1 to {len(names)} maps, not {count}")
    return names[: int(count)] if count else names


def _lines(file: str) -> list[tuple[int, str]]:
    if not file:
        raise MapError("@ is followed by the path of a list of maps, as in @maps.txt")
    try:
        return listed_lines(Path(file))
    except FileNotFoundError:
        raise MapError(f"there is no list of maps {file}; `movingout demos prove --out {file}` makes one") from None
    except UnicodeDecodeError:
        raise MapError(f"the list of maps {file} is no text in UTF-8") from None
    except OSError as error:
        raise MapError(f"cannot read the list of maps {file}: {error.strerror or error}") from error


def _on_line(number: int, said: str, file: str) -> list[str]:
    name, _, ticks = said.rpartition(" ")
    if is_generated(name) and ticks.isdecimal():  # by `demos prove`: how long the pair of experts took
        said = name
    if said.startswith(LIST):
        raise MapError(f"{file}, line {number}: a list names no other list, such as {said}")
    try:
        names = _meant(said)
        if names == [said] and not is_generated(said) and os.sep not in said and not said.endswith(".json"):
            load_map(said)  # fail now: later nobody knows the line
    except MapError as error:
        raise MapError(f"{file}, line {number}: {error}") from error
    return names
