"""Languages: what is translated, and that a study keeps the promise of its `languages`."""

import json
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.server.cli import main
from movingout.study.design.instruments import TRANSLATIONS, instrument, instrument_names
from movingout.study.design.localized_text import LocalizedText, nearest
from movingout.study.design.study_file import parse_study
from movingout.study.design.translations import missing_texts, page_words
from movingout.study.errors import StudyFileError
from tests.study.design.small_study import SMALL

GERMAN = (
    SMALL.replace("participants: 4", "participants: 4\nlanguages: [en, de]")
    .replace("text: We record how you play.", "text: {en: We record how you play., de: Wir zeichnen auf.}")
    .replace("text: Please choose 2.,", "text: {en: Please choose 2., de: Bitte 2 wählen.},")
    .replace("{text: They were programs.}", "{text: {en: They were programs., de: Es waren Programme.}}")
)


@pytest.mark.parametrize("language", TRANSLATIONS)
@pytest.mark.parametrize("name", instrument_names())
def test_a_translation_has_every_text_of_the_original_and_changes_nothing_else(name: str, language: str) -> None:
    original, translated = instrument(name), instrument(name, language)
    assert translated.title != original.title
    for item, other in zip(original.items, translated.items, strict=True):
        assert (other.id, other.kind, other.label, other.expected) == (item.id, item.kind, item.label, item.expected)
        assert other.text and other.text != item.text
        assert len(other.options) == len(item.options) and all(other.options)
        assert [bool(end) for end in other.ends] == [bool(end) for end in item.ends]


@pytest.mark.parametrize(
    ("wanted", "found"), [("de-AT", "de-AT"), ("de", "de-AT"), ("de-CH", "de-AT"), ("en-GB", "en"), ("fr", "en")]
)
def test_a_text_is_read_in_the_language_of_another_country_rather_than_in_another_language(
    wanted: str, found: str
) -> None:
    texts = {"en": "of en", "de-AT": "of de-AT"}
    assert LocalizedText(texts).text(wanted) == f"of {found}"
    assert nearest(wanted, ["de", "de-AT"]) == {"de-AT": "de-AT", "de": "de", "de-CH": "de"}.get(wanted)


def test_a_region_has_the_texts_of_its_language_and_an_unknown_language_those_of_the_original() -> None:
    assert instrument("nasa-tlx", "de-AT") == instrument("nasa-tlx", "de")
    assert instrument("nasa-tlx", "fr") == instrument("nasa-tlx")


def test_a_questionnaire_on_the_base_of_a_ready_made_one_speaks_the_language_of_the_participant() -> None:
    items = parse_study(GERMAN).questionnaire("short", "de").items
    texts = {item.id: item.text for item in items}
    assert texts["teamwork"] == "Der andere Agent und ich haben zusammen auf ein Ziel hingearbeitet."
    assert texts["attention"] == "Bitte 2 wählen."


def test_a_study_with_every_text_in_its_languages_misses_none() -> None:
    assert missing_texts(parse_study(GERMAN)) == ()
    assert missing_texts(parse_study(SMALL)) == ()


@pytest.mark.parametrize(
    ("old", "new", "missing"),
    [
        (
            "{en: Please choose 2., de: Bitte 2 wählen.}",
            "Please choose 2.",
            "item 'attention' of questionnaire 'short'",
        ),
        ("de: Es waren Programme.", "fr: Des programmes.", "debrief.text"),
        ("de: Ein Vorversuch", "fr: Un essai", "title"),
    ],
)
def test_each_text_that_is_missing_in_a_promised_language_is_named(old: str, new: str, missing: str) -> None:
    assert old in GERMAN
    found = missing_texts(parse_study(GERMAN.replace(old, new)))
    assert found == (f"{missing} has no text in 'de', which `languages` promises",)


def test_a_ready_made_questionnaire_that_is_not_translated_is_named() -> None:
    french = GERMAN.replace("languages: [en, de]", "languages: [en, fr]").replace("de: ", "fr: ")
    assert missing_texts(parse_study(french)) == (
        "every page has no text in 'fr', which `languages` promises",
        "the ready-made questionnaire 'demographics' has no text in 'fr', which `languages` promises",
        "the ready-made questionnaire 'movingout-paper-nine' has no text in 'fr', which `languages` promises",
        "map 'HandOff' (give its title and description in `map_texts`) has no text in 'fr', which `languages` promises",
        "map 'FourCorners' (give its title and description in `map_texts`) has no text in 'fr', "
        "which `languages` promises",
    )


def test_a_map_of_ones_own_needs_its_texts_in_every_language(tmp_path: Path) -> None:
    own = tmp_path / "Attic.json"
    own.write_text(json.dumps({**map_to_json(load_map("HandOff")), "name": "Attic", "title": "The attic"}))
    study = GERMAN.replace("maps: [HandOff, FourCorners]", f"maps: [HandOff, {own}]")
    found = missing_texts(parse_study(study))
    assert len(found) == 2, "English is not sure either"
    assert all(one.startswith(f"map '{own}' (give its title and description in `map_texts`)") for one in found)
    named = study + f"map_texts: {{{own}: {{title: {{en: Attic, de: Dachboden}}, description: Under the roof.}}}}\n"
    assert missing_texts(parse_study(named)) == (
        f"the description of map '{own}' has no text in 'de', which `languages` promises",
    )
    text = parse_study(named).map_text(str(own), "de")
    assert text == ("Dachboden", "Under the roof.")
    assert "no block plays" in str(fault_of(study + "map_texts: {Loft: {title: Loft, description: High.}}\n"))


def fault_of(text: str) -> StudyFileError:
    with pytest.raises(StudyFileError) as caught:
        parse_study(text)
    return caught.value


def test_the_pages_speak_every_language_that_questionnaires_are_translated_into() -> None:
    for language in TRANSLATIONS:
        assert (page_words(language) or {}).keys() == (page_words("en") or {}).keys()


def test_check_fails_and_names_the_missing_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "study.yaml"
    file.write_text(GERMAN.replace("de: Es waren Programme.", "fr: Des programmes."), encoding="utf-8")
    assert main(["study", "check", str(file)]) == 1
    page = capsys.readouterr().out
    assert "missing: debrief.text has no text in 'de'" in page and "1 text missing" in page
    file.write_text(GERMAN, encoding="utf-8")
    assert main(["study", "check", str(file)]) == 0
