"""What a study is warned of although its file can be read."""

import json
from pathlib import Path
from typing import Any

import pytest

from movingout.maps import load_map, map_to_json
from movingout.study.design.review import map_warnings, review
from movingout.study.design.study_file import parse_study
from tests.study.design.small_study import SMALL


@pytest.mark.parametrize(
    ("practice", "warned"),
    [
        ("tutorial", False),
        ("{map: Simple, agent: scripted}", True),
        ("{map: Simple, agent: idle}", False),
        ("{map: LeftRight, agent: scripted}", False),
    ],
)
def test_a_practice_partner_who_can_finish_alone_is_warned_of(practice: str, warned: bool) -> None:
    found = review(parse_study(SMALL + f"practice: {practice}\n")).warnings
    assert any("can deliver everything on Simple alone" in warning for warning in found) == warned


def test_own_maps_that_cannot_be_played_or_have_one_name_are_warned_of(tmp_path: Path) -> None:
    document = map_to_json(load_map("HandOff")) | {"name": "Den", "number": 0}
    closed = {"walls": [{"x0": -1.2, "y0": 0.05, "x1": 1.2, "y1": 0.0}], "name": "Shut"}
    files: dict[str, dict[str, Any]] = {"den": {}, "copy": {}, "closed": closed, "numbered": {"number": 3}}
    for file, changes in files.items():
        (tmp_path / f"{file}.json").write_text(json.dumps(document | changes))
    paths = {file: str(tmp_path / f"{file}.json") for file in ("den", "copy", "closed")}
    study = parse_study(
        SMALL.replace("FourCorners", ", ".join(paths.values())) + f"practice: {{map: {tmp_path}/numbered.json}}\n"
    )
    found = list(map_warnings(study))
    assert [one.partition(": ")[0] for one in found[:2]] == [
        f"{paths['closed']} cannot be played as it should",
        f"{tmp_path}/numbered.json",
    ]
    assert found[2:] == [
        f"{paths['den']} and {paths['copy']} have one name, Den, and are one map in recordings and training sets; "
        "change it in the files"
    ]
    assert set(found) <= set(review(study).warnings)


def test_a_wait_that_is_shorter_than_absences_are_noticed_is_warned_of() -> None:
    def warned(text: str) -> bool:
        return any("a closed page is noticed after 25 s" in one for one in review(parse_study(text)).warnings)

    blocks = "blocks: [{id: play, maps: [HandOff], limit_ticks: 20}]"
    pair = f"format: 1\nid: pair\ntitle: T\nparticipants: 4\ngroup: 2\nconsent: {{version: a, text: T}}\n{blocks}\n"
    assert warned(pair + "pairing: {return_s: 24}\n")
    assert not warned(pair + "pairing: {return_s: 25}\n")
    assert not warned(SMALL + "pairing: {return_s: 5}\n"), "who plays with agents keeps nobody waiting"


def test_pay_without_a_maximum_is_warned_of() -> None:
    def warned(pay: str) -> bool:
        found = review(parse_study(f"{SMALL}pay: {pay}\n")).warnings
        return any(one.startswith("pay has no maximum") for one in found)

    assert warned("{per_hour: 15}") and not warned("{per_hour: 15, maximum: 20}")
    assert not [one for one in review(parse_study(SMALL)).warnings if "maximum" in one]


@pytest.mark.parametrize(
    ("old", "new", "warning"),
    [
        ("format: 1", "format: 1\nlanguages: [en, en]", "languages: en is named more than once"),
        ("- id: play", "- id: play\n    split: train", "block play: split has no effect without challenge: 2"),
        (
            "- id: play",
            "- id: play\n    break_after_maps: 2",
            "block play: no break comes, because break_after_maps is 2 of 2 maps",
        ),
    ],
)
def test_what_has_no_effect_is_warned_of(old: str, new: str, warning: str) -> None:
    assert warning in review(parse_study(SMALL.replace(old, new))).warnings
    assert warning not in review(parse_study(SMALL)).warnings


def test_a_break_and_a_split_that_have_an_effect_are_not_warned_of() -> None:
    text = SMALL.replace("- id: play", "- id: play\n    break_after_maps: 1\n    challenge: 2\n    split: train")
    assert not [one for one in review(parse_study(text)).warnings if "no effect" in one or "no break" in one]
