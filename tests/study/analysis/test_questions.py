"""What the report sums up of questionnaires: no question is missing, and each says what its values mean."""

from dataclasses import replace
from pathlib import Path

import pytest

from movingout.recordings.report.words import Words
from movingout.study.analysis.page import page
from movingout.study.analysis.questions import counted_items
from movingout.study.analysis.results import Results, collect
from movingout.study.analysis.tables import LANGUAGE_FILES, choices, performance, ratings
from movingout.study.questionnaire import QuestionnaireItem
from movingout.study.store import Store
from tests.study.filled import fill, template

OWN = """questionnaires:
  - id: own
    items:
      - {id: like, kind: likert7, label: Liked, text: "How was it?", ends: [very bad, very good]}
      - {id: liked_too, kind: likert7, label: Liked, text: "And the other?"}
      - {id: again, kind: choice, text: "Again?", options: ["Never", "Once"]}
      - {id: awake, kind: choice, text: Say yes., options: ["No", "Yes"], expected: 1}
  - id: about-you
    items:
      - {id: skill, kind: likert7, text: I play a lot.}
"""
CHANGES = {
    "    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff]",
    "after_partner: [movingout-paper-nine]": "after_partner: [own]\nat_end: [own]",
    'demographics: ""                # none\n': f"{OWN}demographics: about-you\n",
}


def plain(partner: str) -> str:
    return partner or "another"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    small, text = template("agent_survey", **CHANGES)
    place, store, pids = fill(tmp_path_factory.mktemp("data"), small, text, 3)
    for pid, skill, again in zip(pids, (2, 2, 5), (0, 1, -1), strict=True):
        say(store, pid, "form", "about-you", "skill", skill)
        say(store, pid, "play/1/own", "own", "again", again)
        say(store, pid, "end/own", "own", "again", 1)
    return collect(small, store, place.recordings)


def say(store: Store, pid: str, step: str, form: str, item: str, value: int) -> None:
    store.answer(pid, step, form, "scripted" if step.startswith("play") else "", item, value, "", 7.0)


def test_choices_and_demographics_are_counted_and_attention_items_are_not(results: Results) -> None:
    assert choices(results, plain).rows == (
        ("Skill", "at the start", "2", "2"),
        ("Skill", "at the start", "5", "1"),
        ("Again", "scripted", "Never", "1"),
        ("Again", "scripted", "Once", "1"),
        ("Again", "scripted", "no answer", "1"),
        ("Again", "at the end", "Never", "0"),
        ("Again", "at the end", "Once", "3"),
    )
    assert "Auswahlfragen" in page(results, plain, "über", Words("de", (LANGUAGE_FILES,)))


def test_a_kind_that_is_neither_rated_nor_a_text_is_counted(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(QuestionnaireItem, "is_rated", property(lambda item: item.id == "liked_too"))
    assert [asked.item.id for asked in counted_items(results.study)] == ["skill", "like", "again"]


def test_a_study_that_asks_nothing_to_count_has_no_table_of_it(tmp_path: Path) -> None:
    small, _ = template("agent_survey")
    assert "Choices" not in page(Results(small, (), (), {}, (), ()), plain, "about")


def test_two_items_of_a_questionnaire_with_one_label_are_told_apart(results: Results) -> None:
    assert [row[0] for row in ratings(results, plain).rows] == ["Liked (like)", "Liked (liked_too)"]


def test_an_item_with_ends_of_its_own_is_not_shown_under_agreement(results: Results) -> None:
    html = page(results, plain, "about")
    assert html.count("1 very bad – 7 very good") == 1 and "7 strongly agree" in html, "the other has the usual ends"
    small, _ = template("agent_survey", **CHANGES, **{'"And the other?"': '"And the other?", ends: [low, high]'})
    alone = page(Results(small, (), results.rounds, {}, results.answers, ()), plain, "about")
    assert "1 low – 7 high" in alone and "strongly agree" not in alone


def test_what_was_said_of_a_partner_stays_where_no_round_with_them_counts(results: Results) -> None:
    kept = tuple(row for row in results.rounds if row["partner"] != "scripted")
    assert len(kept) < len(results.rounds)
    left = replace(results, rounds=kept)
    for table in (ratings, choices):
        assert table(left, plain).rows == table(results, plain).rows != ()
    assert page(left, plain, "about").count("scripted: ") == page(results, plain, "about").count("scripted: ") > 0
    assert "scripted" not in {row[0] for row in performance(left, plain).rows}


def test_a_bar_has_the_share_of_each_answer_also_where_somebody_is_asked_more_than_once(tmp_path: Path) -> None:
    changes = {
        **CHANGES,
        "    maps: [HandOff, PriorityPick, SingleRotation]": "    maps: [HandOff, LeftRight]",
        "after_partner: [movingout-paper-nine]": "after_round: [own]\nat_end: [own]",
    }
    small, text = template("agent_survey", **changes)
    place, store, (pid,) = fill(tmp_path, small, text, 1)
    for number, row in enumerate(collect(small, store, place.recordings).rounds):
        say(store, pid, f"{row['step']}/own", "own", "like", 2 + number % 2)
    html = page(collect(small, store, place.recordings), plain, "about")
    assert "scripted: 2 by 50 %" in html and "scripted: 3 by 50 %" in html
