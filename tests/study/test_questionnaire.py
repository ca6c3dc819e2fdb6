"""The questionnaire against the paper's own source."""

import re

import pytest

from movingout.study.questionnaire import PAPER, AnswerError
from tests.support import shared


def paper_items() -> list[tuple[str, str]]:
    """(label, text) of the nine items as the paper prints them."""
    source = shared("paper.tex", "the paper's source, with which the wording is compared,")
    section = source.read_text(encoding="utf-8").split(r"\label{appx:questionnaire}")[1].split(r"\end{enumerate}")[0]
    return re.findall(r"\\item \\textbf\{(\w+):\} (.+)", section)


def test_the_nine_items_are_the_papers_word_for_word_and_in_its_order() -> None:
    assert [(item.label, item.text) for item in PAPER.items if item.kind == "likert7"] == paper_items()


def test_the_free_response_question_comes_last_and_is_the_only_one() -> None:
    assert [item.kind for item in PAPER.items] == ["likert7"] * 9 + ["text"]


def test_the_browser_gets_every_item_with_id_kind_label_and_text() -> None:
    document = PAPER.as_json()
    assert document["title"] == "About your partner"
    assert document["items"] == [
        {"id": item.id, "kind": item.kind, "label": item.label, "text": item.text} for item in PAPER.items
    ]


@pytest.mark.parametrize(
    ("question", "value", "text"),
    [("teamwork", 1, ""), ("teamwork", 7, ""), ("teamwork", -1, ""), ("comment", -1, "it waited for me")],
)
def test_an_answer_on_the_scale_no_answer_and_a_comment_are_taken(question: str, value: int, text: str) -> None:
    PAPER.check_answer(question, value, text)


@pytest.mark.parametrize(
    ("question", "value", "text", "reason"),
    [
        ("team", 4, "", "unknown question 'team'; known: teamwork, humanlike"),
        ("teamwork", 0, "", "takes 1 to 7, or -1"),
        ("teamwork", 8, "", "takes 1 to 7, or -1"),
        ("teamwork", 4, "because", "takes a number"),
        ("comment", 4, "", "takes a text"),
        ("comment", -1, "x" * 4001, "at most 4000 characters, not 4001"),
    ],
)
def test_an_answer_that_does_not_fit_is_refused_with_a_reason(
    question: str, value: int, text: str, reason: str
) -> None:
    with pytest.raises(AnswerError, match=reason):
        PAPER.check_answer(question, value, text)
