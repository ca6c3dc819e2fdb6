"""What two of a pair say of each other is one value where partners are compared; pairs at one screen are flagged."""

from pathlib import Path

from movingout.study.analysis.results import Results, collect
from movingout.study.analysis.tables import flags, rating_comparisons
from movingout.study.design.definition import SUBSTITUTE
from tests.study.filled import fill, template

FORM = "movingout-paper-nine"


def test_ratings_of_pairs_are_compared_by_pair() -> None:
    pairs, _ = template("collect")
    said = {"P1": ("", 1), "P2": ("", 1), "P3": ("", 7), "P4": (SUBSTITUTE, 4)}
    about = {"step": f"fixed-maps/1/{FORM}", "questionnaire": FORM, "item": "teamwork", "text": ""}
    found = Results(
        study=pairs.model_copy(update={"at_end": (FORM,)}),
        flow=(),
        rounds=tuple({"unit": 1, "block": "fixed-maps", "partner": one, "tcr": None} for one in ("", SUBSTITUTE)),
        people={1: ("P1", "P2"), 2: ("P3",), 3: ("P4",)},
        answers=tuple({**about, "pid": pid, "partner": who, "value": value} for pid, (who, value) in said.items()),
        flags=(),
    )
    compared = found.compare_ratings(FORM, "teamwork", "", SUBSTITUTE)
    assert (compared.first, compared.second) == ({"1": 1.0, "2": 7.0}, {"3": 4.0})
    (row,) = rating_comparisons(found, lambda partner: partner or "a person").rows
    assert row[:4] == ("fixed-maps", "Teamwork", f"{SUBSTITUTE} – a person", "+0.000"), "by person it would be +1"


def test_a_pair_at_one_screen_is_flagged(tmp_path: Path) -> None:
    pairs, text = template("collect")
    _, store, pids = fill(tmp_path, pairs, text, 4)
    assert not any("one screen" in row[2] for row in flags(collect(pairs, store, tmp_path)).rows)
    store.set_shared_screen(pids[2:], "s1")
    found = [row[2] for row in flags(collect(pairs, store, tmp_path)).rows if "one screen" in row[2]]
    assert found == ["unit 2: both at one screen; nothing shows that they were two people"]
