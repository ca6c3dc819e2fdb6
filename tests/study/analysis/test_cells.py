"""Partners are compared over what each participant has of both: two equal ones stay equal where rounds are missing."""

from collections import defaultdict
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path

import pytest
from sqlalchemy import update

from movingout.study.analysis.cells import CellValue, CellValues, paired
from movingout.study.analysis.comparisons import compare
from movingout.study.analysis.results import Results, Row, collect
from movingout.study.analysis.tables import flags, metric_comparisons, rating_comparisons
from movingout.study.design.pooling import are_seats_crossed
from movingout.study.store import Store
from movingout.study.store.rounds import Rounds
from movingout.study.store.tables import answers, participants, rounds, units
from tests.study.filled import fill, template

FORM = "movingout-paper-nine"
SMALL = {
    "    maps: all     ": "    maps: [HandOff, LeftRight] ",
    "    partners: [dp, bass, mlp, gru]": "    partners: [dp, bass]",
}


def plain(partner: str) -> str:
    return partner


def of(*values: tuple[str, float | None]) -> list[CellValue]:
    return [CellValue(cell, value, f"{number}") for number, (cell, value) in enumerate(values)]


def rated_each_round(folder: Path, seats: str = "alternate") -> tuple[Store, Results]:
    """Two people who rate each round, on two maps, with two partners; each round has a value of each metric."""
    changes = {
        **SMALL,
        "seats: alternate": f"seats: {seats}",
        "    after_partner: [": f"    after_round: [{FORM}]\n    after_partner: [",
    }
    small, text = template("human_study", **changes)
    place, store, _ = fill(folder, small, text, 2, seed=3)
    with store.database.write() as connection:
        connection.execute(update(rounds).where(rounds.c.ac.is_(None)).values(ac=0.5))
    return store, collect(small, store, place.recordings)


def again(store: Store, before: Results) -> Results:
    return collect(before.study, store, Path("nowhere"))


def mark_invalid(store: Store, found: Iterable[Row]) -> None:
    for row in found:
        Rounds(store).mark(row["episode"], valid=False)


def test_who_lacks_a_map_with_one_partner_makes_no_difference_between_equal_ones() -> None:
    easy, hard = ("easy", 1.0), ("hard", 0.2)
    first: CellValues = {str(unit): of(easy, hard) for unit in range(9)}
    second: CellValues = {str(unit): of(easy) if unit < 6 else of(hard, easy) for unit in range(9)}
    found = paired(first, second)
    compared = compare("tcr", "a", "b", found.first, found.second)
    assert compared is not None and compared.difference == 0.0
    assert (compared.pairs, compared.t, compared.w_p) == (9, 0.0, None)
    assert found.left_out == {(str(unit), "1") for unit in range(6)}


def test_a_map_played_less_often_with_one_partner_has_one_weight_for_both() -> None:
    found = paired(
        {"1": of(("a", 1.0), ("a", 1.0), ("b", 0.0), ("b", 0.0))}, {"1": of(("a", 1.0), ("a", 1.0), ("b", 0.0))}
    )
    assert found.first == found.second == {"1": pytest.approx(2 / 3)} and not found.left_out


def test_what_has_no_value_with_one_partner_is_left_out_with_the_other() -> None:
    found = paired(
        {"1": of(("a", 1.0), ("b", None)), "2": of(("a", None))},
        {"1": of(("b", 0.5), ("a", 0.25)), "2": of(("a", 1.0))},
    )
    assert found == ({"1": 1.0}, {"1": 0.25}, frozenset({("1", "0"), ("2", "0")}))
    again = paired({"1": of(("a", 1.0), ("a", None), ("b", 0.0))}, {"1": of(("a", 1.0), ("a", 1.0), ("b", 0.0))})
    assert again == ({"1": 0.5}, {"1": 0.5}, frozenset())


def test_one_person_without_values_of_both_hides_nobody_elses() -> None:
    first: CellValues = {f"a{number}": of(("", 1.0)) for number in range(10)}
    second: CellValues = {f"b{number}": of(("", 0.0)) for number in range(10)}
    refused = paired({**first, "x": of(("", None))}, {**second, "x": of(("", 0.5))})
    assert (len(refused.first), len(refused.second), refused.left_out) == (10, 11, frozenset())
    on_other_maps = paired({**first, "x": of(("easy", 1.0))}, {**second, "x": of(("hard", 0.5))})
    assert (len(on_other_maps.first), len(on_other_maps.second)) == (10, 10), "x would be a pair that is none"
    assert on_other_maps.left_out == {("x", "0")}
    both = paired({**first, "x": of(("", 1.0))}, {**second, "x": of(("", 0.5))})
    assert (both.first, both.second, len(both.left_out)) == ({"x": 1.0}, {"x": 0.5}, 20)


