"""Results of other code of the project are kept, and told apart."""

import json
from pathlib import Path

import pytest

from movingout.matches import open_run, run_grid
from movingout.matches.report.comparison import markdown_report
from movingout.matches.report.html_page import page
from movingout.matches.results import other_code
from movingout.matches.results.other_code import MIXED
from movingout.matches.results.table import EARLIER, markdown
from movingout.recordings.report.words import LANGUAGES
from movingout.server.cli import main


def _begun(folder: Path) -> list[str]:
    """A grid of two matches of which one is there; the command that goes on."""
    grid = folder / "grid.yaml"
    grid.write_text("name: two\nagents: [idle]\nmaps: [HandOff]\nseeds: 2\nticks: 3\n")
    run_grid(grid, folder / "out", workers=1)
    results = folder / "out" / "results-0-of-1.jsonl"
    results.write_text(results.read_text().splitlines(keepends=True)[0])
    return ["match", "grid", str(grid), "--out", str(folder / "out"), "--workers", "1"]


def test_a_grid_that_goes_on_with_other_code_says_so_before_and_in_its_reports(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command = _begun(tmp_path)
    monkeypatch.setattr(other_code, "code_sha256", lambda: "other")
    for more in (["--dry-run"], ["--json"]):
        capsys.readouterr()
        assert main([*command, *more]) == 0
        said = capsys.readouterr()
        assert "1 match here was played with other code of this project" in said.err
    document = json.loads(said.out)
    assert document["mixed_code"] and MIXED in document["notes"]
    assert MIXED in (tmp_path / "out" / "results.md").read_text()
    run = open_run(tmp_path / "out")
    assert MIXED in markdown_report([run]) and MIXED in page(run)
    assert {"grid.mixed-code" in page(run, language) for language in LANGUAGES} == {False}
    assert main(command) == 0
    errors = capsys.readouterr().err
    assert "here was played with other code" not in errors and MIXED in errors


def _forget(path: Path, *names: str) -> None:
    """Leave out of every line of results what earlier versions did not write."""
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    kept = [{name: value for name, value in line.items() if name not in names} for line in lines]
    path.write_text("".join(json.dumps(line) + "\n" for line in kept))


def test_results_that_name_no_code_are_of_other_code_than_those_that_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = _begun(tmp_path)
    _forget(tmp_path / "out" / "results-0-of-1.jsonl", "code")
    assert not open_run(tmp_path / "out").mixed_code, "all alike"
    assert main(command) == 0
    errors = capsys.readouterr().err
    assert "1 match here was played with other code of this project" in errors and MIXED in errors
    assert open_run(tmp_path / "out").mixed_code


@pytest.mark.parametrize("lacks", [(), ("code", "play_hash", "official_ac")])
def test_tables_say_that_results_of_before_lack_something(tmp_path: Path, lacks: tuple[str, ...]) -> None:
    _begun(tmp_path)
    _forget(tmp_path / "out" / "results-0-of-1.jsonl", *lacks)
    run = open_run(tmp_path / "out")
    assert [EARLIER in text for text in (markdown(run.rows), markdown_report([run]), page(run))] == [bool(lacks)] * 3


def test_the_same_code_passes_silently(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = _begun(tmp_path)
    assert main(command) == 0
    assert "code" not in capsys.readouterr().err
    assert MIXED not in (tmp_path / "out" / "results.md").read_text()
