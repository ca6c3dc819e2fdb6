"""Whether partners and maps are met in both seats alike, over all that participants are to play."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from movingout.study.design.allocation import BLUE, RED, Assignment
from movingout.study.design.definition import Block, Study

UNEVEN = 0.25  # of the rounds with a partner on a map, as the difference between the seats


def seat_imbalance(study: Study, orders: Sequence[Assignment], names: Mapping[str, str] | None = None) -> Iterator[str]:
    """Blocks in which a partner is met in a seat in more rounds than another; a cut-off square has two maps more.

    Partners are called by their `names`, without any by their ids.
    """
    met = Counter(
        (visit.block, visit.partner, turn.seat) for one in orders for visit in one.visits for turn in visit.turns
    )
    for block in study.blocks:
        blue, red = ({name: met[block.id, name, seat] for name in block.partners} for seat in (0, 1))
        if blue and max(blue.values()) - min(blue.values()) > 2 * block.rounds:
            counts = ", ".join(f"{(names or {}).get(one, one)} {blue[one]} and {red[one]}" for one in block.partners)
            yield (
                f"block {block.id}: role and model are confounded: participants play in blue and in red with {counts} "
                "rounds; a difference between these models may be a difference between the seats"
            )
    yield from _map_imbalance(study, orders, names or {})


def _map_imbalance(study: Study, orders: Sequence[Assignment], names: Mapping[str, str]) -> Iterator[str]:
    """Blocks in which a map, or a partner on a map, is met in one seat much more than in the other."""
    met = Counter(
        (visit.block, visit.partner, turn.map, turn.seat)
        for one in orders
        for visit in one.visits
        for turn in visit.turns
    )
    for block in study.blocks:
        seats = {
            (partner, name): (met[block.id, partner, name, BLUE], met[block.id, partner, name, RED])
            for partner in block.partners or ("",)
            for name in dict.fromkeys(block.maps)
        }
        uneven = {pair: counts for pair, counts in seats.items() if _uneven(block, *counts)}
        if uneven:
            (partner, name), (blue, red) = max(uneven.items(), key=lambda one: abs(one[1][0] - one[1][1]))
            whom = f" with {names.get(partner, partner)}" if partner else ""
            yield (
                f"block {block.id}: map and seat are confounded: participants play {name}{whom} in blue and in red "
                f"{blue} and {red} rounds; a difference between maps may be a difference between the seats"
            )


def _uneven(block: Block, blue: int, red: int) -> bool:
    """A cut-off square has two rounds more; who always has one seat, or draws maps by chance, was asked for."""
    difference = abs(blue - red)
    return (
        block.seats == "alternate"
        and block.map_order != "random"
        and difference > max(2 * block.rounds, UNEVEN * (blue + red))
    )
