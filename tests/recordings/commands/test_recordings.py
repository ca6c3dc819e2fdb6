"""`movingout recordings info`, `verify`, and what is the same for several commands, as a user types it."""

import json
import os
from pathlib import Path

import pytest

from movingout.recordings import EpisodeWriter, RecordingError, SeatInfo, finalise
from movingout.recordings.storage.index import path_of
from movingout.server.cli import main
from tests.recordings.support import record


@pytest.mark.parametrize(
    ("command", "named"),
    [("list", ("Eve", "red.mcap")), ("info", ("Eve",)), ("verify", ("red.mcap",)), ("recover", ("red.mcap",))],
)
def test_nobody_commands_a_terminal_by_the_name_of_a_player_or_a_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, named: tuple[str, ...]
) -> None:
    """D20: names come from strangers, files from other people."""
    evil = "Eve\x1b]0;owned\x07\x1b[2J\u202e"
    seats = (SeatInfo("human", evil, device=evil), SeatInfo("agent", evil))
    whole, _ = record(tmp_path, ticks=3, seats=seats, study={"unit": evil})
    finalise(whole)
    (tmp_path / "\x1b[31mred.mcap").write_bytes(b"no recording")
    (tmp_path / "\x1b[31mred.mcap.journal").write_bytes(b"no journal")
    main(["recordings", command, str(tmp_path / "episode.mcap" if command == "info" else tmp_path)])
    said = "".join(capsys.readouterr())
    assert [name for name in named if name not in said] == []
    assert not {"\x1b", "\x07", "\u202e"} & set(said), said


def test_info_has_the_promised_fields(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "info", "first", "--data", str(data), "--json"]) == 0
    info = json.loads(capsys.readouterr().out)
    promised = ("path", "map", "ticks", "blue", "red", "seed", "outcome", "metrics", "versions", "finalised")
    assert set(promised) <= info.keys()
    assert (info["map"], info["ticks"], info["seed"], info["outcome"]) == ("HandOff", 12, 7, "time")
    assert (info["blue"]["name"], info["red"]["name"], info["finalised"]) == ("P-3f2a", "scripted", True)


def test_info_of_a_journal_says_that_it_is_unfinished(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(data / "recordings" / "broken-off.mcap.journal")
    assert main(["recordings", "info", path, "--json"]) == 0
    info = json.loads(capsys.readouterr().out)
    assert (info["finalised"], info["outcome"], info["ticks"]) == (False, "interrupted", 4)


def test_info_for_people_says_who_played_what_and_how_it_ended(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "info", "second", "--data", str(data)]) == 0
    page = capsys.readouterr().out
    for words in ("Left Right", "human P-77 on touch", "agent bass@all", "0.9 s of 50.0 s", "somebody left", "TCR"):
        assert words in page


def test_verify_of_a_folder_answers_for_every_file(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "verify", str(data / "recordings"), "--json", "--workers", "1"]) == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert sorted((Path(f["path"]).name, f["ticks"]) for f in files) == [
        ("broken-off.mcap.journal", 4),
        ("first.mcap", 12),
        ("second.mcap", 9),
        ("third.mcap", 3),
    ]
    assert all(f["identical"] and f["first_divergence"] is None for f in files)


def test_verify_looks_into_the_folders_below(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for folder in (data / "recordings", data):
        assert main(["recordings", "verify", str(folder), "--json", "--workers", "1"]) == 0
        found.append({file["path"] for file in json.loads(capsys.readouterr().out)["files"]})
    assert found[0] == found[1] != set()


def test_verify_over_several_processes_gives_the_same_answers(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "verify", str(data / "recordings"), "--workers", "2"]) == 0
    assert capsys.readouterr().out.count("equal to the bit") == 4


def test_verify_exits_with_1_on_a_divergence_and_names_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, played = record(tmp_path / "true", ticks=5)
    writer = EpisodeWriter.create(tmp_path, played.header, played.world.state())
    path = finalise(writer.close("time"))
    assert main(["recordings", "verify", str(path), "--json"]) == 1
    (entry,) = json.loads(capsys.readouterr().out)["files"]
    assert entry["identical"] is False
    assert entry["first_divergence"]["tick"] == 5


def test_verify_exits_with_2_on_what_it_cannot_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.mcap").write_text("hello")
    assert main(["recordings", "verify", str(tmp_path)]) == 2
    assert "x.mcap is not an MCAP file" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["list", "nowhere"], "there is no such file or folder"),
        (["info", "nobody"], "there is no recording 'nobody'"),
        (["info", "../../etc/passwd"], "there is no recording '../../etc/passwd'"),
        (["verify", "nowhere.mcap.journal"], None),
        (["verify", "."], "no recordings to verify there"),
        (["recover", "nowhere"], "there is no such file"),
    ],
)
def test_wrong_use_gets_a_sentence_and_exit_code_2(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    sentence: str | None,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["recordings", *arguments]) == 2
    out, err = capsys.readouterr()
    assert (sentence or "there is no such file") in (err or out)
    assert "Traceback" not in err


@pytest.mark.parametrize("command", ["verify x", "report x", "import x", "diversity x"])
def test_a_number_of_processes_that_cannot_be_is_refused(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["recordings", *command.split(), "--workers", "0"])
    assert "--workers: it must be at least 1" in capsys.readouterr().err


def test_an_episode_id_never_leaves_its_folder(data: Path) -> None:
    assert path_of(data / "recordings", "first").name == "first.mcap"
    assert path_of(data / "recordings", "broken-off").name == "broken-off.mcap.journal"
    (data / "secret.mcap").touch()
    for name in ("../secret", "..%2fsecret", "", ".", os.sep + "etc"):
        with pytest.raises(RecordingError, match="there is no recording"):
            path_of(data / "recordings", name)
