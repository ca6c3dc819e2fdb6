"""Allocation: balanced over partners, seats, positions and maps, whoever drops out."""

from collections import Counter
from itertools import pairwise
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from movingout.study.design.allocation import assign, cells, letters, next_slot
from movingout.study.design.definition import Study
from movingout.study.design.review import review
from movingout.study.design.steps import planned_seconds, steps
from movingout.study.design.study_file import parse_study
from movingout.study.design.templates import template_names, template_text
from tests.study.design.small_study import SMALL


def template(name: str) -> Study:
    return parse_study(template_text(name))


def counts_of(study: Study, slots: range) -> dict[str, Counter[tuple[object, ...]]]:
    """How often each partner, map and seat met in each position."""
    found: dict[str, Counter[tuple[object, ...]]] = {
        "partner, position": Counter(),
        "partner, next partner": Counter(),
        "partner, seat": Counter(),
        "partner, map, seat": Counter(),
        "map, position": Counter(),
        "first seat, first partner": Counter(),
    }
    for slot in slots:
        visits = assign(study, slot).visits
        found["first seat, first partner"][visits[0].turns[0].seat, visits[0].partner] += 1
        for place, visit in enumerate(visits):
            found["partner, position"][visit.partner, place] += 1
            if place:
                found["partner, next partner"][visits[place - 1].partner, visit.partner] += 1
            for position, turn in enumerate(visit.turns):
                found["partner, seat"][visit.partner, turn.seat] += 1
                found["partner, map, seat"][visit.partner, turn.map, turn.seat] += 1
                found["map, position"][turn.map, position] += 1
    return found


@pytest.mark.parametrize("name", ["partner, position", "partner, next partner", "partner, seat", "map, position"])
def test_the_recommended_study_is_balanced_after_as_many_participants_as_check_says(name: str) -> None:
    study = template("human_study")
    found = counts_of(study, range(cells(study)))[name]
    assert len(set(found.values())) == 1, found


def test_seats_cross_with_models_and_maps_fully_with_twice_the_planned_participants_and_nearly_with_them() -> None:
    study = template("human_study")
    full, planned = counts_of(study, range(96)), counts_of(study, range(study.participants))
    for name in ("partner, map, seat", "first seat, first partner"):
        assert len(set(full[name].values())) == 1, name
    nearly = planned["partner, map, seat"].values()
    assert max(nearly) - min(nearly) <= 4  # of 24


def test_everybody_plays_each_map_once_with_each_partner_and_changes_seats_from_map_to_map() -> None:
    study = template("human_study")
    for visit in assign(study, 17).visits:
        assert sorted(turn.map for turn in visit.turns) == sorted(study.blocks[0].maps)
        seats = [turn.seat for turn in visit.turns]
        assert all(seat != after for seat, after in pairwise(seats))


def test_a_pair_plays_each_map_three_times_swaps_and_plays_it_three_times_more() -> None:
    visit = assign(template("collect"), 0).visits[0]
    first = [turn for turn in visit.turns if turn.map == visit.turns[0].map]
    assert [turn.number for turn in first] == [1, 2, 3, 4, 5, 6]
    assert [turn.seat for turn in first] in ([0, 0, 0, 1, 1, 1], [1, 1, 1, 0, 0, 0])
    assert visit.turns[:6] == tuple(first)


def test_randomised_maps_are_new_in_every_round_and_for_every_pair_where_fresh_is_asked_for() -> None:
    study = template("collect")
    seeds = [turn.variant_seed for slot in range(18) for turn in assign(study, slot).visits[1].turns]
    assert None not in seeds and len(set(seeds)) == len(seeds)
    assert all(turn.variant_seed is None for turn in assign(study, 0).visits[0].turns)


def test_the_same_slot_is_the_same_assignment_anywhere_and_another_seed_another_one() -> None:
    study = template("human_study_as_published")
    again = parse_study(template_text("human_study_as_published"))
    other = study.model_copy(update={"seed": 2})
    assert [assign(study, slot) for slot in range(9)] == [assign(again, slot) for slot in range(9)]
    assert [assign(study, slot) for slot in range(9)] != [assign(other, slot) for slot in range(9)]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 1 << 32), loss=st.floats(0.0, 0.8), planned=st.integers(1, 48))
def test_slots_of_those_who_drop_out_are_filled_again_so_that_the_planned_ones_are_done(
    seed: int, loss: float, planned: int
) -> None:
    random, held, running, done = Random(seed), set[int](), list[int](), set[int]()
    while len(done) < planned:
        if len(held) < planned and (not running or random.random() < 0.5):
            running.append(next_slot(held))
            held.add(running[-1])
            continue
        slot = running.pop(random.randrange(len(running)))
        if random.random() < loss:
            held.remove(slot)
        else:
            done.add(slot)
    assert done == set(range(planned))


def test_letters_hide_the_order_of_the_file_and_stay_the_same() -> None:
    study = template("human_study")
    assert sorted(letters(study).values()) == ["Partner A", "Partner B", "Partner C", "Partner D"]
    assert list(letters(study)) != [partner.id for partner in study.partners]
    assert letters(template("human_study_as_published"))["dp"] == "Partner A"


@pytest.mark.parametrize("name", template_names())
def test_the_way_begins_with_consent_ends_with_a_code_and_its_keys_are_unique_and_stable(name: str) -> None:
    study = template(name)
    way = steps(study, assign(study, 3))
    keys = [step.key for step in way]
    assert (way[0].kind, way[-1].kind) == ("consent", "code")
    assert len(set(keys)) == len(keys)
    assert keys == [step.key for step in steps(template(name), assign(study, 3))]


def test_a_block_with_a_limit_in_minutes_is_planned_with_that_limit() -> None:
    study = template("collect")
    block = tuple(step for step in steps(study, assign(study, 0)) if step.block == "fixed-maps")
    assert planned_seconds(block) == 50 * 60, "with its break"
    assert len([step for step in block if step.turn]) == 72, "all of them, for whoever is faster"


def test_the_limit_of_a_block_is_for_all_its_partners_together() -> None:
    """As the server counts; the questions about somebody whom they do not meet are not asked."""
    text = SMALL.replace("- id: play", "- id: play\n    limit_minutes: 1.5")
    limited, whole = (parse_study(one) for one in (text, SMALL))
    block = [step for step in steps(limited, assign(limited, 0)) if step.block]
    assert [step.seconds for step in block if step.turn] == [60, 30, 0, 0]
    assert [step.seconds > 0 for step in block if step.kind == "questionnaire"] == [True, False]
    (warning,) = set(review(limited).warnings) - set(review(whole).warnings)
    assert warning.startswith("block play: limit_minutes ends it after 1.5 minutes with all partners together, and its")
    assert review(limited).minutes < review(whole).minutes
    enough = parse_study(text.replace("1.5", "10"))
    assert review(enough).warnings == review(whole).warnings
