"""What the two of a pair say of each other is one value where partners are compared."""

from movingout.study.analysis.results import Results
from movingout.study.analysis.tables import rating_comparisons
from movingout.study.design.definition import SUBSTITUTE
from tests.study.filled import template

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
