"""`movingout recordings` as a user types it."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.recordings import EpisodeWriter, RecordingError, SeatInfo, finalise
from movingout.recordings.commands import recordings
from movingout.recordings.storage.finished import Recovery
from movingout.recordings.storage.index import path_of
from movingout.server.cli import main
from tests.recordings.support import STARTED_NS, begin, play, record

DAY_NS = 86_400 * 10**9


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three finished recordings and one interrupted journal."""
    folder = tmp_path_factory.mktemp("data")
    recordings = folder / "recordings"
    finalise(record(recordings, ticks=12, episode_id="first")[0])
    bass = (SeatInfo("human", "P-77", device="touch"), SeatInfo("agent", "bass@all"))
    later: dict[str, object] = {"map_name": "LeftRight", "seats": bass, "started_ns": STARTED_NS + DAY_NS, "study": {}}
    finalise(record(recordings, ticks=9, episode_id="second", outcome="left", **later)[0])
    finalise(record(recordings, ticks=3, episode_id="third", outcome="delivered")[0])
    writer, played = begin(recordings, episode_id="broken-off")
    play(writer, played, 4)
    writer.abandon()
    return folder


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
    ("name", "reason"),
    [("foreign.mcap", "is not an MCAP file"), ("notes.txt", "is neither a recording (*.mcap) nor a journal")],
)
def test_recover_leaves_alone_what_is_not_ours(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, reason: str
) -> None:
    path = tmp_path / name
    path.write_bytes(b"not ours")
    assert main(["recordings", "recover", str(path)]) == 2
    assert reason in capsys.readouterr().err
    assert [entry.name for entry in tmp_path.iterdir()] == [name] and path.read_bytes() == b"not ours"


def test_recover_saves_a_torn_recording_and_leaves_a_whole_one_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = finalise(record(tmp_path, ticks=60)[0])
    whole = path.read_bytes()
    assert main(["recordings", "recover", str(path)]) == 0
    assert capsys.readouterr().out == "episode.mcap: 60 ticks, whole; left as it is\n" and path.read_bytes() == whole
    path.write_bytes(whole[: len(whole) // 2])
    assert main(["recordings", "verify", str(path)]) == 2
    assert "save what is whole: movingout recordings recover FILE" in capsys.readouterr().out
    assert main(["recordings", "recover", str(path)]) == 0
    assert "saved from a torn or damaged file up to tick" in capsys.readouterr().out
    assert main(["recordings", "verify", str(path)]) == 0


def test_recover_names_what_is_below_a_folder_and_what_is_damaged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """There was nothing to recover, it said."""
    left, _ = record(tmp_path / "day 1", ticks=6, episode_id="left")
    torn = finalise(record(tmp_path / "day 2", ticks=6, episode_id="torn")[0])
    torn.write_bytes(torn.read_bytes()[:-100])
    (tmp_path / "other.mcap").write_bytes(b"somebody else's")
    assert main(["recordings", "recover", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.out == "left.mcap.journal -> left.mcap: 6 ticks, whole\n" and not left.exists()
    command = f"movingout recordings recover '{torn}'"
    assert said.err == f"movingout: torn.mcap: incomplete or damaged; save what is whole: {command}\n"
    assert main(["recordings", "recover", str(torn)]) == 0
    assert main(["recordings", "recover", str(tmp_path)]) == 0


def test_recover_tells_what_it_did_though_a_folder_below_cannot_be_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def unreadable(folder: Path) -> list[Recovery]:
        raise RecordingError("cannot list lost+found: Permission denied")

    monkeypatch.setattr(recordings, "damaged_below", unreadable)
    record(tmp_path, ticks=6, episode_id="left")
    assert main(["recordings", "recover", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.out == "left.mcap.journal -> left.mcap: 6 ticks, whole\n" and "cannot list lost+found" in said.err


def test_recover_finishes_what_was_left(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    writer, played = begin(tmp_path / "recordings")
    play(writer, played, 4)
    writer.abandon()
    assert main(["recordings", "recover", "--data", str(tmp_path), "--json"]) == 0
    (entry,) = json.loads(capsys.readouterr().out)["journals"]
    assert (entry["ticks"], entry["note"]) == (4, "interrupted after tick 4")
    assert Path(entry["recording"]).name == "episode.mcap"
    assert main(["recordings", "recover", "--data", str(tmp_path)]) == 0
    assert capsys.readouterr().out == "nothing to recover\n"


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


def test_recover_goes_on_after_a_journal_that_it_cannot_finish(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first one ended the command, and those after it stayed journals."""
    folder = tmp_path / "recordings"
    for name in ("a", "b", "c"):
        record(folder, ticks=2, episode_id=name)
    (folder / "a.mcap").write_bytes(b"of a failing disk")
    (folder / "b.mcap.journal").unlink()
    (folder / "b.mcap.journal").mkdir()
    assert main(["recordings", "recover", "--data", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert out == "c.mcap.journal -> c.mcap: 2 ticks, whole\n"
    assert "a.mcap.journal: a.mcap is damaged, move it away and recover again (a.mcap is not an MCAP file)" in err
    assert "b.mcap.journal: cannot open" in err
    (folder / "a.mcap").unlink()
    assert main(["recordings", "recover", str(tmp_path / "gone.mcap"), str(folder), "--json"]) == 2
    entries = json.loads(capsys.readouterr().out)["journals"]
    assert [(Path(one["journal"]).name, one["failed"]) for one in entries] == [
        ("gone.mcap", True),
        ("a.mcap.journal", False),
        ("b.mcap.journal", True),
    ]
