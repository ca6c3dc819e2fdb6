import itertools
import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from movingout.maps import load_map, map_to_json
from movingout.matches.commands import grid, match
from movingout.recordings import finalise, read_episode
from movingout.server.cli import main
from tests.matches import support
from tests.matches.support import HERE, written
from tests.recordings.support import record

GRID = f'name: tiny\nagents: ["{HERE}:Wanderer"]\npartners: [idle]\nmaps: [DistancePriority]\nseeds: 2\nticks: 30\n'


def test_the_readmes_match_gives_the_fixed_json_fields(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ["match", "--red", f"{HERE}:Wanderer", "--blue", "idle", "--map", "DistancePriority", "--ticks", "40"]
    assert main([*arguments, "--episodes", "2", "--record", str(tmp_path), "--json", "--workers", "1"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {"seed", "ticks", "results", "recordings"} <= document.keys()
    (row,) = document["results"]
    assert (row["map"], row["blue"], row["red"], row["episodes"]) == (
        "DistancePriority", "idle", f"{HERE}:Wanderer", 2,
    )  # fmt: skip
    assert {"full_deliveries", "mean_ticks", "tcr", "nfd", "wt", "ac"} <= row.keys()
    assert row["nfd"]["stderr"] is not None
    assert all(Path(path).is_file() for path in document["recordings"]) and len(document["recordings"]) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--red", "idle"], "name both agents"),
        (["--red", "idle", "--blue", "idel"], "unknown agent 'idel'; did you mean idle? known: scripted"),
        (["--red", "idle", "--blue", "idle", "--map", "HandOf"], "did you mean HandOff?"),
        (["--red", "idle", "--blue", "idle", "--episodes", "0"], "--episodes is a whole number from 1"),
        (["--red", "idle", "--blue", "idle", "--workers", "0"], "--workers must be at least 1"),
        (["--red", "idle", "--blue", "people:Z"], "unknown population 'Z'"),
        (["grid", "nothing.yaml"], "cannot read nothing.yaml"),
        (["grid", "ablations"], "no grid 'ablations'; did you mean ablation? known: ablation, challenge-1, "),
        (["grid", "challenge-2"], "needs agents that are not here: "),
        (["report", "nowhere"], "nowhere is not a results folder"),
    ],
)
def test_wrong_use_is_answered_in_a_sentence(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["match", *arguments]) == 2
    captured = capsys.readouterr()
    assert message in captured.err and captured.out == ""


def test_an_unset_variable_is_no_folder_for_recordings(capsys: pytest.CaptureFixture[str]) -> None:
    """They were written into the current folder."""
    with pytest.raises(SystemExit):
        main(["match", "--red", "idle", "--blue", "idle", "--record", ""])
    assert "--record: name a folder; the current one is ." in capsys.readouterr().err


def test_a_match_on_a_map_that_an_agent_never_saw_is_played_and_says_so_once_and_in_the_recording(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ["match", "--blue", "mlp@all", "--red", "idle", "--map", "Simple", "--episodes", "2", "--ticks", "5"]
    assert main([*arguments, "--workers", "1", "--record", str(tmp_path), "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err.count("mlp@all has never seen the map Simple: it was trained on 12 others.") == 1
    first, _ = json.loads(captured.out)["recordings"]
    told = [event for event in read_episode(Path(first)).events if event.kind == "unseen_map"]
    assert [(event.tick, event.seat) for event in told] == [(0, 0)]


@pytest.mark.slow
def test_a_match_on_a_mirrored_map_is_recorded_under_its_own_name_and_can_be_simulated_again(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ["match", "--blue", "idle", "--red", "idle", "--map", "HandOff:mirror", "--ticks", "5"]
    assert main([*arguments, "--workers", "1", "--record", str(tmp_path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["results"][0]["map"] == "HandOff:mirror"
    (path,) = document["recordings"]
    assert ":" not in Path(path).name, "some file systems have no such names"
    assert read_episode(Path(path)).header.map == load_map("HandOff:mirror")
    assert main(["recordings", "verify", path]) == 0


@pytest.mark.slow
def test_a_match_that_an_agent_could_not_play_is_told_in_a_sentence_and_by_the_exit_code(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    ghost = f"ghost:{finalise(record(tmp_path, ticks=5, map_name='HandOff')[0])}#red"
    arguments = ["match", "--blue", "idle", "--red", ghost, "--ticks", "10", "--workers", "1", "--json", "--map"]
    assert main([*arguments, "HandOff"]) == 0
    assert json.loads(capsys.readouterr().out)["failures"] == []
    assert main([*arguments, "HandOff,LeftRight"]) == 1
    captured = capsys.readouterr()
    (failure,) = json.loads(captured.out)["failures"]
    assert (failure["map"], failure["seat"]) == ("LeftRight", 1)
    assert captured.err.count("movingout: ") == 1
    assert "LeftRight, seed 0: failed: " in captured.err and "recorded on HandOff, not on LeftRight" in captured.err


def test_a_map_with_more_goals_than_an_agent_sees_is_told_in_a_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    drawn = map_to_json(load_map("Simple")) | {"name": "Five", "title": "Five", "goals": goals}
    path = tmp_path / "five.json"
    path.write_text(json.dumps(drawn), encoding="utf-8")
    pair = ["--blue", "idle", "--red", "bass@any", "--ticks", "10", "--workers", "1"]
    assert main(["match", *pair, "--map", str(path)]) == 2
    said = capsys.readouterr().err
    assert "the layout relative-v1 has 4 slots for goals; Five has 5" in said
    assert said.count("movingout: ") == 1 and "Traceback" not in said


def test_a_grid_goes_on_without_what_an_agent_has_lost(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    ghost = f"ghost:{finalise(record(tmp_path, ticks=5, map_name='HandOff')[0])}#red"
    grid = f'name: ghosts\nagents: [idle]\npartners: ["{ghost}"]\nmaps: [LeftRight, HandOff]\n'
    grid += "seats: blue\nseeds: 1\nticks: 9\n"
    out = tmp_path / "out"
    assert main(["match", "grid", str(written(tmp_path, grid)), "--out", str(out), "--workers", "1", "--json"]) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert (document["matches"], document["missing"], len(document["failures"])) == (2, 0, 1)
    assert "recorded on HandOff, not on LeftRight" in captured.err


def test_a_dry_run_counts_and_estimates_and_plays_nothing(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ["match", "grid", str(written(tmp_path, GRID)), "--out", str(tmp_path / "out"), "--dry-run", "--json"]
    assert main(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["matches"], document["to_play"], document["missing_agents"]) == (2, 2, [])
    assert document["estimated_s"] > 0.0
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("waits", "estimated"), [(True, 20.0), (False, 0.2)])
def test_a_dry_run_goes_by_the_clock_where_agents_wait(
    waits: bool, estimated: float, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A language model of 1.5 s per answer was estimated by the processor time of what reads its answers.

    On a busy machine a match of agents that do not wait takes as much longer than its processor time.
    """
    monkeypatch.setattr(support.Wanderer, "waits", waits, raising=False)
    spent, at = itertools.count(0.0, 0.1), itertools.count(0.0, 10.0)
    monkeypatch.setattr(grid, "time", SimpleNamespace(process_time=lambda: next(spent), monotonic=lambda: next(at)))
    arguments = ["match", "grid", str(written(tmp_path, GRID)), "--out", str(tmp_path / "out"), "--dry-run", "--json"]
    assert main([*arguments, "--workers", "1"]) == 0
    assert json.loads(capsys.readouterr().out)["estimated_s"] == pytest.approx(estimated)


def test_what_an_agent_prints_is_no_part_of_the_document_of_a_dry_run(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reset, act = "def reset(self, episode): print('hello')", "def act(self, seen): return [[0.0, 1.0, 0.0, 0.0]]"
    code = f"class Loud:\n    {reset}\n    {act}\n"
    (tmp_path / "loud_agent.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    grid = written(tmp_path, GRID.replace(f"{HERE}:Wanderer", "loud_agent:Loud"))
    assert main(["match", "grid", str(grid), "--out", str(tmp_path / "out"), "--dry-run", "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["to_play"] == 2 and "hello" in captured.err


def test_a_grid_leaves_tables_a_page_and_a_report(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    arguments = ["match", "grid", str(written(tmp_path, GRID)), "--out", str(out), "--html", "--record"]
    assert main([*arguments, "--workers", "1"]) == 0
    assert {path.name for path in out.iterdir()} >= {
        "grid.json", "results-0-of-1.jsonl", "results.json", "results.md", "results.html", "results.parquet",
        "recordings",
    }  # fmt: skip
    assert len(list((out / "recordings").glob("*.mcap"))) == 2
    capsys.readouterr()
    assert main(["match", "report", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["grids"][0]["missing"] == 0
    assert main(["match", "grid", "challenge-1", "--out", str(out), "--shard", "3/2"]) == 2
    assert "--shard is I/N" in capsys.readouterr().err


def test_an_agent_that_raises_is_told_file_and_line_without_a_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    agent = "tests.agents.support:Raising:first=2"
    arguments = ["--blue", agent, "--red", "idle", "--map", "HandOff", "--ticks", "5", "--workers", "1"]
    assert main(["match", *arguments]) == 1
    told = capsys.readouterr().err
    assert re.search(r"raised ValueError in act\(\) at tick \d: I do not know this place "
                     r"\(tests/agents/support.py, line \d+\)\n", told)  # fmt: skip
    assert "Traceback" not in told
    assert main(["agents", "check", agent, "--map", "HandOff", "--ticks", "5"]) == 1
    told = capsys.readouterr().out
    assert re.search(r"act raised ValueError: .* \(tests/agents/support.py, line \d+\)\n$", told)


@pytest.mark.slow
def test_copies_of_an_episode_are_counted_apart(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    common = ["--red", "idle", "--map", "DistancePriority", "--ticks", "12", "--episodes", "4", "--workers", "1"]
    assert main(["match", "--blue", "scripted", *common]) == 0
    table = capsys.readouterr().out
    assert "4 (1 distinct)" in table and "copies of others" in table
    assert main(["match", "--blue", f"{HERE}:Wanderer", *common, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["results"]
    assert (row["episodes"], row["distinct"]) == (4, 4)


def test_a_grid_shows_copies_in_its_table_and_on_its_page(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "grid.yaml"
    file.write_text(GRID.replace(f"{HERE}:Wanderer", "idle"), encoding="utf-8")
    assert main(["match", "grid", str(file), "--out", str(tmp_path / "out"), "--workers", "1", "--html"]) == 0
    assert "| 2 (1 distinct) |" in capsys.readouterr().out
    page = (tmp_path / "out" / "results.html").read_text(encoding="utf-8")
    assert "<td>2 (1 distinct)</td>" in page and "n = 2 (1 distinct)" in page and "copies of others" in page
    (row,) = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))["results"]
    assert row["distinct"] == 1


@pytest.mark.parametrize("grid", [False, True])
def test_a_map_file_that_cannot_be_played_is_told_of(
    grid: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = map_to_json(load_map("HandOff")) | {"name": "Tiny"}
    document["goals"] = [{"x0": -1.2, "y0": 1.2, "x1": -1.19, "y1": 1.19}]
    own = tmp_path / "tiny.json"
    own.write_text(json.dumps(document))
    if grid:
        file = tmp_path / "grid.yaml"
        file.write_text(GRID.replace("DistancePriority", str(own)).replace("ticks: 30", "ticks: 2"))
        main(["match", "grid", str(file), "--out", str(tmp_path / "out"), "--workers", "1"])
    else:
        main(["match", "--red", "idle", "--blue", "idle", "--map", str(own), "--ticks", "2"])
    assert f"movingout: {own} cannot be played as it should: items[" in capsys.readouterr().err


def test_a_dry_run_refuses_a_folder_of_another_grid(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, out = tmp_path / "grid.yaml", ["--out", str(tmp_path / "out")]
    file.write_text(GRID.replace("ticks: 30", "ticks: 2"))
    main(["match", "grid", str(file), *out, "--workers", "1"])
    file.write_text(GRID.replace("ticks: 30", "ticks: 3"))
    assert main(["match", "grid", str(file), *out, "--dry-run"]) == 2
    assert "holds results of another grid ('tiny')" in capsys.readouterr().err


def test_matches_that_are_interrupted_say_what_was_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    left: list[str] = []

    def interrupted(*_: object, record: Path | None, **__: object) -> None:
        for name in left if record else ():
            (tmp_path / name).touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(match, "play_matches", interrupted)
    command = ["match", "--blue", "idle", "--red", "idle", "--map", "HandOff"]
    (tmp_path / "earlier.mcap").touch()
    kept = f"; what was recorded until then is in {tmp_path}"
    recover = f"{kept}; finish it with: movingout recordings recover {tmp_path}"
    for names, said in (([], ""), (["one.mcap"], kept), (["two.mcap", "three.mcap.journal"], recover)):
        left[:] = names
        assert main(command) == main([*command, "--record", str(tmp_path)]) == 130
        lines = capsys.readouterr().err.splitlines()
        assert lines == ["movingout: stopped", f"movingout: stopped{said}"]


@pytest.mark.parametrize("played", [True, False])
def test_a_grid_that_is_interrupted_says_whether_anything_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, played: bool
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(grid, "run_grid", interrupted)
    if played:
        monkeypatch.setattr(grid, "read_results", lambda _: {"a match": "its result"})
    (tmp_path / "tiny.yaml").write_text(GRID)
    assert main(["match", "grid", str(tmp_path / "tiny.yaml"), "-o", str(tmp_path / "out")]) == 130
    kept = "; finished matches are kept" if played else " before a match was finished"
    assert capsys.readouterr().err.splitlines()[-1].startswith(f"movingout: stopped{kept}")
