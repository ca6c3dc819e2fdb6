"""What is to be said of map files of one's own before something is played or recorded on them."""

import math
from collections.abc import Iterable, Iterator, Mapping

from movingout.maps.check import MapFault, check_map, unreachable_goals
from movingout.maps.errors import MapError
from movingout.maps.flood_fill import CELL, OVERLAP, PAPER_CELLS, overlapped
from movingout.maps.generated.names import PREFIX
from movingout.maps.library import is_generated_or_shipped, is_reserved, load_map
from movingout.maps.packing import is_home
from movingout.maps.solid import item_solid
from movingout.maps.spec import ARENA_HALF, ROBOT_RADIUS, SEAT_COLOURS, MapSpec, Pose
from movingout.maps.symmetry import SEPARATOR, split_name

_MOST = 3  # faults or hints in a sentence
_WORDS: Mapping[str, str] = {"all": "the paper's twelve maps", PREFIX: "maps of the generator"}


def map_cautions(names: Iterable[str]) -> list[str]:
    """A sentence for each map file that has faults, and for each that has hints (`map_hints`).

    `names` are names and paths of maps, with symmetries or without. Raises MapError for one that cannot be read.
    """
    own = [name for name in dict.fromkeys(names) if not is_generated_or_shipped(name)]
    return [sentence for name in own for sentence in _about(name) if sentence]


def map_hints(name: str) -> tuple[MapFault, ...]:
    """What in a map probably means something else than its author thinks, though it can be played.

    Of a map after symmetries, the map as designed is looked at. Raises MapError for one that cannot be read.
    """
    return hints_on(load_map(split_name(name)[0]))


def hints_on(spec: MapSpec) -> tuple[MapFault, ...]:
    """The same of a map that has been read.

    That is a name that commands understand otherwise, a number of the paper's maps, angles [rad] of more than a turn,
    items that are delivered before anybody moves or lie half in a goal, walls that distances lead through, and goals
    that only items can get to.
    """
    return (
        *_misunderstood_name(spec),
        *_misunderstood_number(spec),
        *_angles_in_degrees(spec),
        *_in_a_goal_from_the_start(spec),
        *_walls_without_a_cell(spec),
        *_goals_without_a_robot(spec),
    )


def _about(file: str) -> Iterator[str]:
    yield _joined(f"{file} cannot be played as it should", check_map(load_map(file)))
    yield _joined(file, map_hints(file))


def _joined(beginning: str, found: tuple[MapFault, ...]) -> str:
    more = f"; and {len(found) - _MOST} more, see `movingout maps check`" if len(found) > _MOST else ""
    return f"{beginning}: {'; '.join(map(str, found[:_MOST]))}{more}" if found else ""


def _misunderstood_name(spec: MapSpec) -> Iterator[MapFault]:
    base, symmetries = split_name(spec.name)
    if base in _WORDS:
        message = f"{base} means {_WORDS[base]} where maps are named; choose another name"
        yield MapFault("name", message, "name_understood", {"name": spec.name})
    elif is_reserved(spec.name):
        if not is_shipped_as(spec):
            whose = "is the name of a generated map" if base.startswith(f"{PREFIX}:") else "is a shipped map"
            message = (
                f"{spec.name} {whose}, and this is another one, which recordings, reports and training would "
                "take for that; choose another name"
            )
            yield MapFault("name", message, "name_taken", {"name": spec.name})
    elif symmetries:
        message = f"{spec.name} means the map {base}, mirrored or turned; choose a name without {SEPARATOR}"
        yield MapFault("name", message, "name_understood", {"name": spec.name})


def _misunderstood_number(spec: MapSpec) -> Iterator[MapFault]:
    """A number decides how a variant for Challenge 2 is drawn; under a shipped map's name it is that map's own."""
    if spec.number and not is_reserved(split_name(spec.name)[0]):
        message = "numbers are those of the paper's maps; write 0 for a map of your own"
        yield MapFault("number", message, "paper_number", {"number": spec.number})


def is_shipped_as(spec: MapSpec) -> bool:
    """Whether the map that comes with the project under this name is played alike."""
    try:
        return _played(spec) == _played(load_map(spec.name))
    except MapError:
        return False


def _played(spec: MapSpec) -> tuple[object, ...]:
    return spec.robots, spec.walls, spec.goals, spec.items


def _angles_in_degrees(spec: MapSpec) -> Iterator[MapFault]:
    for path, pose in _poses(spec):
        if abs(pose.angle) > math.tau:
            meant = math.radians(math.fmod(pose.angle, 360.0)) + 0.0  # within a turn; no -0
            message = f"angles are radians; if {pose.angle:g} degrees are meant, write {meant:.4f}"
            yield MapFault(f"{path}.angle", message, "degrees", {"angle": pose.angle})


def _in_a_goal_from_the_start(spec: MapSpec) -> Iterator[MapFault]:
    goal = overlapped(spec.goals) & ~overlapped(spec.walls)
    for index, item in enumerate(spec.items):
        if is_home(item_solid(item).box, spec.goals):
            message = "lies in a goal from the start and counts as delivered; move it out"
            yield MapFault(f"items[{index}]", message, "delivered")
        elif goal[_cell(item.pose.x), _cell(item.pose.y)]:
            message = "sticks out of a goal with its centre in it: not delivered, and no way to go in NFD; move it"
            yield MapFault(f"items[{index}]", message, "sticks_out")


def _walls_without_a_cell(spec: MapSpec) -> Iterator[MapFault]:
    least = 2 * OVERLAP
    for index, wall in enumerate(spec.walls):
        if not overlapped([wall]).any():
            message = f"is too thin for NFD, whose ways lead through it; make it thicker than {least}"
            yield MapFault(f"walls[{index}]", message, "thin_wall", {"least": least})


def _goals_without_a_robot(spec: MapSpec) -> Iterator[MapFault]:
    width = 2 * ROBOT_RADIUS
    for index in unreachable_goals(spec):
        message = f"no robot can get to it, so that items could only be pushed in; widen a way to more than {width}"
        yield MapFault(f"goals[{index}]", message, "goal_unreachable", {"width": width})


def _cell(along: float) -> int:
    """Column or row of a coordinate."""
    return min(max(math.floor((along + ARENA_HALF) / CELL), 0), PAPER_CELLS - 1)


def _poses(spec: MapSpec) -> Iterator[tuple[str, Pose]]:
    for colour, pose in zip(SEAT_COLOURS, spec.robots, strict=True):
        yield f"robots.{colour}", pose
    for index, item in enumerate(spec.items):
        yield f"items[{index}]", item.pose
