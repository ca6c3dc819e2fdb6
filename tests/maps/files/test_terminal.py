"""What others wrote into files reaches no terminal as anything but letters."""

import json
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.maps.commands.sentences import tell
from movingout.maps.errors import MovingOutError
from movingout.maps.files.terminal import printable, printable_lines
from movingout.server import cli

EVIL = "Eve\x1b]0;owned\x07\x1b[2J"
SHOWN = "Eve�]0;owned��[2J"


def test_a_name_writes_nothing_on_the_terminal_but_letters() -> None:
    assert printable(f"{EVIL}\r\nP1\u202e") == f"{SHOWN}��P1�"
    assert printable("Zoë 李 ✓") == "Zoë 李 ✓"


def test_lines_stay_lines_and_bytes_that_are_no_utf_8_are_told() -> None:
    assert printable_lines(f"one {EVIL}\n  two \udcff") == f"one {SHOWN}\n  two \\udcff"


def test_an_error_that_quotes_a_file_moves_no_cursor(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(arguments: list[str]) -> int:
        raise MovingOutError(f"recording format {EVIL} is unknown\nupdate it")

    monkeypatch.setattr(cli, "_perform", fail)
    assert cli.main(["recordings"]) == 2
    assert capsys.readouterr().err == f"movingout: recording format {SHOWN} is unknown\nupdate it\n"


def test_what_a_command_says_beside_its_answer_does_neither(capsys: pytest.CaptureFixture[str]) -> None:
    tell(f"{EVIL}\nfailed")
    assert capsys.readouterr().err == f"movingout: {SHOWN}\nfailed\n"


def test_neither_does_a_grid(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, agent = tmp_path / "grid.yaml", f"mlp@{EVIL}"
    file.write_text(json.dumps({"name": EVIL, "agents": [agent], "maps": ["HandOff"]}), encoding="utf-8")
    assert cli.main(["match", "grid", str(file), "--dry-run"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"{SHOWN}: ") and "missing: " in shown
    assert not {"\x1b", "\x07"} & set(shown)


def test_neither_does_a_map_that_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = map_to_json(load_map("HandOff")) | {"name": "Mine", "title": EVIL, "description": f"{EVIL}\nsecond"}
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(document), encoding="utf-8")
    assert cli.main(["maps", "show", str(file)]) == 0
    shown = capsys.readouterr().out
    assert SHOWN in shown
    assert "second" in shown
    assert "\x1b" not in shown
