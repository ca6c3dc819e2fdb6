"""Test maps are for measuring: whoever makes demonstrations on them, or trains on them, is told so in one sentence."""

from pathlib import Path

import pytest

from movingout.agents.commands.demonstrations import prove
from movingout.maps.generated.names import test_maps_caution as caution
from movingout.server.cli import main
from tests.agents.learning import recorded

SENTENCE = "what is trained or chosen on test maps is measured too well on them"


def test_the_sentence_names_what_it_is_about() -> None:
    assert caution(["HandOff", "generated:awareness:20000", "generated:training"]) == ""
    assert caution(["generated:test"]).startswith("generated:test is for tests: ")
    assert caution(["generated:awareness:7:hard:mirror"]).startswith("generated:awareness:7:hard:mirror is for tests: ")
    assert caution(["generated", "generated:mine", "generated:mine:b"]) == "", "as map files may be called"
    several = ["generated:awareness:3", "HandOff", "generated:awareness:9", "generated:consistency:1"]
    assert caution(several).startswith("generated:awareness:3 and 2 others are for tests: ")


@pytest.mark.parametrize("split", ["test", "training"])
def test_demonstrations_on_test_maps_and_what_is_trained_on_them(
    split: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = 1 if split == "test" else 0
    few = ["--map", f"generated:{split}:1", "--episodes", "1", "--ticks", "8", "--workers", "1", "--json"]
    labels = tmp_path / "labels"
    assert main(["demos", "label", "--learner", "idle", "--expert", "idle", *few, "--out", str(labels)]) == 0
    assert capsys.readouterr().err.count(SENTENCE) == said
    people = ["--population", "family:porter", "--people", "2"]
    assert main(["demos", "generate", *people, *few, "--out", str(tmp_path / "demos")]) == 0
    assert capsys.readouterr().err.count(SENTENCE) == said
    monkeypatch.setattr(prove, "prove", lambda *words: iter(()))
    assert main(["demos", "prove", "--split", split, "--out", str(tmp_path / "maps.txt")]) == 0
    assert capsys.readouterr().err.count(SENTENCE) == said
    tiny = ["--updates", "1", "--batch", "4", "--width", "8", "--depth", "1", "--data", str(tmp_path)]
    assert main(["train", "mlp", str(tmp_path / "demos"), *tiny]) == 0
    assert capsys.readouterr().err.count(SENTENCE) == said


def test_who_learns_from_recorded_people_for_tests_is_told_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for who in ("B03", "C03"):
        recorded(tmp_path / "plays", who, ticks=8, people=("dp@all", f"person:name={who}"), source="match")
    tiny = ["--updates", "1", "--batch", "4", "--width", "8", "--depth", "1", "--data", str(tmp_path)]
    command = ["train", "mlp", str(tmp_path / "plays"), *tiny]
    assert main(command) == 0
    assert "people of C play in these episodes, who are for tests" in capsys.readouterr().err
    assert main([*command, "--id", "mlp@other", "--without", "people:C"]) == 0
    assert "people of C" not in capsys.readouterr().err
