"""The generated maps that are known to be playable: on each, a pair of scripted experts delivered everything in time.

Each split has a text file here, one map per line: its name and the ticks that the pair needed. `movingout demos prove`
writes such files; lines are only ever added, so that a count of maps always means the same ones. On four of the maps
it was the expert of another version that delivered everything; there the ticks are that one's.
"""

from functools import lru_cache
from itertools import zip_longest
from pathlib import Path

from movingout.maps.errors import MapError
from movingout.maps.generated.names import MODE_WORDS, SPLITS, Split, read_name, split_of
from movingout.maps.suggestion import known_names

_FOLDER = Path(__file__).parent


def table_path(split: Split) -> Path:
    """The shipped file of a split."""
    return _FOLDER / f"{split}.txt"


def read_table(path: Path) -> dict[str, int]:
    """Names of maps and the ticks that the pair needed, in the order of the file; an absent file has none.

    Raises MapError for a file of something else.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise MapError(f"cannot read the list of maps {path}: {error}") from error
    found = {}
    for number, line in enumerate(lines, start=1):
        name, _, ticks = line.partition(" ")
        if not ticks.isdecimal():
            raise MapError(f"{path}, line {number}: a name and a number of ticks are needed, not {line[:60]!r}")
        read_name(name)
        found[name] = int(ticks)
    return found


@lru_cache(maxsize=8)
def proved_maps(split: str, count: int | None = None) -> tuple[str, ...]:
    """Names of the first `count` proved maps of a split (default: all), the modes in turn.

    Raises MapError for another split, or when there are fewer.
    """
    known = {str(one): one for one in SPLITS}
    if split not in known:
        raise MapError(f"unknown maps generated:{split}; {known_names(split, known)}")
    names = in_turn(list(read_table(table_path(known[split]))))
    if count is not None and not 1 <= count <= len(names):
        raise MapError(f"generated:{split} has 1 to {len(names)} maps, not {count}; `movingout demos prove` finds more")
    return tuple(names[:count])


def ticks_needed(name: str) -> int | None:
    """How long the pair took on a map of a name without symmetry; None where it is not known to be playable."""
    return read_table(table_path(split_of(read_name(name)[1]))).get(name)


def in_turn(names: list[str]) -> list[str]:
    """Names with the modes in turn, each mode in the given order."""
    groups = [[name for name in names if name.split(":")[1] == word] for word in MODE_WORDS.values()]
    return [name for row in zip_longest(*groups) for name in row if name is not None]
