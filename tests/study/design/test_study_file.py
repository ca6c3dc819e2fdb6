"""Study files: what is read, and that every fault is found with its line."""

from pathlib import Path
from typing import Literal
from unicodedata import normalize

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from movingout.study.design.definition import Study
from movingout.study.design.review import earned
from movingout.study.design.study_file import complete_text, parse_study, read_study
from movingout.study.errors import StudyError, StudyFileError
from tests.study.design.small_study import SMALL, faults

Spelling = Literal["NFC", "NFD"]


def test_a_small_study_is_read_with_its_defaults() -> None:
    study = parse_study(SMALL)
    block = study.blocks[0]
    assert (study.id, study.title.text("de"), study.title.text("fr")) == ("pilot", "Ein Vorversuch", "A pilot")
    assert (block.limit_ticks, block.seats, block.partner_order) == (500, "alternate", "balanced")
    assert study.consent.text.text() == "We record how you play."


@pytest.mark.parametrize(("written", "read"), [("on", "on"), ("off", "off"), ("'on'", "on"), ("true", "on")])
def test_pings_are_a_switch_of_a_block_and_off_unless_switched_on(written: str, read: str) -> None:
    assert parse_study(SMALL).blocks[0].pings == "off"
    assert parse_study(SMALL.replace("    maps:", f"    pings: {written}\n    maps:")).blocks[0].pings == read


def test_another_value_of_pings_is_a_fault_with_its_line() -> None:
    ((line, path, message),) = faults(SMALL.replace("    maps:", "    pings: sometimes\n    maps:"))
    assert (line, path) == (14, "blocks[0].pings") and "'on' or 'off'" in message


def test_a_questionnaire_is_built_from_a_ready_made_one_with_items_left_out_and_added_before_the_free_text() -> None:
    ids = [item.id for item in parse_study(SMALL).questionnaire("short").items]
    assert ids[-3:] == ["alignment", "attention", "comment"]
    assert "future" not in ids


@pytest.mark.parametrize(
    ("old", "new", "line", "path", "message"),
    [
        ("    maps:", "    map:", 14, "blocks[0].map", "did you mean maps? known: id, partners"),
        ("FourCorners", "FourCorner", 14, "blocks[0].maps", "unknown map 'FourCorner'"),
        (
            "[HandOff, FourCorners]",
            "HandOff",
            14,
            "blocks[0].maps",
            "a list is needed here; for one entry, write [HandOff]",
        ),
        ("[HandOff, FourCorners]", "{a: 1}", 14, "blocks[0].maps", "a list is needed here"),
        ("[one, two]", "[one, three]", 13, "blocks[0].partners[1]", "unknown partner 'three'; known: one, two"),
        ("[short]", "[long]", 15, "blocks[0].after_partner[0]", "unknown questionnaire 'long'; known: short, movi"),
        ("participants: 4", "participants: many", 4, "participants", "valid integer"),
        ("participants: 4\n", "", 1, "participants", "this field is missing"),
        ("id: pilot", "id: My Pilot", 2, "id", "small letters, digits and hyphens, at most 48, not 'My Pilot'"),
        ("expected: 2", "expected: 9", 22, "questionnaires[0].items[0]", "a value of the scale, 1 to 7, not 9"),
        (
            "likert7, text: Please choose 2., expected: 2",
            "choice, text: Please choose 3., options: ['1', '2', '3'], expected: 3",
            22,
            "questionnaires[0].items[0]",
            "the place of an option, which counts from 0: 0 ('1') to 2 ('3'), not 3",
        ),
        ("kind: likert7", "kind: text", 22, "questionnaires[0].items[0]", "a text has no value that could be exp"),
        ("without: [future]", "without: [past]", 17, "questionnaires[0]", "cannot leave out 'past'"),
        ("debrief: {text: They were programs.}\n", "", 1, "the file", "debrief is missing"),
        ("id: two", "id: one", 10, "partners[1].id", "'one' is taken"),
        (
            "  text: We",
            "  boxes: [{id: release, text: a}, {id: release, text: b}]\n  text: We",
            7,
            "consent.boxes[1].id",
            "'release' is taken",
        ),
        ("[short]", "[short, nasa-tlx, short]", 15, "blocks[0].after_partner[2]", "'short' is in this list already"),
        ("[HandOff, FourCorners]", "[]", 14, "blocks[0].maps", "one or more maps"),
        ("participants: 4", "participants: 4\nlanguages: []", 5, "languages", "at least one entry is needed"),
        ("We record how you play.", "''", 7, "consent.text", "this text is empty"),
        ("participants: 4", "participants: 4\nprotocol: 2026-04-01", 5, "protocol", "write it in quotes"),
        ("id: play", "id: yes", 12, "blocks[0].id", "a text is needed: write it in quotes"),
        ("participants: 4", "participants: 4\nlanguages: [en, de]", 8, "consent.text", "no text in 'de'"),
        ("participants: 4", "participants: 4\nid: again", 5, "id", "appears twice"),
        ("participants: 4", "participants: [4", 5, "the file", "this is not YAML"),
        ("participants: 4", "participants: 4\ngroup: 2", 14, "blocks[0].partners", "remove the partners"),
        (
            "participants: 4",
            "participants: 4\ncodes: {done: 'a b'}",
            5,
            "codes",
            "4 to 40 letters, digits and hyphens, not 'a b'",
        ),
        (
            "participants: 4",
            "participants: 4\nretention: {trials: 2 weeks}",
            5,
            "retention.trials",
            "such as 30d or 3y",
        ),
        ("title: ", "title: 3 #", 3, "title", "a text, or one per language: {en: ..., de: ...}, not 3"),
        (
            "    maps:",
            "    limit_ticks: 0\n    maps:",
            14,
            "blocks[0].limit_ticks",
            "greater than or equal to 1, not 0",
        ),
    ],
)
def test_a_fault_is_reported_with_its_line_its_path_and_what_would_be_right(
    old: str, new: str, line: int, path: str, message: str
) -> None:
    assert old in SMALL
    found = faults(SMALL.replace(old, new))
    assert any(at == line and where.startswith(path) and message in why for at, where, why in found), found


