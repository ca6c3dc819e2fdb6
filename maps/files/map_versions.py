"""Different maps of one's own that have one name, as before and after a file was edited: NAME.1, NAME.2, ….

A variant belongs to the only map with its walls and goals; where there are two, it is of NAME.1+2. A map that ships, or
a generated one, is known by name.
"""

from collections import defaultdict
from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import replace

from movingout.maps.library import is_reserved
from movingout.maps.spec import MapSpec


def variant_family(the_map: MapSpec) -> Hashable:
    """What variants of a map have in common: name, walls and goals; the name alone where the map is known by it."""
    return the_map.name if is_reserved(the_map.name) else (the_map.name, the_map.walls, the_map.goals)


def designed_identity(the_map: MapSpec) -> Hashable:
    """A value that is the same for equal maps as designed."""
    family = variant_family(the_map)
    return family if is_reserved(the_map.name) else (family, the_map.robots, the_map.items)


def numbered_maps(played: Iterable[tuple[MapSpec, str]]) -> tuple[list[str], dict[str, list[str]]]:
    """The number of each map among those of its name, "" where there is one; and by such names the first files of each.

    Variants that may be of several maps have the numbers of all: "1+2".
    `played`: maps, each with a file in which it is.
    """
    listed = list(played)
    designed: defaultdict[Hashable, set[Hashable]] = defaultdict(set)
    for the_map, _ in listed:
        if not the_map.variant:
            designed[variant_family(the_map)].add(designed_identity(the_map))
    firsts: defaultdict[str, dict[Hashable, str]] = defaultdict(dict)
    for the_map, file in listed:
        versions = _versions(the_map, designed)
        if len(versions) == 1:
            firsts[the_map.name].setdefault(next(iter(versions)), file)
    several = {name: list(versions) for name, versions in firsts.items() if len(versions) > 1}
    numbers = [_number(several.get(the_map.name, []), _versions(the_map, designed)) for the_map, _ in listed]
    return numbers, {name: list(firsts[name].values()) for name in several}


def numbered_map(the_map: MapSpec, number: str) -> MapSpec:
    """The map as `NAME.2`, in its title as well; itself without a number."""
    if not number:
        return the_map
    return replace(the_map, name=f"{the_map.name}.{number}", title=f"{the_map.title}.{number}")


def one_name_sentence(name: str, firsts: Sequence[str]) -> str:
    """`2 different maps are called Den: Den.1 is that of a.mcap, Den.2 is that of b.mcap.`"""
    named = ", ".join(f"{name}.{number} is that of {file}" for number, file in enumerate(firsts, 1))
    return f"{len(firsts)} different maps are called {name}: {named}."


def _versions(the_map: MapSpec, designed: Mapping[Hashable, set[Hashable]]) -> set[Hashable]:
    """Of those with one name, the maps that this one may be, or be a variant of."""
    family = variant_family(the_map)
    return (designed.get(family) or {family}) if the_map.variant else {designed_identity(the_map)}


def _number(known: Sequence[Hashable], versions: Collection[Hashable]) -> str:
    return "+".join(str(number) for number, version in enumerate(known, 1) if version in versions)
