"""What the report pools: blocks that ask the same of people, and answers that were given on the same occasion."""

from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import update

from movingout.study.analysis.page import page
from movingout.study.analysis.pings import PingRound
from movingout.study.analysis.results import Results, collect
from movingout.study.analysis.tables import (
    metric_comparisons,
    order_effects,
    performance,
    performance_by_map,
    pings,
    pings_by_participant,
    rating_comparisons,
    ratings,
)
from movingout.study.design.definition import SUBSTITUTE
from movingout.study.store.rounds import PlayerOutcome, RoundOutcome, Rounds
from movingout.study.store.tables import rounds
from tests.study.filled import fill, template
from tests.study.support import agree, rounds_of

FORM = "movingout-paper-nine"
TWO_BLOCKS = {"maps: all": "maps: [HandOff]", "rounds: 3": "rounds: 1"}
PINGS = {"  - id: as-blue\n": "  - id: as-blue\n    pings: on\n", "maps: all": "maps: [HandOff]"}


def plain(partner: str) -> str:
    return partner or "another"


def two_blocks(folder: Path, **changes: str) -> Results:
    """People who meet the same partners in two blocks, and rate them after both."""
    small, text = template("human_study_as_published", **{"partners: [mlp, gru]": "partners: [dp, bass]"}, **changes)
    place, store, _ = fill(folder, small, text, 6)
    with store.database.write() as connection:
        connection.execute(update(rounds).where(rounds.c.block == "as-red").values(tcr=1.0))
        connection.execute(update(rounds).where(rounds.c.block == "as-blue").values(tcr=0.0))
    return collect(small, store, place.recordings)


