import json
from pathlib import Path
from typing import Any
from unicodedata import normalize

import pytest
from PIL import Image

from movingout.maps import load_map, map_from_json, map_to_json
from movingout.maps.library import loadable_map_names
from movingout.maps.randomize import randomize
from movingout.server.cli import main

Output = pytest.CaptureFixture[str]


def answer(capsys: Output, *arguments: str, code: int = 0) -> Any:
    """The one JSON document that a command prints."""
    assert main(["maps", *arguments, "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_list_names_all_maps_in_the_papers_order(capsys: Output) -> None:
    maps = answer(capsys, "list")["maps"]
    assert [entry["name"] for entry in maps] == list(loadable_map_names())
    assert [entry["number"] for entry in maps][:12] == [*range(1, 13)]
    assert main(["maps", "list"]) == 0
    page = capsys.readouterr().out
    assert "SequentialRotations" in page
    assert "2 small, 1 middle, 1 large" in page


def test_show_gives_the_document_or_a_page(capsys: Output) -> None:
    assert answer(capsys, "show", "CornerDecision") == map_to_json(load_map("CornerDecision"))
    assert main(["maps", "show", "CornerDecision"]) == 0
    page = capsys.readouterr().out
    assert "Map 5: Corner Decision" in page
    assert "goal: x -1.2 to -0.6, y 0.8 to 1.2" in page


def test_show_sketches_the_map_where_colours_are(capsys: Output, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("COLORTERM", "truecolor")
    monkeypatch.setenv("TERM", "xterm-256color")
    assert main(["maps", "show", "HandOff"]) == 0
    assert capsys.readouterr().out.count("▀") == 48 * 24


def test_a_picture_may_end_in_capitals_and_an_svg_has_no_pixels(capsys: Output, tmp_path: Path) -> None:
    assert answer(capsys, "render", "HandOff", "-o", str(tmp_path / "X.PNG"))["format"] == "png"
    assert (tmp_path / "X.PNG").read_bytes().startswith(b"\x89PNG")
    assert main(["maps", "render", "HandOff", "--side", "100", "-o", str(tmp_path / "x.svg")]) == 2
    assert "--side is of a PNG" in capsys.readouterr().err


def test_check_is_silent_about_a_sound_map(capsys: Output) -> None:
    assert answer(capsys, "check", "HandOff") == {"map": "HandOff", "playable": True, "faults": [], "hints": []}


def test_check_gives_hints_for_a_map_that_can_be_played(capsys: Output, tmp_path: Path) -> None:
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(map_to_json(load_map("HandOff")) | {"name": "all"}))
    result = answer(capsys, "check", str(file))
    assert (result["playable"], [hint["path"] for hint in result["hints"]]) == (True, ["name", "number"])
    assert main(["maps", "check", str(file)]) == 0
    assert capsys.readouterr().out.startswith("hint: name: all means the paper's twelve maps")


def test_check_of_a_yaml_file_says_that_maps_are_json(capsys: Output, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("format: 1\n")
    assert main(["maps", "check", str(file)]) == 2
    assert "a map is a JSON file, not YAML" in capsys.readouterr().err


def test_check_prints_every_fault_with_its_path_and_fails(capsys: Output, tmp_path: Path) -> None:
    document = map_to_json(load_map("CornerDecision"))
    document["items"][1]["x"] = 0.0
    document["items"][3]["x"] = 1.19
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(document))
    result = answer(capsys, "check", str(file), code=1)
    assert [fault["path"] for fault in result["faults"]] == ["items[1]", "items[3]"]
    assert main(["maps", "check", str(file)]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == f"{file}: 2 faults"


def test_check_finds_a_faulty_file_and_its_folder_by_the_other_spelling(capsys: Output, tmp_path: Path) -> None:
    document = map_to_json(load_map("CornerDecision"))
    for item in document["items"][:2]:
        item["shape"] = "blob"
    folder = tmp_path / normalize("NFD", "größe")
    folder.mkdir()
    (folder / normalize("NFD", "höhle.json")).write_text(json.dumps(document))
    name = normalize("NFC", f"{tmp_path}/größe")
    assert len(answer(capsys, "check", f"{name}/{normalize('NFC', 'höhle.json')}", code=1)["faults"]) == 2
    assert [len(one["faults"]) for one in answer(capsys, "check", name, code=1)["maps"]] == [2]


def test_check_reads_past_the_first_unreadable_part(capsys: Output, tmp_path: Path) -> None:
    document = map_to_json(load_map("CornerDecision"))
    document["items"][1]["shape"] = "blob"
    document["goals"][0] = "here"
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(document))
    result = answer(capsys, "check", str(file), code=1)
    assert [fault["path"] for fault in result["faults"]] == ["goals[0]", "items[1].shape"]


def test_check_takes_several_files_and_folders(capsys: Output, tmp_path: Path) -> None:
    sound = map_to_json(load_map("CornerDecision")) | {"name": "Mine", "number": 0}
    broken, moved, den = tmp_path / "a.json", tmp_path / "b.json", tmp_path / "c.json"
    broken.write_text("{")
    moved.write_text(json.dumps(sound | {"items": [sound["items"][0] | {"x": 1.19}]}))
    den.write_text(json.dumps(sound | {"number": 5}))
    (tmp_path / "notes.txt").write_text("no map")
    assert main(["maps", "check", "HandOff", str(tmp_path), str(den)]) == 2
    no_json, *lines = capsys.readouterr().out.splitlines()[1:]
    assert no_json.startswith(f"{broken}") and lines == [
        f"{moved}: 1 fault",
        "  items[0]: sticks 0.048 out of the arena; move it inwards (the sides are at 1.2)",
        f"{den}: no faults",
        "  hint: number: numbers are those of the paper's maps; write 0 for a map of your own",
    ]
    broken.unlink()
    found = answer(capsys, "check", str(tmp_path), code=1)["maps"]
    assert [(Path(one["map"]).name, one["playable"], len(one["faults"]), len(one["hints"])) for one in found] == [
        ("b.json", False, 1, 0),
        ("c.json", True, 0, 1),
    ]
    (missing, sound) = answer(capsys, "check", str(tmp_path / "none.json"), "HandOff", code=2)["maps"]
    assert (missing["playable"], missing["faults"][0]["path"], sound["playable"]) == (False, "the map", True)


def test_check_of_a_folder_without_maps_is_wrong_use(capsys: Output, tmp_path: Path) -> None:
    assert main(["maps", "check", str(tmp_path)]) == 2
    assert f"the folder {tmp_path} has no map files" in capsys.readouterr().err


def test_check_of_nothing_is_wrong_use(capsys: Output) -> None:
    assert main(["maps", "check", ""]) == 2
    assert "unknown map ''" in capsys.readouterr().err


def test_check_of_a_broken_official_file_says_what_is_wrong(capsys: Output, tmp_path: Path) -> None:
    file = tmp_path / "1_Own.json"
    file.write_text(json.dumps({"robot_1_pos": [0, 0]}))
    [fault] = answer(capsys, "check", str(file), code=1)["faults"]
    assert fault["message"].startswith("not an official map file: KeyError")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["generate", "--mode", "awareness", "--seed", "1", "--name", "two words"], "--name: 1 to 40 letters, digits"),
        (
            ["generate", "--mode", "awareness", "--seed", "1", "--name", "HandOff"],
            "HandOff is the name of a shipped map",
        ),
        (["gallery", "HandOff", "-o", "maps.txt"], "a gallery is a page; let the name of maps.txt end in .html"),
        (["gallery", "generated:tset:3"], "unknown maps generated:tset:3; did you mean test? known: test, validation"),
        (["gallery", "generated:awarenes:3"], "did you mean awareness? known: test, validation"),
        (["check", "mine.json:mirro"], "unknown symmetry 'mirro' of mine.json; did you mean mirror? known: mirror"),
    ],
)
def test_wrong_names_are_answered_with_what_they_could_be(
    capsys: Output, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.json").write_text(json.dumps(map_to_json(load_map("HandOff"))))
    assert main(["maps", *words]) == 2
    assert sentence in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.json"]


@pytest.mark.parametrize("content", [None, "{", "\x00"])
def test_check_of_what_is_no_json_file_is_wrong_use(capsys: Output, tmp_path: Path, content: str | None) -> None:
    file = tmp_path / "mine.json"
    if content is not None:
        file.write_text(content)
    assert main(["maps", "check", str(file)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("movingout: ")


def test_render_writes_png_and_svg(capsys: Output, tmp_path: Path) -> None:
    picture, drawing = tmp_path / "a.png", tmp_path / "a.svg"
    result = answer(capsys, "render", "HandOff", "-o", str(picture), "--side", "100", "--theme", "dark")
    assert result == {"map": "HandOff", "path": str(picture), "format": "png"}
    with Image.open(picture) as image:
        assert image.size == (100, 100)
    assert main(["maps", "render", "HandOff", "-o", str(drawing)]) == 0
    assert drawing.read_text().startswith("<svg")


def test_render_is_named_after_the_map_by_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["maps", "render", "LeftRight"]) == 0
    assert (tmp_path / "LeftRight.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["show", "HandOf"], "unknown map 'HandOf'; did you mean HandOff?"),
        (["render", "HandOff", "-o", "a.gif"], "let the name end in .png or .svg"),
        (["render", "HandOff", "-o", "nowhere/a.png"], "cannot write nowhere/a.png: No such file or directory"),
        (["render", "HandOff", "--side", "0"], "a picture has 16 to 4096 pixels on a side, not 0"),
        (["randomize", "HandOff", "--seed", "-3"], "a seed is a whole number from 0, not -3"),
        (["randomize", "HandOff", "--seed", "3", "-o", "a.txt"], "let the name end in .json, .png or .svg"),
    ],
)
def test_wrong_use_is_answered_with_what_would_work(
    capsys: Output, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["maps", *arguments]) == 2
    captured = capsys.readouterr()
    assert sentence in captured.err
    assert captured.out == ""


def test_randomize_prints_or_writes_the_variants_document(capsys: Output, tmp_path: Path) -> None:
    expected = randomize(load_map("LeftRight"), 3, "evaluation")
    assert map_from_json(answer(capsys, "randomize", "LeftRight", "--seed", "3", "--split", "evaluation")) == expected
    file = tmp_path / "variant.json"
    assert main(["maps", "randomize", "LeftRight", "--seed", "3", "--split", "evaluation", "-o", str(file)]) == 0
    assert load_map(file) == expected
    assert "challenge2-evaluation-3" in capsys.readouterr().out


def test_an_output_without_a_name_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """It would be the current folder, as where a variable of a script is unset."""
    with pytest.raises(SystemExit, match="2"):
        main(["maps", "gallery", "-o", ""])
    assert "name a file or folder; the current folder is ." in capsys.readouterr().err


@pytest.mark.parametrize("name", ["generated", "generated:awareness:0:easy"])
def test_a_file_whose_map_is_called_as_if_it_were_generated_is_on_a_sheet(name: str, tmp_path: Path) -> None:
    file, page = tmp_path / "mine.json", tmp_path / "page.html"
    file.write_text(json.dumps(map_to_json(load_map("Simple")) | {"name": name}))
    assert main(["maps", "gallery", str(file), "-o", str(page)]) == 0
    assert f"{name}<br><small>" in page.read_text() and "not on the list" in page.read_text()
