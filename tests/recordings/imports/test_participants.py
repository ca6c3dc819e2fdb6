"""Trajectories that name nobody get their participants from a list."""

import json
from pathlib import Path

import pytest

from movingout.recordings import finalise, read_episode
from movingout.recordings.episode import ROOM_PSEUDONYM, is_room_pseudonym
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import grouped
from movingout.recordings.imports import convert
from movingout.recordings.imports.convert import pseudonym
from movingout.recordings.imports.participants import read_participants, with_participants
from movingout.recordings.imports.sources import read
from movingout.recordings.official_format import dataset_row
from movingout.server.cli import main
from movingout.server.security.tokens import new_id
from tests.recordings.support import record


@pytest.fixture
def rows(tmp_path: Path) -> Path:
    """Three rows of a data set that name nobody; the first has an id of its own."""
    path, lines = tmp_path / "rows.jsonl", []
    for seed in range(3):
        journal, _ = record(tmp_path / f"ours{seed}", ticks=12, map_name="HandOff", seed=seed)
        row = dataset_row(read_episode(finalise(journal)), seed)
        lines.append(
            {name: row[name] for name in ("map_name", "steps_data")} | ({} if seed else {"trajectory_id": "t0"})
        )
    path.write_text("\n".join(map(json.dumps, lines)), encoding="utf-8")
    return path


def test_people_of_the_list_are_divided_into_groups_that_never_met(
    rows: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    second = read(rows)[1].id
    who = tmp_path / "who.csv"
    who.write_text(f"trajectory_id,blue,red\nt0,Ada,Bo\n{second},Bo,Ada\nrows.jsonl row 2,Cy,Di\n", encoding="utf-8")
    command = ["recordings", "import", str(rows), "-o", str(tmp_path / "in"), "--workers", "1"]
    assert main([*command, "--participants", str(who)]) == 0
    said = capsys.readouterr()
    assert "name no participants" not in said.out and "import with a secret --salt" in said.err
    people = {row.people for row in grouped(sorted((tmp_path / "in").glob("*.mcap")), 2)}
    assert len({name for pair in people for name in pair}) == 4 and len(people) == 3
    with pytest.raises(RecordingError, match="3 groups need 3 participants or pairs"):
        grouped(sorted((tmp_path / "in").glob("*.mcap")), 3)


def test_names_of_people_are_imported_without_a_warning_with_a_salt_or_where_agents_have_them(
    rows: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    who = tmp_path / "who.csv"
    who.write_text("trajectory_id,blue,red\nt0,Ada,Bo\n", encoding="utf-8")
    command = ["recordings", "import", str(rows), "--workers", "1"]
    assert main([*command, "-o", str(tmp_path / "nameless")]) == 0
    for name, options in {"secret": ["--salt", "k3"], "agents": ["--kind", "agent"]}.items():
        assert main([*command, "-o", str(tmp_path / name), "--participants", str(who), *options]) == 0
    assert capsys.readouterr().err == ""


def test_names_that_come_too_late_are_not_said_to_be_known(
    rows: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second import said that nothing changed, and no longer that the recordings name nobody."""
    first, who = json.loads(rows.read_text().splitlines()[0]), tmp_path / "who.csv"
    rows.write_text(json.dumps(first))
    who.write_text("trajectory_id,blue,red\nt0,Ada,Bo\n", encoding="utf-8")
    command = ["recordings", "import", str(rows), "--workers", "1", "-o", str(tmp_path / "nameless")]
    named = [*command[:-1], str(tmp_path / "named"), "--participants", str(who)]
    assert main(command) == main([*command, "--participants", str(who), "--salt", "k3"]) == 0
    said = capsys.readouterr().out
    assert "imported before, without names; nothing changed. To name its participants, import it into a new" in said
    assert said.count("! 1 name no participants") == 2
    assert main([*named, "--salt", "k3"]) == main([*named, "--salt", "k3"]) == main([*command[:-1], named[6]]) == 0
    said = capsys.readouterr().out
    assert said.count("imported before; nothing changed\n") == 2 and "name no participants" not in said
    assert main([*named, "--salt", "k4", "--json"]) == 0
    (one,) = json.loads(capsys.readouterr().out)["trajectories"]
    assert "with other names (or another --salt); nothing changed. To import" in one["unchanged"]
    assert one["participants_known"]


@pytest.mark.parametrize("of_one_room", [True, False])
def test_people_whose_import_began_their_names_otherwise_are_the_same(
    of_one_room: bool, rows: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It said "with other names (or another --salt)", and that the recording is to be moved away."""
    who = tmp_path / "who.csv"
    blue = "person-tyncpf" if of_one_room else "person-1"
    who.write_text(f"trajectory_id,blue,red\nt0,{blue},P2\n", encoding="utf-8")
    command = ["recordings", "import", str(rows), "--workers", "1", "-o", str(tmp_path / "in")]
    command += ["--participants", str(who), "--salt"]
    with monkeypatch.context() as before:
        before.setattr(convert, "is_room_pseudonym", lambda _: not of_one_room)
        assert main([*command, "k3"]) == 0
    capsys.readouterr()
    assert main([*command, "k3"]) == 0
    said = capsys.readouterr().out
    assert said.count("imported before; nothing changed\n") == 3 and "other names" not in said
    assert main([*command, "k4"]) == 0
    assert "with other names (or another --salt)" in capsys.readouterr().out


def test_only_names_that_a_room_makes_are_imported_as_such() -> None:
    """People of other data sets are called `person-1`, too, and were said to be another one in each room."""
    of_room = pseudonym(f"{ROOM_PSEUDONYM}{new_id(6)}", "k3")
    assert is_room_pseudonym(of_room) and is_room_pseudonym(pseudonym(of_room, "k4"))
    for name in ("person-1", "person-Ada", "person-alice2", "Ada"):
        assert pseudonym(name, "k3").startswith("P-")


def test_a_list_that_a_german_spreadsheet_saved_is_read(tmp_path: Path) -> None:
    who = tmp_path / "who.csv"
    who.write_text("trajectory_id;blue;red\r\nt0;Ada;Bo\r\n", encoding="utf-8-sig")
    assert read_participants(who) == {"t0": ("Ada", "Bo")}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("trajectory_id,blue,red\nt0,Ada,\n", "line 2: trajectory_id, blue, red are needed, all three"),
        ("id,a,b\nt0,Ada,Bo\n", "has no column trajectory_id; its first line names the columns trajectory_id, blue"),
        ("trajectory_id,blue,red\nt0,Ada,Bo\nt0,Ada,Cy\n", "line 3: t0 was played by others, says an earlier line"),
        ("trajectory_id,blue,red\nt9,Ada,Bo\n", r"t9 is none of the trajectories \(1 such lines\).*'rows.jsonl row 0'"),
    ],
)
def test_a_list_that_does_not_fit_is_refused(text: str, sentence: str, rows: Path, tmp_path: Path) -> None:
    who = tmp_path / "who.csv"
    who.write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=sentence):
        with_participants(read(rows), read_participants(who))


