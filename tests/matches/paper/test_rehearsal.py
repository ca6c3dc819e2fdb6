"""The whole way from people to a table, as docs/reproduction.md describes it, with simulated participants."""

import csv
import re
from pathlib import Path

import pytest

from movingout.matches.paper import cells, data_sets
from movingout.server.cli import main

TWO_MAPS = ("HandOff", "SingleRotation")
SHORT = (
    (r"maps: all$", f"maps: [{', '.join(TWO_MAPS)}]"),
    (r"rounds: 3$", "rounds: 1"),
    (r"limit_ticks: 500$", "limit_ticks: 20"),
    (r"practice: tutorial .*$", "practice: {map: Simple, limit_ticks: 5}"),
)
TINY = ["--updates", "2", "--batch", "16", "--width", "16", "--evaluate-every", "2"]


@pytest.mark.slow
def test_a_study_with_simulated_participants_becomes_a_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (cells, data_sets):
        monkeypatch.setattr(module, "map_names", lambda: TWO_MAPS)  # of the twelve
    monkeypatch.chdir(tmp_path)
    assert main(["study", "new", "--template", "collect", "-o", "rehearsal.yaml"]) == 0
    text = Path("rehearsal.yaml").read_text(encoding="utf-8")
    for old, new in SHORT:
        text, count = re.subn(old, new, text, flags=re.MULTILINE)
        assert count, old
    Path("rehearsal.yaml").write_text(text, encoding="utf-8")
    simulate = ["study", "simulate", "rehearsal.yaml", "--participants", "4", "--speed", "max", "--data", "played"]
    assert main(simulate) == 0
    recordings = "played/recordings"
    assert main(["recordings", "split", recordings, "--groups", "2", "-o", "groups.csv"]) == 0
    with Path("groups.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    people = [{row[seat] for row in rows if row["group"] == group for seat in ("blue", "red")} for group in "12"]
    assert len(people[0]) == len(people[1]) == 2 and not people[0] & people[1]
    assert main(["train", "dp", "--manifest", "groups.csv", "--group", "1", "--id", "dp@first", *TINY]) == 0
    capsys.readouterr()
    table = ["paper", "tables", "tab:cross_group_eval", "--data", recordings, "--budget", "smoke", "-o", "tables"]
    assert main(table) == 0
    shown = capsys.readouterr().out
    assert "Cross-Group: DP/BASS" in shown and "not measured" not in shown and "scripted people" not in shown
