"""Which blocks a report may count together: what they ask of people, and on which maps partners are met in them."""

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from fractions import Fraction
from typing import TypeVar

from movingout.study.design.definition import Study
from movingout.study.design.sections.rounds import Block

Key = TypeVar("Key")


def pooled_blocks(study: Study) -> list[list[str]]:
    """The ids of blocks that ask the same of people, together; apart where partners are met on different maps."""
    return [[block.id for block in blocks] for alike in _alike(study) for blocks in _with_same_maps(alike)]


def apart_by_maps(study: Study) -> list[list[str]]:
    """The ids of blocks that would be pooled if all partners were met on the same maps in them."""
    return [[block.id for block in alike] for alike in _alike(study) if len(_with_same_maps(alike)) > 1]


def are_seats_crossed(study: Study, blocks: Collection[str]) -> bool:
    """Whether each participant meets all partners of these blocks in the same shares of maps and seats."""
    met: dict[str, Counter[tuple[str, str]]] = defaultdict(Counter)
    for block in (one for one in study.blocks if one.id in blocks):
        if block.seats == "alternate":
            return False
        for seat in ("blue", "red") if block.seats == "both" else (block.seats,):
            for partner in block.partners or ("",):
                met[partner].update({(name, seat): block.rounds for name in block.maps})
    return len({_shares(counts) for counts in met.values()}) == 1


def are_partners_in_same_blocks(study: Study, blocks: Collection[str]) -> bool:
    """Whether each of these blocks has the same partners."""
    return len({frozenset(block.partners) for block in study.blocks if block.id in blocks}) == 1


def _alike(study: Study) -> list[list[Block]]:
    conditions: dict[tuple[object, ...], list[Block]] = defaultdict(list)
    for block in study.blocks:
        conditions[block.challenge, block.pings, block.limit_ticks].append(block)
    return list(conditions.values())


def _with_same_maps(blocks: Sequence[Block]) -> list[list[Block]]:
    """All, where each partner is met on the same maps in the same shares of the rounds; else those of equal maps."""
    met: dict[str, Counter[str]] = defaultdict(Counter)
    by_maps: dict[frozenset[tuple[str, Fraction]], list[Block]] = defaultdict(list)
    for block in blocks:
        maps = Counter(block.maps)
        by_maps[_shares(maps)].append(block)
        rounds = block.rounds * (2 if block.seats == "both" else 1)
        for partner in block.partners or ("",):
            met[partner].update({name: times * rounds for name, times in maps.items()})
    return [[*blocks]] if len({_shares(counts) for counts in met.values()}) == 1 else list(by_maps.values())


def _shares(counts: Mapping[Key, int]) -> frozenset[tuple[Key, Fraction]]:
    total = sum(counts.values())
    return frozenset((name, Fraction(number, total)) for name, number in counts.items())
