"""Recordings are divided into groups that share no participant, and the list of them is read back."""

import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import load_map
from movingout.recordings import read_episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import group_sentences, grouped, of_group, read_groups, write_groups
from movingout.recordings.storage.copies import without_copies
from movingout.recordings.storage.finished import recover
from movingout.server.cli import main
from tests.agents.learning import recorded
from tests.recordings.full_disk import limited
from tests.recordings.support import begin, not_counted, play, record

PAIRS = ("a", "b"), ("c", "d"), ("e", "f"), ("b", "g")


def _episodes(folder: Path) -> list[Path]:
    return [recorded(folder, f"{one}{two}", ticks=9, people=(one, two)) for one, two in PAIRS]


def test_nobody_is_in_two_groups_and_the_seed_decides(tmp_path: Path) -> None:
    paths = _episodes(tmp_path)
    rows = grouped(paths, 2, seed=0)
    people = [{name for row in rows if row.group == group for name in row.people} for group in (1, 2)]
    assert people[0] | people[1] == set("abcdefg") and not people[0] & people[1]
    assert rows == grouped(paths, 2, seed=0)
    assert len({tuple(row.group for row in grouped(paths, 2, seed=seed)) for seed in range(8)}) > 1
    assert {row.group for row in grouped(paths, 3)} == {1, 2, 3}


def test_too_few_participants_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"4 groups need 4 participants or pairs .* these recordings have 3"):
        grouped(_episodes(tmp_path), 4)
    with pytest.raises(RecordingError, match=r"have 1 \(participants: 2 \(a, b\)\); add recordings of other people"):
        grouped([recorded(tmp_path / "one", "one", ticks=9)], 2)


