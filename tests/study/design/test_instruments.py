"""NASA-TLX, the demographic form, the shorter paper questionnaire, order of items, attention items."""

import pytest

from movingout.study.design.instruments import DEMOGRAPHICS, NASA_TLX, instrument, instrument_names
from movingout.study.errors import StudyError
from movingout.study.questionnaire import PAPER, PAPER_EIGHT, AnswerError, Questionnaire, QuestionnaireItem


def test_the_shorter_variant_is_the_first_eight_of_the_nine_and_the_free_text() -> None:
    assert PAPER_EIGHT.items == (*PAPER.items[:8], PAPER.items[9])


def test_nasa_tlx_has_six_scales_of_21_gradations_and_performance_runs_from_perfect_to_failure() -> None:
    assert [item.id for item in NASA_TLX.items] == [
        "mental", "physical", "temporal", "performance", "effort", "frustration",
    ]  # fmt: skip
    assert {len(item.allowed()) for item in NASA_TLX.items} == {21}
    assert [item.ends for item in NASA_TLX.items if item.id == "performance"] == [("Perfect", "Failure")]


@pytest.mark.parametrize("name", instrument_names())
def test_every_question_of_a_ready_made_form_can_be_left_unanswered(name: str) -> None:
    form = instrument(name)
    for item in form.items:
        form.check_answer(item.id, -1, "")


@pytest.mark.parametrize(("question", "value"), [("age", 6), ("age", -2), ("gender", 4)])
def test_a_choice_takes_the_index_of_an_option(question: str, value: int) -> None:
    DEMOGRAPHICS.check_answer(question, value - 1 if value > 0 else 0, "")
    with pytest.raises(AnswerError, match=f"{question} takes 0 to"):
        DEMOGRAPHICS.check_answer(question, value, "")


def test_the_order_of_items_follows_from_the_seed_and_free_text_stays_last() -> None:
    one, again, other = (PAPER.shuffled(seed) for seed in ("P1 round 1", "P1 round 1", "P2 round 1"))
    assert one == again != other
    assert {item.id for item in one.items} == {item.id for item in PAPER.items}
    assert [form.items[-1].id for form in (one, other)] == ["comment", "comment"]


def test_all_orders_of_items_come_up() -> None:
    form = Questionnaire("three", "", tuple(QuestionnaireItem(name, "likert7", "", "") for name in "abc"))
    assert len({form.shuffled(str(seed)).items for seed in range(100)}) == 6


def test_what_is_expected_of_an_attention_item_is_never_sent_to_the_browser() -> None:
    item = QuestionnaireItem("attention", "likert7", "Attention", "Please choose 2.", expected=2)
    assert "expected" not in item.as_json()


def test_an_unknown_questionnaire_is_answered_with_the_ready_made_ones() -> None:
    with pytest.raises(StudyError, match="ready-made: movingout-paper-nine, movingout-paper-eight, nasa-tlx"):
        instrument("nasa")
