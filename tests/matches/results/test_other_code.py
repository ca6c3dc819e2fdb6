"""Results of other code of the project are kept, and told apart."""

import json
from pathlib import Path

import pytest

from movingout.matches import open_run, run_grid
from movingout.matches.report.comparison import markdown_report
from movingout.matches.report.html_page import page
from movingout.matches.results import other_code
from movingout.matches.results.other_code import MIXED
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


@pytest.mark.parametrize("before", [True, False])
def test_the_same_code_and_a_folder_of_before_pass_silently(
    before: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command = _begun(tmp_path)
    if before:
        results = tmp_path / "out" / "results-0-of-1.jsonl"
        document = json.loads(results.read_text())
        del document["code"]
        results.write_text(json.dumps(document) + "\n")
        monkeypatch.setattr(other_code, "code_sha256", lambda: "other")
    assert main(command) == 0
    assert "code" not in capsys.readouterr().err
    assert MIXED not in (tmp_path / "out" / "results.md").read_text()
