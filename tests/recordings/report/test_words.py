"""The sentences of reports exist in every language, with the same places."""

import json
import re
from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.recordings.report.words import LANGUAGES, Words
from tests.support import ROOT

FOLDERS = sorted(ROOT.glob("*/*/languages"))
PLACES = re.compile(r"{\w*}")


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_every_language_has_the_same_keys_and_places_in_all_reports(folder: Path) -> None:
    texts = {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in folder.glob("*.json")}
    assert sorted(texts) == list(LANGUAGES), "a language is there for all reports or for none"
    english = texts.pop("en")
    for language, other in texts.items():
        assert list(english) == list(other), language
        for key, text in english.items():
            assert set(PLACES.findall(text)) == set(PLACES.findall(other[key])), (language, key)


def test_numbers_are_written_as_the_language_does() -> None:
    english, german = Words("en"), Words("de-AT")
    assert [one.decimal("0.5 [-0.1, 0.2]") for one in (english, german)] == ["0.5 [-0.1, 0.2]", "0,5 [-0,1; 0,2]"]
    assert english.say("report.recordings", count=1200) == "1,200 recordings"
    assert german.say("report.recordings", count=1200) == "1.200 Aufzeichnungen"
    assert german.say("report.recordings", count=1) == "1 Aufzeichnung"


def test_a_language_without_texts_is_said_in_english_and_maps_of_ones_own_keep_their_titles() -> None:
    assert Words("fr").language == "en"
    assert Words("de").map_title(load_map("HandOff")) == "Übergabe"
    assert Words("de").known("measure.of_another_package", "Its title") == "Its title"