def test_all_faults_of_a_file_are_reported_at_once_in_the_order_of_their_lines() -> None:
    broken = SMALL.replace("participants: 4", "participants: 0\nminuts: 5").replace("kind: likert7", "kind: likert9")
    found = faults(broken)
    assert [line for line, _, _ in found] == [4, 5, 23]


def test_a_faulty_block_is_not_also_a_missing_one() -> None:
    assert [path for _, path, _ in faults(SMALL.replace("FourCorners", "Nowhere"))] == ["blocks[0].maps"]
    assert [path for _, path, _ in faults(SMALL.split("blocks:")[0] + "blocks: []")] == ["blocks"]


@pytest.mark.parametrize("text", ["", "[]", "just words", "a: &a [*a]", "a: \x00", "a: 2026-13-45", "? [1]\n: 2"])
def test_what_is_no_study_at_all_is_refused_with_a_sentence(text: str) -> None:
    assert faults(text)


def test_a_text_can_lie_in_a_file_beside_the_study(tmp_path: Path) -> None:
    (tmp_path / "consent.md").write_text("# Yes?", encoding="utf-8")
    file = tmp_path / "study.yaml"
    file.write_text(SMALL.replace("text: We record how you play.", "text: {en: {file: consent.md}}"), encoding="utf-8")
    assert read_study(file).consent.text.text() == "# Yes?"


@pytest.mark.parametrize(
    "written",
    [
        "text: {en: {file: consent.md}}  # why",
        "text: {en: &same {file: consent.md}, de: *same}",
        "text:\n    en:\n      file: consent.md  # why\n    de: Ja?",
        "text:\n    en: &same\n      file: 'consent.md'\n    de: *same",
    ],
)
def test_the_complete_text_of_a_study_needs_no_other_files(tmp_path: Path, written: str) -> None:
    (tmp_path / "consent.md").write_text('# "Yes"?\n\nIt\u2028is\x7f \\ 🙂.\n', encoding="utf-8")
    file = tmp_path / "study.yaml"
    file.write_text(SMALL.replace("text: We record how you play.", written), encoding="utf-8")
    complete = complete_text(file)
    assert parse_study(complete) == read_study(file)
    assert complete.count("\n") == file.read_text(encoding="utf-8").count("\n") and complete.count("#") > 0
    file.write_text(SMALL, encoding="utf-8")
    assert complete_text(file) == SMALL


def test_a_mark_of_notepad_before_a_text_is_no_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "consent.md").write_text("# Consent\n", encoding="utf-8-sig")
    file = tmp_path / "study.yaml"
    file.write_text(SMALL.replace("We record how you play.", "{file: consent.md}"), encoding="utf-8-sig")
    assert read_study(file).consent.text.text() == "# Consent\n"
    assert parse_study(complete_text(file)) == read_study(file)


