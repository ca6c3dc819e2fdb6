"""Grids that are played into folders: stopped, shared, of other code, and as warned about."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from movingout.maps import load_map, map_to_json
from movingout.matches import MatchError, MatchResult, open_run, play, read_grid, run_grid
from movingout.matches.execution.local_workers import LocalWorkerPool
from movingout.matches.experiment.plan import planned_matches
from movingout.matches.experiment.shipped_grids import grid_path
from movingout.matches.match import Match, failed_result
from movingout.matches.results.provenance import Provenance
from movingout.matches.results.results_folder import Shard, open_folder
from movingout.server.cli import main
from tests.matches.support import HERE, small_grid

pytestmark = pytest.mark.slow

GRID = f"""
name: small
agents: ["{HERE}:Wanderer", idle]
maps: [DistancePriority, FourCorners]
seeds: 10
ticks: 60
"""


def _numbers(results: dict[Match, MatchResult]) -> list[MatchResult]:
    return sorted(results.values(), key=lambda result: result.match.id)


def test_the_numbers_are_the_same_whatever_the_number_of_workers(tmp_path: Path) -> None:
    one = run_grid(small_grid(), tmp_path / "one", workers=1)
    three = run_grid(small_grid(), tmp_path / "three", workers=3)
    assert _numbers(one.results) == _numbers(three.results)
    assert len({result.metrics.nfd for result in one.results.values()}) > 3
    assert (tmp_path / "one/results.md").read_text() == (tmp_path / "three/results.md").read_text()


def test_a_dictionary_is_no_grid(tmp_path: Path) -> None:
    """It ended in a TypeError of pathlib."""
    with pytest.raises(MatchError, match="a grid is a Grid, the path of a YAML file or a shipped grid's name, not "):
        run_grid({"name": "x"}, tmp_path)  # type: ignore[arg-type]


def test_shipped_grids_have_their_names_also_in_python(tmp_path: Path) -> None:
    """As for the command; such a name was taken for a file that is not there."""
    assert read_grid("idle-control") == read_grid(grid_path(Path("idle-control")))
    with pytest.raises(MatchError, match=r"there is no grid 'idle-contrl'; did you mean idle-control.*or a YAML file"):
        run_grid("idle-contrl", tmp_path)


def test_a_folder_of_results_named_as_a_shipped_grid_is_not_taken_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shipped = read_grid("idle-control")
    monkeypatch.chdir(tmp_path)
    for name in ("idle-control", "nothing"):
        Path(name).mkdir()
    assert read_grid("idle-control") == shipped
    with pytest.raises(MatchError, match="there is no grid 'nothing'"):
        read_grid("nothing")


def test_shards_add_up_to_the_whole(tmp_path: Path) -> None:
    whole = run_grid(small_grid(), tmp_path / "whole", workers=1)
    first = run_grid(small_grid(), tmp_path / "parts", workers=1, shard=(0, 2))
    assert first.missing == len(whole.results) // 2
    both = run_grid(small_grid(), tmp_path / "parts", workers=1, shard=(1, 2))
    assert both.missing == 0
    assert _numbers(both.results) == _numbers(whole.results)


def test_a_killed_run_goes_on_and_plays_nothing_twice(tmp_path: Path) -> None:
    grid, folder = tmp_path / "grid.yaml", tmp_path / "out"
    grid.write_text(GRID.replace("ticks: 60", "ticks: 240"))  # long enough for the kill to come in time
    command = [
        sys.executable,
        "-m",
        "movingout.server.cli",
        "match",
        "grid",
        str(grid),
        "--out",
        str(folder),
        "--workers",
        "1",
    ]
    driver = subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True)
    shard = folder / "results-0-of-1.jsonl"
    while not (shard.exists() and shard.stat().st_size) and driver.poll() is None:
        time.sleep(0.02)
    os.killpg(driver.pid, signal.SIGKILL)
    driver.wait()
    with shard.open("ab") as file:
        file.write(b'{"torn": ')
    before = shard.read_bytes().split(b"\n")[:-1]
    assert 0 < len(before) < 80
    finished = run_grid(grid, folder, workers=1)
    lines = shard.read_bytes().split(b"\n")
    assert lines[: len(before)] == before
    assert len(lines) - 1 == len(finished.results) == 80
    assert _numbers(finished.results) == _numbers(run_grid(grid, tmp_path / "other", workers=2).results)


def test_a_finished_grid_is_read_not_played(tmp_path: Path) -> None:
    first = run_grid(small_grid(), tmp_path, workers=1)

    def nobody(size: int, limit_s: float, record: Path | None) -> LocalWorkerPool:
        raise AssertionError("nothing is left to play")

    assert _numbers(run_grid(small_grid(), tmp_path, pool=nobody).results) == _numbers(first.results)
    assert _numbers(open_run(tmp_path).results) == _numbers(first.results)


def test_a_folder_of_an_earlier_version_keeps_its_order_of_partners(tmp_path: Path) -> None:
    """Members of an even group kept to one seat then; what was played stays part of its grid."""
    (tmp_path / "two.txt").write_text("greedy:order=near\ngreedy:order=far\n", encoding="utf-8")
    group = f"@{tmp_path / 'two.txt'}"
    grid = small_grid(agents=["scripted"], partners=[group], seeds=4, maps=["HandOff"], ticks=3)
    folder = tmp_path / "results"
    run_grid(grid, folder, workers=1)
    head = json.loads((folder / "grid.json").read_text(encoding="utf-8"))
    (folder / "grid.json").write_text(json.dumps({name: value for name, value in head.items() if name != "order"}))
    early = planned_matches(grid, 1)
    assert open_run(folder).plan == early != planned_matches(grid)
    assert len(run_grid(grid, folder, workers=1).results) == len(early)
    (folder / "grid.json").write_text(json.dumps(head))
    assert open_run(folder).plan == planned_matches(grid)


def test_a_grid_plays_again_what_failed_and_keeps_the_rest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    grid = tmp_path / "grid.yaml"
    grid.write_text("name: two\nagents: [idle]\nmaps: [HandOff]\nseeds: 2\nticks: 3\n")
    folder = tmp_path / "out"
    first = run_grid(grid, folder, workers=1)
    good, lost = first.results.values()
    (folder / "results-0-of-1.jsonl").unlink()
    with Shard(folder, 1, 2) as shard:  # whose file is read after the one of the next run
        shard.append([failed_result(lost.match, "lost its worker process 3 times")])
    with Shard(folder) as shard:
        shard.append([good])
    command = ["match", "grid", str(grid), "--out", str(folder), "--workers", "1"]
    assert main([*command, "--dry-run"]) == 0
    assert "2 matches, 1 finished, 1 to play" in capsys.readouterr().out
    assert main(command) == 0
    assert "1 match failed before: played again" in capsys.readouterr().err
    assert _numbers(open_run(folder).results) == _numbers(first.results)
    assert (folder / "results-0-of-1.jsonl").read_bytes().count(b"\n") == 2, "what went well is not played again"
    assert main(command) == 0
    assert "failed" not in capsys.readouterr().err


def test_an_agent_that_takes_its_process_along_loses_only_its_matches(tmp_path: Path) -> None:
    grid = small_grid(agents=[f"{HERE}:Crashing"], partners=["idle"], maps=["HandOff"], seeds=2)
    run = run_grid(grid, tmp_path, workers=2)
    endings = {result.match.seed: result.ending for result in run.results.values()}
    assert endings == {0: "time", 1: "failed"}
    assert {result.failure for result in run.failures} == {
        "lost its worker process 3 times: the process was killed (SIGKILL: usually the machine was out of memory)"
    }
    assert [(row.failed, len(row.results)) for row in run.rows] == [(1, 2)]


def test_a_worker_that_hangs_where_no_alarm_reaches_is_replaced(tmp_path: Path) -> None:
    grid = small_grid(agents=[f"{HERE}:Deaf"], partners=["idle"], maps=["HandOff"], seeds=1, agent_limit_s=1.0)

    def impatient(size: int, limit_s: float, record: Path | None) -> LocalWorkerPool:
        return LocalWorkerPool(size, limit_s, record, grace_s=4.0)

    (failure,) = run_grid(grid, tmp_path, workers=1, pool=impatient).failures
    assert "gave no sign of life" in failure.failure


def test_a_map_without_a_variant_for_a_seed_stops_a_grid_before_it_is_played(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its matches counted as TCR 0 of the agents."""
    pit = map_to_json(load_map("Simple")) | {"name": "Pit", "goals": [{"x0": 0.0, "y0": 0.05, "x1": 0.05, "y1": 0.0}]}
    (tmp_path / "pit.json").write_text(json.dumps(pit))
    grid = tmp_path / "grid.yaml"
    grid.write_text(f"name: pit\nagents: [idle]\nmaps: [{tmp_path / 'pit.json'}]\nchallenge: 2\nseeds: 1\nticks: 2\n")
    command = ["match", "grid", str(grid), "--out", str(tmp_path / "out"), "--workers", "1"]
    for more in ([], ["--dry-run"]):
        assert main([*command, *more]) == 2
        assert "no playable evaluation variant of Pit for seed 0" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_folder_of_another_grid_is_refused(tmp_path: Path) -> None:
    open_folder(tmp_path, small_grid(), Provenance({}, {}, {}))
    with pytest.raises(MatchError, match=r"holds results of another grid \('small'\); choose another folder"):
        run_grid(small_grid(seeds=4), tmp_path)


