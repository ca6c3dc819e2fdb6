"""`movingout recordings list` as a user types it."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.recordings import finalise
from movingout.server.cli import main
from tests.recordings.support import begin, record


def ids(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [entry["id"] for entry in json.loads(capsys.readouterr().out)["recordings"]]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], {"first", "second", "third", "broken-off"}),
        (["--map", "LeftRight"], {"second"}),
        (["--agent", "bass"], {"second"}),
        (["--study", "pilot"], {"first", "third", "broken-off"}),
        (["--outcome", "interrupted"], {"broken-off"}),
        (["--since", "2026-09-22"], {"second"}),
        (["--until", "2026-09-21"], {"first", "third", "broken-off"}),
    ],
)
def test_list_filters(data: Path, capsys: pytest.CaptureFixture[str], options: list[str], expected: set[str]) -> None:
    assert main(["recordings", "list", "--data", str(data), "--json", *options]) == 0
    assert set(ids(capsys)) == expected


@pytest.mark.parametrize(
    ("options", "hint"),
    [
        (["--map", "HandOf"], "no map 'HandOf'; maps here: HandOff, LeftRight"),
        (["--agent", "basss"], "nobody named 'basss'; here played: agent bass@all, "),
    ],
)
def test_a_filter_that_names_what_is_not_there_says_what_is(
    data: Path, capsys: pytest.CaptureFixture[str], options: list[str], hint: str
) -> None:
    assert main(["recordings", "list", "--data", str(data), *options]) == 0
    assert hint in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--since", "yesterday"], "'yesterday' is no day; write it like 2026-11-20"),
        (["--outcome", "won"], "--outcome: unknown value 'won'; known: delivered, time"),
    ],
)
def test_a_filter_that_means_nothing_is_refused(
    data: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["recordings", "list", "--data", str(data), *options])
    assert sentence in capsys.readouterr().err


def test_list_for_people_has_one_line_each_newest_first(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "list", "--data", str(data)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert lines[1].split()[0] == "second"
    assert "agent bass@all" in lines[1]


def test_a_map_that_somebody_drew_is_listed_by_its_title(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawn = replace(load_map("LeftRight"), name="map-w2xkq", title="Grandma's kitchen")
    finalise(record(tmp_path, ticks=2, episode_id="finished", map=drawn)[0])
    finalise(record(tmp_path, ticks=2, episode_id="other", map_name="LeftRight")[0])
    begin(tmp_path, episode_id="running", map=drawn)[0].abandon()
    assert main(["recordings", "list", str(tmp_path), "--map", "Grandma's kitchen"]) == 0
    _, *lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 and all("  Grandma's kitchen  " in line and "w2xkq" not in line for line in lines)
    assert main(["recordings", "list", str(tmp_path), "--map", "map-w2xkq", "--json"]) == 0
    assert set(ids(capsys)) == {"finished", "running"}
    assert main(["recordings", "list", str(tmp_path), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["recordings"]
    assert {(row["map"], row["title"]) for row in rows} == {("map-w2xkq", "Grandma's kitchen"), ("LeftRight", "")}
    assert main(["recordings", "list", str(tmp_path), "--map", "map-w2xkq", "--study", "other"]) == 0
    assert capsys.readouterr().out == "no recordings that match\n", "the map is there"


def test_before_the_first_game_list_says_how_to_record_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recordings", "list", "--data", str(tmp_path)]) == 0  # there is no folder yet
    assert main(["recordings", "list", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert said.count("Nothing has been recorded yet") == said.count("movingout play") == 2
    assert [line.split("  ")[0] or line.split()[1] for line in said.splitlines()] == [
        f"Nothing has been recorded yet in {tmp_path / 'recordings'}. Two ways to change that:",
        "play",
        "match",
        f"Nothing has been recorded yet in {tmp_path}. Two ways to change that:",
        "play",
        "match",
    ]
    assert main(["recordings", "list", "--data", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"recordings": [], "unreadable": []}
    assert main(["recordings", "recover", "--data", str(tmp_path)]) == 0


def test_list_names_what_it_cannot_read_and_goes_on(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "recordings"
    finalise(record(folder, ticks=2)[0])
    (folder / "half.mcap").write_bytes((folder / "episode.mcap").read_bytes()[:5000])
    (folder / "empty.mcap").touch()
    (folder / "short.mcap").write_bytes((folder / "episode.mcap").read_bytes()[:20])
    assert main(["recordings", "list", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert "episode" in out
    assert "half.mcap is incomplete or damaged" in err
    assert "empty.mcap is empty" in err
    assert "short.mcap is incomplete or damaged" in err


def test_an_unreadable_file_is_named_with_its_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "one.mcap").write_bytes(b"x")
    assert main(["recordings", "list", str(tmp_path)]) == 0
    assert capsys.readouterr().err == f"movingout: {tmp_path}/one.mcap is not an MCAP file\n"


def test_links_that_lead_nowhere_are_named_and_stop_no_command_for_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One such link used to be passed over in silence, and one that leads to itself stopped the whole list."""
    finalise(record(tmp_path, ticks=2)[0])
    (tmp_path / "gone.mcap").symlink_to(tmp_path / "elsewhere.mcap")
    (tmp_path / "loop.mcap").symlink_to("loop.mcap")
    (tmp_path / "running.mcap.journal").symlink_to(tmp_path / "elsewhere.mcap.journal")
    wanted = ("gone.mcap: it is a link to a file that is not there", "loop.mcap: it is a link that leads back")
    for _ in range(2):  # the second list is that of the index
        assert main(["recordings", "list", str(tmp_path)]) == 0
        out, err = capsys.readouterr()
        assert "episode" in out and all(sentence in err for sentence in wanted)
        assert "running.mcap.journal: it is a link to a file that is not there" in err
    for command in ("failures", "diversity"):
        assert main(["recordings", command, str(tmp_path)]) == 0
    assert "2 unreadable" in capsys.readouterr().err
