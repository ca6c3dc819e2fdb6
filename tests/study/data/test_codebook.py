"""The codebook of an export explains every table, column and question."""

import json
from pathlib import Path

from movingout.study.data.codebook import codebook
from movingout.study.data.export import Options, export_study
from movingout.study.design.study_file import parse_study
from movingout.study.questionnaire import USUAL_ENDS
from tests.study.filled import SHORT, fill, template
from tests.study.support import open_store
from tests.support import ROOT


def test_the_codebook_explains_every_column_of_every_table_and_every_question(tmp_path: Path) -> None:
    study, text = template("human_study")
    place, store, _ = fill(tmp_path, study, text, 1)
    export_study(place, store, tmp_path / "out", Options(("csv",)))
    book = (tmp_path / "out" / "codebook.md").read_text(encoding="utf-8")
    parts = {part.partition("\n")[0]: part for part in book.split("\n## ")}
    for file in (tmp_path / "out").glob("*.csv"):
        header = file.read_text(encoding="utf-8").partition("\n")[0].strip().split(",")
        explained = [line.split(" | ")[0][2:] for line in parts[file.stem].splitlines() if line.startswith("| ")]
        assert explained[1:] == header, file
    for item in study.questionnaire("about-partner").items:
        assert f"| {item.id} |" in book and item.text in book
    assert "(Perfect to Failure)" in book
    assert "| age | -1: no answer; 0: 18–24; 1: 25–34" in book


def test_the_codebook_says_what_is_expected_of_a_choice(tmp_path: Path) -> None:
    line = "  - id: check\n    items: [{id: seen, kind: choice, text: Choose b, options: [a, b], expected: 1}]\n"
    study, text = template("agent_survey", **SHORT)
    study = parse_study(f"{text}\nquestionnaires:\n{line}at_end: [check]\n")
    assert "| seen | -1: no answer; 0: a; 1: b, attention: 1 | Choose b |" in codebook(study, open_store(tmp_path))


def test_the_codebook_says_the_ends_that_a_line_without_its_own_shows(tmp_path: Path) -> None:
    line = "  - id: load\n    items: [{id: effort, kind: tlx, text: Effort}]\n"
    study, text = template("agent_survey", **SHORT)
    study = parse_study(f"{text}\nquestionnaires:\n{line}at_end: [load]\n")
    book = codebook(study, open_store(tmp_path))
    assert "| effort | 0 to 20 (very low to very high), -1 no answer | Effort |" in book
    words = json.loads((ROOT / "web" / "words" / "en.json").read_text(encoding="utf-8"))
    shown = {"likert7": (words["form.low"], words["form.high"]), "tlx": (words["form.tlxLow"], words["form.tlxHigh"])}
    assert shown == USUAL_ENDS


def test_a_question_with_a_bar_or_several_lines_stays_one_row_of_the_codebook(tmp_path: Path) -> None:
    lines = {'en: This line checks the form. Please choose 2, "disagree".': r'en: "Fast | slow?\nAnd why?"'}
    study, text = template("human_study", **lines)
    place, store, _ = fill(tmp_path, study, text, 1)
    export_study(place, store, tmp_path / "out", Options(("csv",)))
    book = (tmp_path / "out" / "codebook.md").read_text(encoding="utf-8")
    expected = r"| attention | 1 to 7 (strongly disagree to strongly agree), attention: 2, -1 no answer | Fast \| slow?"
    assert f"{expected}<br>And why? |" in book.splitlines()