def test_results_by_another_engine_are_not_added_to(tmp_path: Path) -> None:
    open_folder(tmp_path, small_grid(), Provenance({}, {}, {}))
    head = tmp_path / "grid.json"
    head.write_text(head.read_text().replace('"pymunk": "', '"pymunk": "0.'))
    with pytest.raises(MatchError, match="was started with pymunk 0"):
        run_grid(small_grid(), tmp_path)


def test_results_of_other_weights_are_not_added_to(tmp_path: Path) -> None:
    open_folder(tmp_path, small_grid(), Provenance({"dp@all": "1"}, {}, {}))
    with pytest.raises(MatchError, match="started with other weights of dp@all"):
        open_folder(tmp_path, small_grid(), Provenance({"dp@all": "2"}, {}, {}))


def test_two_drivers_do_not_fill_one_shard(tmp_path: Path) -> None:
    with Shard(tmp_path), pytest.raises(MatchError, match="another process is writing"):
        Shard(tmp_path)


def test_a_full_disk_is_said_and_keeps_what_is_finished(tmp_path: Path) -> None:
    results = play("idle", "idle", ticks=1, episodes=2, workers=1)
    with Shard(tmp_path) as shard:
        shard.append(results[:1])
        size = shard.path.stat().st_size
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size + 10, hard))
        try:
            with pytest.raises(MatchError, match="finished matches are kept; run the same command again to continue"):
                shard.append(results[1:])
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
            signal.signal(signal.SIGXFSZ, before)
        assert shard.path.stat().st_size == size
        shard.append(results[1:])
    assert shard.path.read_bytes().count(b"\n") == 2


def test_an_agent_that_is_missing_is_said_before_anything_is_played(tmp_path: Path) -> None:
    grid = small_grid(agents=[{"agent": "dp@nowhere", "needs": "train it"}, "idle"])
    with pytest.raises(MatchError, match=r"needs agents that are not here: dp@nowhere: .*\(to get it: train it\)"):
        run_grid(grid, tmp_path / "out")
    assert not (tmp_path / "out").exists()
