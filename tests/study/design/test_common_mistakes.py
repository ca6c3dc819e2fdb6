"""What people write into their first study file, and are told about it."""

from pathlib import Path

import pytest

from movingout.server.cli import main
from movingout.study.design.review import review
from movingout.study.design.study_file import parse_study, read_study
from movingout.study.errors import StudyFileError
from tests.study.design.small_study import SMALL, faults


@pytest.mark.parametrize(
    ("agent", "written"),
    [("scripted", "{id: scripted, agent: scripted}"), ("'dp@all:lag=1'", '{id: dp-all-lag-1, agent: "dp@all:lag=1"}')],
)
def test_partners_that_are_only_named_are_told_how_they_are_written(agent: str, written: str) -> None:
    text = SMALL.replace("- {id: one, agent: scripted}", f"- {agent}")
    ((line, path, message),) = faults(text)
    assert (line, path) == (9, "partners[0]") and message.endswith(f"write {written}")
    parse_study(text.replace(f"- {agent}", f"- {written}").replace("[one,", f"[{written[5:].partition(',')[0]},"))


def test_where_fields_are_needed_they_are_named() -> None:
    assert faults(f"{SMALL}pay: 12\n") == [(24, "pay", "fields are needed here; known: currency, per_hour, maximum")]


def test_options_that_are_truth_values_or_numbers_are_told_to_be_put_in_quotes() -> None:
    question = "{id: best, kind: choice, text: Which, options: [yes, 2]}"
    found = faults(SMALL.replace("{id: attention, kind: likert7, text: Please choose 2., expected: 2}", question))
    assert [message for _, _, message in found] == [
        f"should be a text, or one per language: {{en: ..., de: ...}}, not {value}: write it in quotes"
        for value in (True, 2)
    ]


def test_several_names_without_brackets_are_told_how_their_list_is_written() -> None:
    ((_, _, message),) = faults(SMALL.replace("[one, two]", "one, two"))
    assert message == "a list is needed here; write [one, two]"


def test_a_comma_that_ends_a_text_or_a_number_in_braces_is_told_of() -> None:
    for text in (
        f"{SMALL}pay: {{per_hour: 10,50}}\n",
        SMALL.replace("text: Please choose 2.", "text: Please, choose 2."),
    ):
        ((_, _, message),) = faults(text)
        assert "in {...} a comma ends a text" in message
    ((_, _, message),) = faults(f"{SMALL}pays: 3\n")
    assert "comma" not in message


def test_options_that_read_alike_are_refused_where_the_study_has_not_begun(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    question = "{id: best, kind: choice, text: Which, options: [a, b, c]}"
    text = SMALL.replace("{id: attention, kind: likert7, text: Please choose 2., expected: 2}", question)
    assert review(parse_study(text)).alike == ()
    alike = text.replace("[a, b, c]", "[a, 'a ', c]")
    (sentence,) = review(parse_study(alike)).alike
    assert sentence.startswith("question best of short has the option 'a' more than once, in 'en'")
    german = text.replace("format: 1", "format: 1\nlanguages: [en, de]").replace(
        "[a, b,", "[{en: a, de: x}, {en: b, de: x},"
    )
    german = german.replace(
        "text: We record how you play.", "text: {en: We record how you play., de: Wir zeichnen auf.}"
    )
    found = review(parse_study(german))
    assert "has the option 'x' more than once, in 'de'" in found.alike[0] and not found.ready
    (tmp_path / "study.yaml").write_text(alike, encoding="utf-8")
    assert main(["study", "check", str(tmp_path / "study.yaml")]) == 1
    page = capsys.readouterr().out
    assert f"wrong: {sentence}" in page and "1 question with equal options" in page
    assert main(["study", "serve", str(tmp_path / "study.yaml"), "--data", str(tmp_path / "data"), "--port", "0"]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("written", ["{partners}", "{en: {partners}}"])
def test_a_text_in_braces_without_quotes_is_told_how_it_is_written(written: str) -> None:
    text = SMALL.replace("{text: They were programs.}", f"\n  text: {written}")
    said = 'a text in braces is put in quotes, or YAML reads a field: write "{partners}"'
    assert faults(text) == [(24, "debrief.text", said)]
    parse_study(text.replace("{partners}", '"{partners}"'))


def test_a_text_whose_file_is_missing_is_named_as_it_was_written(tmp_path: Path) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SMALL.replace("We record how you play.", "{file: ./nope.md}"), encoding="utf-8")
    with pytest.raises(StudyFileError, match=r"consent.text: cannot read ./nope.md: No such file or directory$"):
        read_study(file)
    (tmp_path / "nope.md").write_bytes("Größe".encode("cp1252"))
    with pytest.raises(StudyFileError, match=r"consent.text: ./nope.md is not UTF-8 text; in the editor"):
        read_study(file)


def test_a_file_in_another_encoding_is_told_so_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_bytes(SMALL.replace("Please choose", "Bitte wähle").encode("cp1252"))
    with pytest.raises(StudyFileError) as caught:
        read_study(tmp_path / "study.yaml")
    line = next(number for number, line in enumerate(SMALL.splitlines(), 1) if "Please choose" in line)
    assert str(caught.value).endswith(
        f"study.yaml:{line}: the file: is not UTF-8 text; in the editor, save it with the encoding UTF-8"
    )


def test_an_expected_answer_that_is_a_truth_value_is_warned_of_and_read_as_earlier_versions_did() -> None:
    study = parse_study(SMALL.replace("expected: 2", "expected: yes"))
    assert study.questionnaire("short").item("attention").expected == 1
    (warning,) = [one for one in review(study).warnings if "truth values" in one]
    assert warning.startswith("attention item 'attention' of short expects 1")
    assert not [one for one in review(parse_study(SMALL)).warnings if "truth values" in one]


@pytest.mark.parametrize("written", ['"yes"', "often", "1.5", "[1]"])
def test_an_expected_answer_that_is_no_number_is_told_so_once(written: str) -> None:
    ((_, path, message),) = faults(SMALL.replace("expected: 2", f"expected: {written}"))
    assert path == "questionnaires[0].items[0].expected" and "valid integer" in message


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("    after_partner: [short]\n", "", "questionnaire short is never asked: name it in demographics"),
        ("[one, two]", "[one]", "partner two is in no block: it is never met, and takes a letter"),
        (
            "{id: attention, kind: likert7, text: Please choose 2., expected: 2}",
            "{id: best, kind: choice, text: Which, options: [a, b], ends: [bad, good]}",
            "questionnaire short: ends of best has no effect, because a choice is no scale",
        ),
    ],
)
def test_what_the_file_says_and_nothing_uses_is_warned_of(before: str, after: str, said: str) -> None:
    ready, changed = review(parse_study(SMALL)), review(parse_study(SMALL.replace(before, after)))
    assert not [one for one in ready.warnings if one.startswith(said)]
    assert len([one for one in changed.warnings if one.startswith(said)]) == 1


def test_an_attention_item_that_nobody_is_asked_expects_nothing() -> None:
    assert review(parse_study(SMALL)).attention
    assert not review(parse_study(SMALL.replace("    after_partner: [short]\n", ""))).attention