def test_poor_episodes_are_left_out(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none of 4 recordings has a TCR of 0\.5 or more"):
        grouped(_episodes(tmp_path), 1, min_tcr=0.5)
    with pytest.raises(RecordingError, match="there are no recordings"):
        grouped([], 1)


def test_live_rounds_that_were_broken_off_are_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    left = recorded(tmp_path, "left", ticks=9, source="live", outcome="left")
    with pytest.raises(RecordingError, match="none of 1 recording counts: they are tutorials, were broken off, or"):
        grouped([left], 1)
    short = recorded(tmp_path, "short", ticks=9, source="import", outcome="stopped", seed=1)
    ended = recorded(tmp_path, "ended", ticks=9, source="live")
    assert {row.path for row in grouped([left, short, ended], 1)} == {short, ended}
    assert main(["recordings", "split", str(tmp_path), "--groups", "1", "-o", str(tmp_path / "groups.csv")]) == 0
    assert "2 recordings in" in (shown := capsys.readouterr().out) and "; 1 left out" in shown


def test_the_two_challenges_are_told_apart_and_divided_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A `collect` study has both: its agents of Challenge 1 are not to learn from varied maps."""
    _episodes(tmp_path)
    recorded(tmp_path, "varied", ticks=9, people=("a", "b"), the_map=replace(load_map("HandOff"), variant="one"))
    split = ["recordings", "split", str(tmp_path), "--groups", "1", "-o", str(tmp_path / "groups.csv")]
    assert main(split) == 0
    assert "group 1: 5 episodes of 7 participants, 1 of them on varied maps" in capsys.readouterr().out
    assert main([*split, "--challenge", "2"]) == 0
    shown = capsys.readouterr().out
    assert "1 recording in" in shown and "; 4 left out" in shown
    assert "group 1: 1 episode of 2 participants, 1 of them on varied maps" in shown
    assert main([*split, "--challenge", "1"]) == 0
    assert "group 1: 4 episodes of 7 participants\n" in capsys.readouterr().out
    (tmp_path / "varied.mcap").unlink()
    assert main([*split, "--challenge", "2"]) == 2
    assert "none of 4 recordings is on a varied map (Challenge 2)" in capsys.readouterr().err


def test_episodes_of_a_rehearsal_do_not_pass_for_those_of_people(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded(tmp_path, "people", ticks=9)
    recorded(tmp_path, "programs", ticks=9, simulated=True)
    target = tmp_path / "groups.csv"
    assert main(["recordings", "split", str(tmp_path), "--groups", "1", "-o", str(target)]) == 0
    assert "2 episodes of 2 participants; 1 by simulated participants, who are programs" in capsys.readouterr().out
    assert {row.episode: row.simulated for row in read_groups(target)} == {"people": False, "programs": True}
    lines = target.read_text(encoding="utf-8").splitlines()
    target.write_text("\n".join(line.rpartition(",")[0] for line in lines), encoding="utf-8")
    assert not any(row.simulated for row in read_groups(target)), "lists of before do not say"


def test_the_list_is_read_back_wherever_its_folder_lies(tmp_path: Path) -> None:
    _episodes(tmp_path / "here" / "recordings")
    rows = grouped(sorted((tmp_path / "here" / "recordings").glob("*.mcap")), 2)
    write_groups(tmp_path / "here" / "groups.csv", rows)
    (tmp_path / "here").rename(tmp_path / "there")
    again = read_groups(tmp_path / "there" / "groups.csv")
    assert [row[1:] for row in again] == [row[1:] for row in rows] and all(row.path.exists() for row in again)
    first = of_group(tmp_path / "there" / "groups.csv", 1)
    assert first == [row.path for row in again if row.group == 1]
    with pytest.raises(RecordingError, match=r"has no group 3; it has 1 \(\d episodes\)"):
        of_group(tmp_path / "there" / "groups.csv", 3)


def test_a_list_that_is_none_is_refused_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "groups.csv"
    file.write_text("file,group,episode,map,variant,blue,red,tcr\nx.mcap,one,x,HandOff,,a,b,0.5\n")
    with pytest.raises(RecordingError, match="line 2: not a line of `movingout recordings split`"):
        read_groups(file)
    file.write_text("file,group,episode,map,variant,blue,red,tcr\nx.mcap,1,x,HandOff,,a,b,0.5\n")
    with pytest.raises(RecordingError, match=r"x\.mcap, which is not there"):
        read_groups(file)


def test_sentences_name_the_maps_that_a_group_lacks(tmp_path: Path) -> None:
    rows = grouped(_episodes(tmp_path), 2)
    moved = [row._replace(map="LeftRight") if row.group == 2 else row for row in rows]
    first, second = group_sentences(moved)
    assert first.endswith("no episode on LeftRight") and second.endswith("no episode on HandOff")


def test_the_command_writes_the_list(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _episodes(tmp_path)
    out = tmp_path / "groups.csv"
    assert main(["recordings", "split", str(tmp_path), "--groups", "2", "-o", str(out)]) == 0
    assert "4 recordings in" in capsys.readouterr().out and len(read_groups(out)) == 4
    assert main(["recordings", "split", str(tmp_path), "--groups", "9", "-o", str(out)]) == 2
    assert "9 groups need 9 participants" in capsys.readouterr().err
    assert main(["recordings", "split", str(tmp_path), "--min-tcr", "2", "-o", str(out)]) == 2


def test_a_list_that_a_spreadsheet_saved_is_read(tmp_path: Path) -> None:
    """Excel's "CSV UTF-8" begins with a mark, and was refused at line 2."""
    out = tmp_path / "groups.csv"
    write_groups(out, grouped(_episodes(tmp_path), 2))
    before = read_groups(out)
    out.write_text(out.read_text(encoding="utf-8"), encoding="utf-8-sig")
    assert read_groups(out) == before
    german = "\n".join(line.replace(".", "#").replace("#mcap", ".mcap") for line in out.read_text("utf-8-sig").split())
    out.write_text(german.replace(",", ";").replace("#", ","), encoding="utf-8-sig")
    assert "0,0000;" in out.read_text("utf-8-sig")
    assert read_groups(out) == before, "decimals have a comma there, so that columns need another sign"


def test_recordings_in_folders_below_are_divided_too_each_once(tmp_path: Path) -> None:
    for number, (one, two) in enumerate(PAIRS):
        recorded(tmp_path / "day" / str(number), f"{one}{two}", ticks=9, people=(one, two))
    out = tmp_path / "groups.csv"
    assert main(["recordings", "split", str(tmp_path), str(tmp_path / "day"), "-o", str(out)]) == 0
    assert sorted(row.path for row in read_groups(out)) == sorted((tmp_path / "day").rglob("*.mcap"))


def test_what_was_cut_off_is_left_out_wherever_it_was_played(tmp_path: Path) -> None:
    """Of an import or a demonstration that was killed, the part that was recovered was listed."""
    for source in ("import", "scripted"):
        writer, played = begin(tmp_path, episode_id=f"{source}-cut", source=source)
        play(writer, played, 5)
        writer.abandon()
    cut = [one.recording for one in recover(tmp_path) if one.recording is not None]
    whole = recorded(tmp_path, "whole", ticks=9, source="import", outcome="stopped")
    assert [row.path for row in grouped([*cut, whole], 1)] == [whole]


@pytest.mark.parametrize("names", [("", ""), ("a", "")])
def test_people_without_a_name_are_in_one_group_or_none(tmp_path: Path, names: tuple[str, str]) -> None:
    """Each episode of theirs would be a participant of its own, and groups would share people."""
    nameless = recorded(tmp_path, "nameless", ticks=9, people=names, kinds=("human", "human"))
    named = [recorded(tmp_path, f"{number}", ticks=9, people=(f"{number}", "")) for number in range(2)]
    assert {row.group for row in grouped(named, 2)} == {1, 2}, "of a seat that nobody sits in there is no name"
    with pytest.raises(RecordingError, match=r"1 of 3 recordings does not say who played, .*--participants of"):
        grouped([nameless, *named], 2)
    assert len(grouped([nameless, *named], 1)) == 3


def test_a_full_disk_leaves_no_part_of_a_list(tmp_path: Path) -> None:
    """Half a list would pass for a whole one: `paper tables` goes on with a list that is there."""
    rows, target = grouped(_episodes(tmp_path), 2), tmp_path / "groups.csv"
    with pytest.raises(RecordingError, match="cannot write"), limited(60):
        write_groups(target, rows)
    assert not list(tmp_path.glob("*groups.csv*"))


def test_a_file_whose_name_is_not_utf8_is_refused_in_a_sentence(tmp_path: Path) -> None:
    odd = recorded(tmp_path, "odd", ticks=9).rename(tmp_path / os.fsdecode(b"caf\xe9.mcap"))
    with pytest.raises(RecordingError, match=r"caf\\xe9\.mcap: its name is not UTF-8 text; rename it"):
        write_groups(tmp_path / "groups.csv", grouped([odd], 1))


def test_a_copy_is_in_no_group(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A backup, or a copy under another name, was learned from twice."""
    paths = _episodes(tmp_path / "day")
    shutil.copytree(tmp_path / "day", tmp_path / "backup")
    copy = Path(shutil.copy(paths[0], tmp_path / "day" / "mine.mcap"))
    assert sorted(row.episode for row in grouped([copy, *paths], 2)) == sorted(path.stem for path in paths)
    out = tmp_path / "groups.csv"
    assert main(["recordings", "split", str(tmp_path), "--groups", "2", "-o", str(out)]) == 0
    assert f"4 recordings in {out}; 5 left out, 5 copies among them\n" in capsys.readouterr().out
    assert len({row.episode for row in read_groups(out)}) == len(read_groups(out)) == 4


def test_a_copy_elsewhere_of_what_a_study_does_not_count_is_left_out_too(tmp_path: Path) -> None:
    """The copy has no study beside it, and sorts before the recording."""
    paths = _episodes(tmp_path / "recordings")
    not_counted(tmp_path, "ab")
    backup = tmp_path / "backup" / "recordings"
    shutil.copytree(tmp_path / "recordings", backup)
    out = tmp_path / "groups.csv"
    assert (
        main(["recordings", "split", str(backup), str(tmp_path / "recordings"), "--groups", "1", "-o", str(out)]) == 0
    )
    assert {row.episode for row in read_groups(out)} == {path.stem for path in paths} - {"ab"}


def test_of_copies_it_is_the_whole_one_and_the_one_named_by_its_episode(tmp_path: Path) -> None:
    path = recorded(tmp_path, "b-whole", ticks=9)
    renamed = Path(shutil.copy(path, tmp_path / "a-renamed.mcap"))
    assert without_copies([renamed, path]) == [path]
    began = read_episode(path).header.started_ns
    writer, played = begin(tmp_path / "cut", episode_id="b-whole", started_ns=began)
    play(writer, played, 5)
    writer.abandon()
    (cut,) = recover(tmp_path / "cut")
    assert cut.recording is not None and without_copies([cut.recording, renamed]) == [renamed]
    again = record(tmp_path / "again", ticks=5, episode_id="b-whole", started_ns=began + 1)[0]
    assert without_copies([again, path]) == [again, path], "made again under the same id"
