"""What is to be said of map files of one's own before something is played or recorded on them."""

from collections.abc import Iterable

from movingout.maps.check import check_map
from movingout.maps.library import is_generated_or_shipped, is_reserved, load_map
from movingout.maps.spec import MapSpec

_MOST = 3  # faults in a sentence


def map_cautions(names: Iterable[str]) -> list[str]:
    """A sentence for each map file that has faults, and for each that goes by the name of a shipped map.

    `names` are names and paths of maps, with symmetries or without. Raises MapError for one that cannot be read.
    """
    own = [name for name in dict.fromkeys(names) if not is_generated_or_shipped(name)]
    return [sentence for name in own for sentence in (_faults(name), _borrowed_name(name)) if sentence]


def _faults(name: str) -> str:
    faults = [str(fault) for fault in check_map(load_map(name))]
    more = f"; and {len(faults) - _MOST} more, see `movingout maps check`" if len(faults) > _MOST else ""
    return f"{name} cannot be played as it should: {'; '.join(faults[:_MOST])}{more}" if faults else ""


def _played(the_map: MapSpec) -> tuple[object, ...]:
    return the_map.robots, the_map.walls, the_map.goals, the_map.items


def _borrowed_name(name: str) -> str:
    the_map = load_map(name)
    if not is_reserved(the_map.name) or _played(the_map) == _played(load_map(the_map.name)):
        return ""
    return (
        f"{name} is another map than the shipped one of its name, {the_map.name}, and would be taken for that in "
        'recordings, reports and training; change "name" in the file'
    )
