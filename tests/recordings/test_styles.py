"""People are grouped by their style of play: from a list, or by the populations of scripted people."""

from pathlib import Path

import pytest

from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import grouped_by_style, read_groups
from movingout.recordings.styles import read_styles, styles_of
from movingout.server.cli import main
from tests.agents.learning import recorded

PAIRS = ("A01", "A02"), ("B01", "B02"), ("B03", "A03"), ("A04", "A01")


def _episodes(folder: Path) -> list[Path]:
    return [recorded(folder, f"{one}{two}", ticks=9, people=(one, two)) for one, two in PAIRS]


def test_scripted_people_have_the_style_of_their_population_and_mixed_pairs_are_left_out(tmp_path: Path) -> None:
    rows, names = grouped_by_style(_episodes(tmp_path), {})
    assert names == ["A", "B"]
    assert [(row.people, row.group) for row in rows] == [(PAIRS[0], 1), (PAIRS[1], 2), (PAIRS[3], 1)]


def test_a_list_says_it_of_others(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _episodes(tmp_path / "episodes")
    file, out = tmp_path / "styles.csv", tmp_path / "groups.csv"
    lines = [f"{name},{'leads' if name[1:] == '01' else 'follows'}" for name in sorted({*sum(PAIRS, ())})]
    file.write_text("participant,style\n" + "\n".join(lines), encoding="utf-8")
    command = ["recordings", "split", str(tmp_path / "episodes"), "-o", str(out), "--styles", str(file)]
    assert main([*command, "--by", "style"]) == 2
    assert "groups by style need episodes of two styles or more; these recordings have follows" in (
        capsys.readouterr().err
    )
    file.write_text(file.read_text(encoding="utf-8").replace("A02,follows", "A02,leads"), encoding="utf-8")
    assert main([*command, "--by", "style"]) == 0
    shown = capsys.readouterr().out
    assert "2 recordings in" in shown and "; 2 left out" in shown
    assert "group 1, follows: 1 episode of 2 participants" in shown and "group 2, leads: 1 episode of" in shown
    assert {(row.people, row.group) for row in read_groups(out)} == {(PAIRS[0], 2), (PAIRS[2], 1)}
    assert main(command) == 2
    assert "counts with --by style alone" in capsys.readouterr().err


def test_people_without_a_style_are_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"2 of 3 participants have no style \(Ada, Bo\); --styles FILE\.csv says"):
        styles_of(["A01", "Ada", "Bo", "Ada"], {})
    with pytest.raises(RecordingError, match="1 of 2 participants have no style"):
        styles_of(["A01", "Ada"], {"Ada": "leads"})
    with pytest.raises(RecordingError, match="no recording names its participants"):
        styles_of([], {})


def test_a_list_that_a_german_spreadsheet_saved_is_read(tmp_path: Path) -> None:
    file = tmp_path / "styles.csv"
    file.write_text("participant;style\r\nP1;leads\r\nP2;follows\r\n;\r\n", encoding="utf-8-sig")
    assert read_styles(file) == {"P1": "leads", "P2": "follows"}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("participant,style\nP1,\n", "line 2: both participant and style are needed"),
        ("participant,style\nP1,a\nP1,b\n", "line 3: P1 has style 'a' in an earlier line"),
        ("participant,style\n", "names nobody; its lines are participant,style"),
        ("name;style\nP1;a\n", "has no column participant; its first line names the columns participant, style, with"),
    ],
)
def test_a_list_that_is_none_is_refused(text: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "styles.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=sentence):
        read_styles(file)
    file.write_bytes(b"participant,style\n\xff,a\n")
    with pytest.raises(RecordingError, match="is not UTF-8 text"):
        read_styles(file)
    with pytest.raises(RecordingError, match="cannot read"):
        read_styles(tmp_path / "none.csv")