@pytest.fixture
def two_maps(tmp_path: Path) -> Path:
    """Rows as our own export writes them: `trajectory_id` is counted from 0 on each map."""
    path, lines = tmp_path / "dataset.jsonl", []
    for map_name in ("HandOff", "LeftRight"):
        journal, _ = record(tmp_path / map_name, ticks=3, map_name=map_name)
        lines.append(json.dumps(dataset_row(read_episode(finalise(journal)), 0)))
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_the_id_0_of_a_row_names_it(two_maps: Path) -> None:
    one = read(two_maps)[:1]
    (named,) = with_participants(one, {"0": ("Ada", "Bo")})
    assert (named.blue, named.red) == ("Ada", "Bo")


def test_an_id_that_several_trajectories_have_is_refused(two_maps: Path) -> None:
    """Both got the names of the people who played one of them."""
    sources = read(two_maps)
    with pytest.raises(RecordingError, match=r"^0 names several.*'dataset.jsonl row 0' and 'dataset.jsonl row 1'"):
        with_participants(sources, {"0": ("Ada", "Bo")})
    named = with_participants(sources, {"dataset.jsonl row 0": ("Ada", "Bo"), "dataset.jsonl row 1": ("Cy", "Di")})
    assert [source.blue for source in named] == ["Ada", "Cy"]


def test_copies_of_one_trajectory_share_its_name(two_maps: Path) -> None:
    one = read(two_maps)[0]
    assert [source.red for source in with_participants([one, one], {"0": ("Ada", "Bo")})] == ["Bo", "Bo"]
