"""Whether partners and maps are met in both seats alike, over all that participants are to play."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from movingout.study.design.allocation import BLUE, RED, Assignment
from movingout.study.design.definition import Study
from movingout.study.design.sections.rounds import Block

UNEVEN = 0.25  # of the rounds with a partner on a map, as the difference between the seats


class PartnersBySeat(NamedTuple):
    """A block in which one partner is met in a seat in more rounds than another."""

    block: str
    rounds: tuple[tuple[str, int, int], ...]  # partner, rounds in blue, rounds in red

    def sentence(self, names: Mapping[str, str]) -> str:
        counts = ", ".join(f"{names.get(partner, partner)} {blue} and {red}" for partner, blue, red in self.rounds)
        return (
            f"block {self.block}: role and model are confounded: participants play in blue and in red with {counts} "
            "rounds; a difference between these models may be a difference between the seats"
        )


class MapBySeat(NamedTuple):
    """A block in which a map, or a partner on a map, is met in one seat much more than in the other."""

    block: str
    map: str
    partner: str  # "" where two people play together
    blue: int  # rounds
    red: int

    def sentence(self, names: Mapping[str, str]) -> str:
        whom = f" with {names.get(self.partner, self.partner)}" if self.partner else ""
        return (
            f"block {self.block}: map and seat are confounded: participants play {self.map}{whom} in blue and in red "
            f"{self.blue} and {self.red} rounds; a difference between maps may be a difference between the seats"
        )


def seat_imbalance(study: Study, orders: Sequence[Assignment], names: Mapping[str, str] | None = None) -> Iterator[str]:
    """What `uneven_seats` finds, as sentences. Partners are called by their `names`, without any by their ids."""
    return (one.sentence(names or {}) for one in uneven_seats(study, orders))


def uneven_seats(study: Study, orders: Sequence[Assignment]) -> Iterator[PartnersBySeat | MapBySeat]:
    """Blocks in which a partner is met in a seat in more rounds than another; a cut-off square has two maps more."""
    met = Counter(
        (visit.block, visit.partner, turn.seat) for one in orders for visit in one.visits for turn in visit.turns
    )
    for block in study.blocks:
        blue, red = ({name: met[block.id, name, seat] for name in block.partners} for seat in (BLUE, RED))
        if blue and max(blue.values()) - min(blue.values()) > 2 * block.rounds:
            yield PartnersBySeat(block.id, tuple((one, blue[one], red[one]) for one in block.partners))
    yield from _uneven_maps(study, orders)


def _uneven_maps(study: Study, orders: Sequence[Assignment]) -> Iterator[MapBySeat]:
    """Of each block with such maps the one where the seats differ most."""
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
            yield MapBySeat(block.id, name, partner, blue, red)


def _uneven(block: Block, blue: int, red: int) -> bool:
    """A cut-off square has two rounds more; who always has one seat, or draws maps by chance, was asked for."""
    difference = abs(blue - red)
    return (
        block.seats == "alternate"
        and block.map_order != "random"
        and difference > max(2 * block.rounds, UNEVEN * (blue + red))
    )