def test_who_met_one_of_two_partners_counts_only_where_nobody_met_both() -> None:
    alone = paired({"1": of(("a", 1.0), ("b", 0.0))}, {"2": of(("a", 0.0))})
    assert alone == ({"1": 0.5}, {"2": 0.0}, frozenset())
    both = paired(
        {"1": of(("a", 1.0)), "2": of(("b", 1.0)), "3": of(("a", 1.0))}, {"2": of(("a", 0.0)), "3": of(("a", 0.5))}
    )
    assert both == ({"3": 1.0}, {"3": 0.5}, frozenset({("1", "0"), ("2", "0")}))


@pytest.mark.parametrize("seats", ["alternate", "both"])
def test_where_nothing_is_missing_means_are_those_of_all_rounds_to_the_bit(tmp_path: Path, seats: str) -> None:
    _, found = rated_each_round(tmp_path, seats)
    for one, other in combinations(found.partners, 2):
        for metric in ("tcr", "ac"):
            compared = found.compare_rounds(metric, one, other)
            assert (compared.first, compared.second) == (by_unit(found, metric, one), by_unit(found, metric, other))
        said = found.compare_ratings(FORM, "teamwork", one, other, ("after_round",))
        means = [found.ratings(FORM, "teamwork", name, ("after_round",)) for name in (one, other)]
        by_person = [{str(unit): mean[pid] for unit, (pid,) in found.people.items()} for mean in means]
        assert [said.first, said.second] == by_person and len(by_person[0]) == 2
        assert not compared.left_out | said.left_out
    assert "unit" not in str(flags(found).rows)


def by_unit(results: Results, metric: str, partner: str) -> dict[str, float]:
    found: dict[str, list[float]] = defaultdict(list)
    for row in results.rounds:
        if row["partner"] == partner and row[metric] is not None:
            found[str(row["unit"])].append(row[metric])
    return {unit: sum(values) / len(values) for unit, values in found.items()}


@pytest.mark.slow
def test_missing_rounds_are_left_out_with_their_counterparts_and_the_report_says_so(tmp_path: Path) -> None:
    store, before = rated_each_round(tmp_path)
    with store.database.write() as connection:
        connection.execute(update(rounds).values(tcr=1.0))
        connection.execute(update(rounds).where(rounds.c.map == "LeftRight").values(tcr=0.0))
        hard = [row["step"] for row in before.rounds if row["unit"] == 1 and row["map"] == "LeftRight"]
        about = answers.c.step.in_([f"{step}/{FORM}" for step in hard])
        connection.execute(update(answers).values(value=4))
        connection.execute(update(answers).where(about).values(value=1))
    mark_invalid(
        store, [row for row in before.rounds if (row["unit"], row["map"], row["partner"]) == (1, "LeftRight", "dp")]
    )
    found = again(store, before)
    compared, rated = metric_comparisons(found, plain), rating_comparisons(found, plain)
    assert {row[2] for row in compared.rows if row[0] == "TCR ↑"} == {"+0.000"}
    assert {row[2] for row in rated.rows if row[0] == f"Teamwork ({FORM})"} == {"+0.000"}
    assert compared.note.endswith("rounds or answers: 1, of participants or pairs: 1.")
    assert {row[compared.heads.index("n")] for row in compared.rows if row[0] == "TCR ↑"} == {"2 / 2"}
    assert "rounds or answers:" not in metric_comparisons(before, plain).note
    assert [row[2] for row in flags(found).rows][-1].startswith("unit 1: 1 of 3 rounds are left out where partners")


@pytest.mark.parametrize(("seats", "left_out"), [("both", 1), ("alternate", 0)])
def test_a_seat_counts_where_everybody_meets_every_partner_in_both(tmp_path: Path, seats: str, left_out: int) -> None:
    small, text = template("human_study", **SMALL)
    blocks = (small.blocks[0].model_copy(update={"seats": seats, "rounds": 1 if seats == "both" else 2}),)
    small = small.model_copy(update={"blocks": blocks})
    assert are_seats_crossed(small, [blocks[0].id]) == (seats == "both")
    place, store, _ = fill(tmp_path, small, text, 1)
    before = collect(small, store, place.recordings)
    mark_invalid(store, [row for row in before.rounds if row["partner"] == "dp"][:1])
    found = again(store, before).compare_rounds("tcr", "dp", "bass")
    assert len(found.left_out) == left_out


def test_who_may_still_play_the_other_rounds_is_not_flagged_and_who_left_is(tmp_path: Path) -> None:
    small, text = template("human_study", **SMALL)
    place, store, _ = fill(tmp_path, small, text, 1)
    before = collect(small, store, place.recordings)
    mark_invalid(store, [row for row in before.rounds if (row["map"], row["partner"]) == ("HandOff", "dp")])
    assert "unit 1: 1 of 3 rounds are left out" in str(flags(again(store, before)).rows)
    for hours, flagged in ((1, False), (25, True)):
        with store.database.write() as connection:
            seen = store.now() - hours * 3_600_000
            connection.execute(update(units).values(state="active"))
            resumed = store.now()  # a pause began and ended for all, those who left, too
            connection.execute(update(participants).values(arrived_ms=seen, heard_ms=seen, last_seen_ms=resumed))
        assert ("rounds are left out" in str(flags(again(store, before)).rows)) == flagged
