"""Partners on maps and seats cross at the numbers that `check` calls complete, and what does not is warned of."""

from collections import Counter
from itertools import product

import pytest

from movingout.maps.library import map_names
from movingout.study.design.allocation import assign, cells
from movingout.study.design.balance import seat_imbalance
from movingout.study.design.definition import Study
from movingout.study.design.study_file import parse_study

HEAD = """\
format: 1
id: balance
title: Balance
participants: 24
consent: {version: "1", text: We record how you play.}
debrief: {text: They were programs.}
"""
AGENTS = ("scripted", "greedy", "porter", "idle", "novice", "person")
DESIGNS = [*product((1, 2, 3, 4, 6), (1, 2, 3, 4, 8, 12)), (5, 2), (5, 3), (5, 5)]


def study(partners: int, maps: int, options: str = "", blocks: int = 1) -> Study:
    names = "abcdef"[:partners]
    met = ", ".join(f"{{id: {name}, agent: {agent}}}" for name, agent in zip(names, AGENTS, strict=False))
    places = f"partners: [{', '.join(names)}], maps: [{', '.join(map_names()[:maps])}]"
    written = "".join(f"  - {{id: block-{number}, {places}{options}}}\n" for number in range(blocks))
    return parse_study(f"{HEAD}partners: [{met}]\nblocks:\n{written}")


def met_in(of: Study, slots: int) -> dict[str, Counter[tuple[object, ...]]]:
    """How often each combination comes up."""
    found: dict[str, Counter[tuple[object, ...]]] = {
        "partner, map, seat": Counter(),
        "partner, map, position": Counter(),
        "partner, place, seat at first": Counter(),
        "place, map, position": Counter(),
    }
    for slot in range(slots):
        for place, visit in enumerate(assign(of, slot).visits):
            at_first = visit.block, visit.partner, place, visit.turns[0].seat
            found["partner, place, seat at first"][at_first] += 1
            for position, turn in enumerate(visit.turns):
                found["partner, map, seat"][visit.block, visit.partner, turn.map, turn.seat] += 1
                found["partner, map, position"][visit.block, visit.partner, turn.map, position] += 1
                found["place, map, position"][visit.block, place, turn.map, position] += 1
    return found


@pytest.mark.parametrize(("partners", "maps"), DESIGNS)
def test_each_partner_is_met_on_each_map_in_both_seats_as_often(partners: int, maps: int) -> None:
    of = study(partners, maps)
    of_each = {"partner, map, seat": 2 * maps, "partner, place, seat at first": 0}
    of_each |= dict.fromkeys(("partner, map, position", "place, map, position"), maps**2)
    for name, counts in met_in(of, cells(of)).items():
        assert len(set(counts.values())) == 1, name
        assert not of_each[name] or len(counts) == partners * of_each[name], name
    assert not list(seat_imbalance(of, [assign(of, slot) for slot in range(cells(of))]))


@pytest.mark.parametrize("options", [", partner_order: random", ", partner_order: fixed", ", map_order: fixed"])
def test_so_it_is_whatever_else_is_not_balanced_and_in_every_block(options: str) -> None:
    of = study(3, 2, options, blocks=2)
    assert len(set(met_in(of, cells(of))["partner, map, seat"].values())) == 1


def test_by_the_second_rule_a_map_could_have_one_seat_and_is_warned_of() -> None:
    of = study(3, 2).allocated_by(2)
    orders = [assign(of, slot) for slot in range(12)]
    (warning,) = seat_imbalance(of, orders, {"a": "Partner C"})
    first = map_names()[0]
    assert warning.startswith(
        f"block block-0: map and seat are confounded: participants play {first} with Partner C in blue and in red "
    )
    fixed = study(3, 2, ", seats: blue")
    assert not list(seat_imbalance(fixed, [assign(fixed, slot) for slot in range(12)])), "it was asked for"


def test_a_random_order_of_maps_is_no_fault_of_the_design() -> None:
    random = study(2, 4, ", map_order: random")
    assert not [
        one for slots in range(1, 65) for one in seat_imbalance(random, [assign(random, n) for n in range(slots)])
    ]


def test_a_study_that_stops_early_has_used_as_many_orders_as_it_could() -> None:
    pairs = study(1, 12)
    assert len({tuple(turn.map for turn in assign(pairs, slot).visits[0].turns) for slot in range(12)}) == 12
