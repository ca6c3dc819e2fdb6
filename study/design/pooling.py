"""Which blocks a report may count together: what they ask of people, and on which maps partners are met in them."""

from collections import defaultdict
from collections.abc import Sequence

from movingout.study.design.definition import Block, Study


def pooled_blocks(study: Study) -> list[list[str]]:
    """The ids of blocks that ask the same of people, together; apart where partners are met on different maps."""
    return [[block.id for block in blocks] for alike in _alike(study) for blocks in _with_same_maps(alike)]


def apart_by_maps(study: Study) -> list[list[str]]:
    """The ids of blocks that would be pooled if all partners were met on the same maps in them."""
    return [[block.id for block in alike] for alike in _alike(study) if len(_with_same_maps(alike)) > 1]


def _alike(study: Study) -> list[list[Block]]:
    conditions: dict[tuple[object, ...], list[Block]] = defaultdict(list)
    for block in study.blocks:
        conditions[block.challenge, block.pings, block.limit_ticks].append(block)
    return list(conditions.values())


def _with_same_maps(blocks: Sequence[Block]) -> list[list[Block]]:
    """All, where each partner is met on the same maps; else those with the same maps together."""
    met: dict[str, set[str]] = defaultdict(set)
    by_maps: dict[frozenset[str], list[Block]] = defaultdict(list)
    for block in blocks:
        by_maps[frozenset(block.maps)].append(block)
        for partner in block.partners or ("",):
            met[partner].update(block.maps)
    return [[*blocks]] if len(set(map(frozenset, met.values()))) == 1 else list(by_maps.values())
