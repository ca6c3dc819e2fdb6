"""Who plays what with whom, when and in which seat: a function of the study and a slot.

Slots are numbered from 0. Each participant (or pair) has one; when they drop out, it goes to the next who comes
(`next_slot`), so that a finished study has all the planned slots, and orders, roles and maps are balanced as
designed. Who plays with an agent in a partner's place has one beyond them. Everything is deterministic: the same study
and slot always give the same assignment.

By rule 3, after as many slots as `cells` says, each partner is met on each map in both seats equally often, and at each
place among the maps; each map comes equally often at each place of a session; and who begins in blue meets each partner
equally often at each place. Studies that have begun by an earlier rule keep it. By rule 2 seats went by the place of a
partner, and maps and seats could move in step. Rule 1 also crossed the factors of all blocks, one after the other, so
that those of later blocks moved in step over hundreds of slots.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import count
from math import gcd, lcm
from random import Random
from string import ascii_uppercase
from typing import TypeVar

from movingout.study.design.definition import Study
from movingout.study.design.latin_squares import crossed, williams
from movingout.study.design.sections.rounds import Block, Order

BLUE, RED = 0, 1
BY_PARTNER = 3  # the first rule by which rows of maps and seats go by the partner, not by its place
Entry = TypeVar("Entry")


@dataclass(frozen=True, slots=True)
class Turn:
    """One round to be played."""

    map: str
    seat: int  # 0 blue, 1 red: of the participant, or of the first of two
    number: int  # of this map with this partner in this block, from 1
    variant_seed: int | None  # None: the map as designed


@dataclass(frozen=True, slots=True)
class Visit:
    """All rounds with one partner in a row; `partner` is "" where two people play together."""

    block: str
    partner: str
    turns: tuple[Turn, ...]


@dataclass(frozen=True, slots=True)
class Assignment:
    """All rounds of a slot."""

    slot: int
    visits: tuple[Visit, ...]


def next_slot(held: Collection[int], first: int = 0) -> int:
    """The lowest free slot from `first` on; participants who dropped out hold none."""
    return next(slot for slot in count(first) if slot not in held)


def assign(study: Study, slot: int) -> Assignment:
    """The assignment of a slot."""
    visits: list[Visit] = []
    for number, (block, (begins, partner_row, map_row)) in enumerate(
        zip(study.blocks, _drawn(study, slot), strict=True)
    ):
        partners = _ordered(block.partners or ("",), block.partner_order, partner_row, f"{study.seed} {slot} {number}")
        for place, partner in enumerate(partners):
            own = place if study.allocation < BY_PARTNER else (block.partners or ("",)).index(partner)
            draw = f"{study.seed} {slot} {number} {place}"
            maps = _ordered(block.maps, block.map_order, map_row + own * _stride(study, block), draw)
            turns = [
                turn
                for index, name in enumerate(maps)
                for turn in _turns(study, block, slot, partner, name, (begins + own + index) % 2)
            ]
            visits.append(Visit(block.id, partner, tuple(turns)))
    return Assignment(slot, tuple(visits))


def letters(study: Study) -> dict[str, str]:
    """The displayed name of each partner: Partner A, Partner B, ..."""
    ids = [partner.id for partner in study.partners]
    if study.shuffle_letters:
        Random(f"letters {study.seed} {study.id}").shuffle(ids)
    return {name: f"Partner {_letter(index)}" for index, name in enumerate(ids)}


def cells(study: Study) -> int:
    """How many slots it takes until every order of partners and of maps has come up equally often with either start."""
    return lcm(*(begins * lcm(partners, maps) for begins, partners, maps in map(_levels, study.blocks)))


def _drawn(study: Study, slot: int) -> list[tuple[int, ...]]:
    """For each block who begins in blue, and the rows of its partners and maps, which move on from block to block."""
    levels = [_levels(block) for block in study.blocks]
    if study.allocation == 1:
        drawn = crossed(slot, [count for counts in levels for count in counts])
        return [drawn[at : at + 3] for at in range(0, len(drawn), 3)]
    if study.allocation < BY_PARTNER:
        within = [crossed(slot, counts) for counts in levels]
        return [(begins, partners + number, maps + number) for number, (begins, partners, maps) in enumerate(within)]
    return [_row(slot, number, counts) for number, counts in enumerate(levels)]


def _row(slot: int, number: int, levels: tuple[int, int, int]) -> tuple[int, int, int]:
    """Who begins, and the rows: the pairs of a row of partners and one of maps in turn, each with either beginning.

    A lap has each row of partners once, or each of maps where partners have one; the next lap has the same pairs again
    with the other beginning. Where the rows of both have common factors, later laps shift one against the other.
    """
    begins, partners, maps = levels
    length = partners if partners > 1 else maps
    lap, step = divmod(slot, length)
    pair = step + length * (lap // begins)
    shift = pair // lcm(partners, maps)
    return step + lap + number, pair + number, pair + shift + number


def _stride(study: Study, block: Block) -> int:
    """How many rows of maps lie between one partner and the next.

    By rule 3 their common factor: by it rows of partners and of maps move in step, and with any other number some maps
    would come more often at some places of a session.
    """
    _, partners, maps = _levels(block)
    return gcd(partners, maps) if study.allocation >= BY_PARTNER else 1


def _levels(block: Block) -> tuple[int, int, int]:
    """The number of choices of: who begins in blue, order of partners, order of maps."""
    begins = 2 if block.seats in ("alternate", "both") else 1
    partners = len(williams(len(block.partners))) if block.partner_order == "balanced" and block.partners else 1
    maps = len(williams(len(block.maps))) if block.map_order == "balanced" else 1
    return begins, partners, maps


def _ordered(entries: Sequence[Entry], order: Order, row: int, draw: str) -> list[Entry]:
    if order == "balanced":
        square = williams(len(entries))
        return [entries[index] for index in square[row % len(square)]]
    chosen = list(entries)
    if order == "random":
        Random(draw).shuffle(chosen)
    return chosen


def _turns(study: Study, block: Block, slot: int, partner: str, map_name: str, first: int) -> list[Turn]:
    seats = {"blue": (BLUE,), "red": (RED,), "alternate": (first,), "both": (first, 1 - first)}[block.seats]
    turns = []
    for number, seat in enumerate((seat for seat in seats for _ in range(block.rounds)), 1):
        parts = [study.id, str(study.seed), block.id, map_name, str(number)]
        parts += [str(slot), partner] if block.variants == "fresh" else []
        turns.append(Turn(map_name, seat, number, _seed(parts) if block.challenge == 2 else None))
    return turns


def _seed(parts: Sequence[str]) -> int:
    return int.from_bytes(sha256("\n".join(parts).encode()).digest()[:4], "big")


def _letter(index: int) -> str:
    return ascii_uppercase[index] if index < len(ascii_uppercase) else f"{index + 1}"
