"""The sentences of reports exist in every language, with the same places."""

import json
import re
from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.matches.report.words import LANGUAGE_FILES as MATCHES
from movingout.recordings.report.words import OWN, Words
from movingout.study.analysis.tables import LANGUAGE_FILES

PLACES = re.compile(r"{\w*}")


@pytest.mark.parametrize("folder", [OWN, LANGUAGE_FILES, MATCHES])
def test_both_languages_have_the_same_keys_and_places(folder: Path) -> None:
    english, german = (json.loads((folder / f"{name}.json").read_text(encoding="utf-8")) for name in ("en", "de"))
    assert list(english) == list(german)
    for key, text in english.items():
        assert set(PLACES.findall(text)) == set(PLACES.findall(german[key])), key


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