@pytest.mark.parametrize(("stored", "written"), [("NFD", "NFC"), ("NFC", "NFD")])
def test_a_text_is_found_in_the_other_spelling_of_its_letters(
    stored: Spelling, written: Spelling, tmp_path: Path
) -> None:
    """macOS writes ö as two characters: a folder that was copied from there had no größe.md."""
    (tmp_path / normalize(stored, "größe.md")).write_text("We record how you play.", encoding="utf-8")
    file = tmp_path / "study.yaml"
    name = normalize(written, "größe.md")
    file.write_text(SMALL.replace("We record how you play.", f"{{file: {name}}}"), encoding="utf-8")
    assert read_study(file) == parse_study(SMALL) == parse_study(complete_text(file))


@pytest.mark.parametrize(
    ("written", "length"),
    [
        ("text:\n    en:\n      file: >-\n        consent.md\n    de: Ja.", 9),
        ("text:\n    en:\n      file: &name consent.md\n    de:\n      file: *name", 9),
        (f"text: {{{', '.join(f'{one}: {{file: consent.md}}' for one in ('en', 'de', 'fr', 'ja'))}}}", 100_000),
    ],
)
def test_a_study_does_not_begin_with_a_text_that_could_not_be_read_again(
    tmp_path: Path, written: str, length: int
) -> None:
    (tmp_path / "consent.md").write_text("同" * length, encoding="utf-8")
    file = tmp_path / "study.yaml"
    file.write_text(SMALL.replace("text: We record how you play.", written), encoding="utf-8")
    assert read_study(file)
    with pytest.raises(StudyError, match=r"study.yaml cannot be kept .* as \{file: NAME\}"):
        complete_text(file)


@pytest.mark.parametrize("name", ["missing.md", "../secret.md", "/etc/hostname"])
def test_a_file_elsewhere_or_nowhere_is_a_fault(tmp_path: Path, name: str) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(SMALL.replace("text: We record how you play.", f"text: {{en: {{file: {name}}}}}"), encoding="utf-8")
    with pytest.raises(StudyFileError, match=r"study.yaml:7: consent.text.en: "):
        read_study(file)


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_a_file_with_a_line_lost_doubled_or_garbled_is_a_study_or_has_faults_with_lines(data: st.DataObject) -> None:
    lines = SMALL.splitlines(keepends=True)
    at = data.draw(st.integers(0, len(lines) - 1))
    line = data.draw(
        st.sampled_from(["", lines[at] * 2, "  " + lines[at], lines[at].replace(":", ""), "- [\n", "x: *y\n"])
    )
    text = "".join([*lines[:at], line, *lines[at + 1 :]])
    try:
        assert isinstance(parse_study(text), Study)
    except StudyFileError as error:
        assert all(1 <= fault.line <= text.count("\n") + 1 and fault.message for fault in error.faults)


def test_an_unreadable_file_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="cannot read"):
        read_study(tmp_path / "none.yaml")
    (tmp_path / "latin.yaml").write_bytes(b"title: \xe4")
    with pytest.raises(StudyFileError, match="is not UTF-8"):
        read_study(tmp_path / "latin.yaml")


def test_practice_is_the_tutorial_or_a_free_round() -> None:
    practice = parse_study(SMALL + "practice: tutorial\n").practice
    assert practice is not None and practice.tutorial and practice.map == "Tutorial"
    free = parse_study(SMALL + "practice: {map: Simple, limit_ticks: 300}\n").practice
    assert free is not None and (free.tutorial, free.map, free.limit_ticks, free.agent) == (
        False, "Simple", 300, "scripted"
    )  # fmt: skip


@pytest.mark.parametrize(
    ("practice", "said"),
    [("tutor", "practice is tutorial, or map"), ("{tutorial: true, map: HandOff}", "say practice: tutorial")],
)
def test_practice_that_is_neither_is_refused_with_what_works(practice: str, said: str) -> None:
    ((_, path, message),) = faults(SMALL + f"practice: {practice}\n")
    assert path == "practice" and said in message


def test_sounds_are_off_unless_the_file_says_on() -> None:
    assert parse_study(SMALL).sounds == "off"
    assert [parse_study(SMALL + f"sounds: {word}\n").sounds for word in ("on", "off", '"on"')] == ["on", "off", "on"]
    ((_, path, message),) = faults(SMALL + "sounds: loud\n")
    assert path == "sounds" and "'on' or 'off'" in message


@pytest.mark.parametrize(("currency", "due"), [("JPY", "38"), ("USD", "37.92")])
def test_nobody_is_due_parts_of_a_currency_without_cents(currency: str, due: str) -> None:
    study = parse_study(f"{SMALL}pay: {{currency: {currency}, per_hour: 65, maximum: 900}}\n")
    assert str(earned(study, 35)) == due


def test_a_faulty_code_is_one_fault() -> None:
    ((_, path, message),) = faults(SMALL + "codes: {done: ABC}\n")
    assert path == "codes.done" and "4 to 40 letters" in message
