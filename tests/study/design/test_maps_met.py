"""An agent that cannot see all of a map of one's own is named before any participant meets it there."""

import json
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.server.cli import main
from movingout.study.design.maps_met import maps_met
from movingout.study.design.review import review
from movingout.study.design.study_file import parse_study, read_study
from tests.study.design.small_study import SMALL

GOALS = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
SEEN = "the layout relative-v1 has 4 slots for goals; Five has 5"


def write_study(folder: Path, text: str) -> Path:
    """A study file with maps/five.json beside it, which has a goal more than trained agents see."""
    (folder / "maps").mkdir()
    five = map_to_json(load_map("Simple")) | {"name": "Five", "number": 0, "goals": GOALS}
    (folder / "maps" / "five.json").write_text(json.dumps(five))
    (folder / "study.yaml").write_text(text.replace("FourCorners", "maps/five.json"), encoding="utf-8")
    return folder / "study.yaml"


@pytest.mark.parametrize("options", [(), ("--rehearse", "2")])  # with which `simulate` starts it
def test_a_partner_that_cannot_see_a_map_of_its_block_is_refused(
    options: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_study(tmp_path, SMALL.replace("agent: scripted", "agent: bass@any"))
    assert main(["study", "check", str(file)]) == 1
    page = capsys.readouterr().out
    assert f"missing: bass@any cannot play maps/five.json: {SEEN}\n" in page
    assert "not ready: 1 agent that cannot play" in page
    assert main(["study", "serve", str(file), "--data", str(tmp_path / "data"), "--port", "0", *options]) == 2
    said = capsys.readouterr().err
    assert f"movingout: bass@any cannot play maps/five.json: {SEEN}\nthe study cannot run" in said


def test_an_agent_is_one_sentence_however_many_maps_it_cannot_see(tmp_path: Path) -> None:
    text = SMALL.replace("agent: scripted", "agent: bass@any").replace("HandOff", "'maps/five.json:mirror'")
    (sentence,) = review(read_study(write_study(tmp_path, text))).refused
    assert sentence.count("bass@any cannot play") == 2


@pytest.mark.parametrize(
    ("agent", "practice", "found"),
    [("scripted", "bass@any", 1), ("bass@any:stepp=3", "scripted", 1), ("nobody@all", "scripted", 1)],
)
def test_practice_counts_and_an_unknown_agent_is_named_once(
    agent: str, practice: str, found: int, tmp_path: Path
) -> None:
    text = SMALL.replace("agent: scripted", f"agent: '{agent}'")
    text += f"practice: {{map: FourCorners, agent: '{practice}'}}\n"
    reviewed = review(read_study(write_study(tmp_path, text)))
    assert len(reviewed.missing) + len(reviewed.refused) == found


def test_who_plays_where() -> None:
    in_practice = parse_study(SMALL + "practice: {map: Simple, agent: clone}\n")
    both = [(agent, name) for agent in ("scripted", "idle") for name in ("HandOff", "FourCorners")]
    assert maps_met(in_practice) == (*both, ("clone", "Simple"))
    assert maps_met(parse_study(SMALL + "practice: tutorial\n")) == tuple(both)
    alone = SMALL.replace("    partners: [one, two]\n", "").replace("participants", "group: 2\nparticipants")
    assert maps_met(parse_study(alone)) == ()
    pairs = parse_study(alone + "pairing: {otherwise: agent, agent: clone}\npractice: {map: Simple}\n")
    assert maps_met(pairs) == tuple(("clone", name) for name in ("HandOff", "FourCorners", "Simple"))