@pytest.fixture(scope="module")
def apart(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return two_blocks(tmp_path_factory.mktemp("data"), **PINGS)


def test_challenges_are_not_pooled(tmp_path: Path) -> None:
    small, text = template("collect", **TWO_BLOCKS)
    place, store, _ = fill(tmp_path, small, text, 2)
    with store.database.write() as connection:
        connection.execute(update(rounds).values(tcr=1.0))
        connection.execute(update(rounds).where(rounds.c.variant_seed.is_not(None)).values(tcr=0.0))
    found = collect(small, store, place.recordings)
    table, by_map = performance(found, plain), performance_by_map(found, plain)
    assert table.heads[:3] == ("Block", "Partner", "rounds") and table.words == 2
    assert [row[:4] for row in table.rows] == [
        ("fixed-maps", "another", "2", "1.000 ± 0.000"),
        ("randomized-maps", "another", "1", "0.000"),
    ]
    assert [row[:3] for row in by_map.rows] == [
        ("fixed-maps", "HandOff", "another"),
        ("randomized-maps", "HandOff", "another"),
    ]
    assert "<h3>TCR ↑ (randomized-maps)</h3>" in page(found, plain, "about")


def test_rounds_with_and_without_pings_are_compared_apart(apart: Results) -> None:
    partners = len(apart.partners)
    assert [row[3] for row in performance(apart, plain).rows] == [
        *["1.000 ± 0.000"] * partners,
        *["0.000 ± 0.000"] * partners,
    ]
    compared, rated = metric_comparisons(apart, plain), rating_comparisons(apart, plain)
    assert compared.heads[:3] == ("Block", "Measure", "Partners") and compared.words == 3
    for table in (compared, rated):
        assert {row[0] for row in table.rows} == {"as-red", "as-blue"}
    assert {row[3] for row in compared.rows if row[1] == "TCR ↑"} == {"+0.000"}
    assert [row[1] for row in order_effects(apart).rows].count("TCR ↑") == 0, "constant within each block"


def test_pings_are_counted_within_blocks_that_may_be_pooled(apart: Results) -> None:
    people = [PingRound("P1", "dp", (), block) for block in ("as-red", "as-blue", "as-blue")]
    found = replace(apart, pings=tuple(people))
    table, by_participant = pings(found, plain), pings_by_participant(found)
    assert table.heads[:3] == ("Block", "Partner", "Asked by") and table.words == 3
    assert [row[:4] for row in table.rows] == [
        ("as-red", "dp", "participant", "1"),
        ("as-blue", "dp", "participant", "2"),
    ]
    assert [row[:3] for row in by_participant.rows] == [("as-red", "P1", "1"), ("as-blue", "P1", "2")]


def test_blocks_that_differ_in_seats_alone_are_pooled(tmp_path: Path) -> None:
    found = two_blocks(tmp_path, **{"maps: all": "maps: [HandOff]"})
    table = performance(found, plain)
    assert table.heads[:2] == ("Partner", "rounds")
    assert {row[2][:5] for row in table.rows} == {"0.500"}


def test_order_effects_say_whom_they_are_about(tmp_path: Path) -> None:
    small, text = template("agent_survey")
    place, store, _ = fill(tmp_path, small, text, 3)
    with store.database.write() as connection:
        connection.execute(update(rounds).values(tcr=1.0))
        connection.execute(update(rounds).where(rounds.c.unit == 1).values(tcr=rounds.c.position / 10.0))
    rows = {row[0]: row for row in order_effects(collect(small, store, place.recordings)).rows}
    assert rows["TCR ↑"][1:3] == ("1 of 3", "+1.00")


def test_ratings_at_the_end_stand_apart_from_those_of_partners(tmp_path: Path) -> None:
    """Of pairs, whose partner has no name, and of who played with an agent in a partner's place."""
    rated = {
        **TWO_BLOCKS,
        "    limit_minutes: 50": f"    after_partner: [{FORM}]",
        "blocks:\n": f"at_end: [{FORM}]\nblocks:\n",
    }
    small, text = template("collect", **rated)
    place, store, pids = fill(tmp_path, small, text, 2)
    agree(store, ["P3"])
    alone = store.form_unit(["P3"])
    Rounds(store).begin(alone, rounds_of(alone.slot, small)[0], "alone", [PlayerOutcome("P3", 0, "keyboard")])
    Rounds(store).end("alone", RoundOutcome("time", 500, 0.0, 0.0, 0.0, None))
    store.answer("P3", f"fixed-maps/1/{FORM}", FORM, SUBSTITUTE, "teamwork", 2, "", 1.0)
    for pid, value in zip([*pids, "P3"], (4, 4, 7), strict=True):
        store.answer(pid, f"end/{FORM}", FORM, "", "teamwork", value, "", 1.0)
        if pid != "P3":
            store.answer(pid, f"fixed-maps/1/{FORM}", FORM, "", "teamwork", 1, "", 1.0)
    table = ratings(collect(small, store, place.recordings), plain)
    assert table.heads == ("Block", "Item", SUBSTITUTE, "another", "at the end")
    assert [row for row in table.rows if row[1] == "Teamwork"] == [
        ("fixed-maps", "Teamwork", "2.000", "1.000 ± 0.000", "–"),
        ("–", "Teamwork", "–", "–", "5.000 ± 1.000"),
    ]


def test_what_was_said_of_partners_is_compared_where_no_round_counts(apart: Results) -> None:
    none_counts = replace(apart, rounds=())
    assert rating_comparisons(none_counts, plain).rows == rating_comparisons(apart, plain).rows != ()
    assert metric_comparisons(none_counts, plain).rows == ()


def test_what_is_asked_after_rounds_and_partners_and_at_the_end_is_three_items(tmp_path: Path) -> None:
    both = {
        "    after_partner: [": f"    after_round: [{FORM}]\n    after_partner: [",
        "    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]",
        'demographics: ""': f'at_end: [{FORM}]\ndemographics: ""',
    }
    small, text = template("agent_survey", **both)
    place, store, pids = fill(tmp_path, small, text, 2)
    round_ = next(one for one in rounds_of(0, small))
    for pid in pids:
        store.answer(pid, f"{round_.key}/{FORM}", FORM, "scripted", "teamwork", 1, "", 2.0)
        store.answer(pid, f"play/1/{FORM}", FORM, "scripted", "teamwork", 7, "", 2.0)
        store.answer(pid, f"end/{FORM}", FORM, "", "teamwork", 4, "", 2.0)
    cells = {row[0]: row[1:] for row in ratings(collect(small, store, place.recordings), plain).rows}
    assert cells["Teamwork (after_partner)"] == ("7.000 ± 0.000", "–")
    assert cells["Teamwork (after_round)"][0] < "7"
    assert cells["Teamwork (after_round)"][1] == "–"
    assert cells["Teamwork (at_end)"] == ("–", "4.000 ± 0.000")
