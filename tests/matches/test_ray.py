"""A real Ray cluster of two nodes on this machine."""

import importlib
import json
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bench import anywhere
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, model_roots
from movingout.agents.data import calls
from movingout.matches import MatchError, run_grid
from movingout.matches.execution.ray_workers import ray_worker_pool
from movingout.recordings.verification import verify
from movingout.server.cli import main
from tests.matches.support import HERE, small_grid

pytestmark = pytest.mark.filterwarnings("ignore")  # Ray's own


class Raising:
    """A learner whose code has a fault."""

    def reset(self, episode: EpisodeInfo) -> None:
        """Remember nothing."""

    def act(self, observation: Observation) -> ActionChunk:
        raise RuntimeError("no way home")


@pytest.fixture
def cluster() -> Iterator[Any]:
    ray: Any = importlib.import_module("ray")
    from ray.cluster_utils import Cluster

    cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    ray.init(address=cluster.address, logging_level="ERROR", log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.mark.slow
def test_a_node_killed_on_the_way_changes_no_number(cluster: Any, tmp_path: Path) -> None:
    node = cluster.add_node(num_cpus=1)
    grid = small_grid(agents=[f"{HERE}:Slow"], partners=["idle"], seeds=24, ticks=40)
    pool = ray_worker_pool(cluster.address)
    killed = threading.Event()

    def progress(finished: int, count: int) -> None:
        if 0 < finished < count and not killed.is_set():
            killed.set()
            cluster.remove_node(node, allow_graceful=False)

    there = run_grid(grid, tmp_path / "ray", workers=2, pool=pool, progress=progress)
    assert killed.is_set(), "the node was to be killed in the middle"
    assert there.failures == []
    here = run_grid(grid, tmp_path / "here", workers=2)
    assert there.results == here.results
    assert len(there.results) == 48


@pytest.mark.slow
def test_recordings_are_verified_on_a_cluster_as_they_are_here(
    cluster: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_grid(small_grid(agents=["idle"], partners=["idle"], seeds=3, ticks=20), tmp_path, workers=1, record=True)
    folder = tmp_path / "recordings"
    (folder / "broken.mcap").write_bytes(b"nothing")
    assert main(["recordings", "verify", str(folder)]) == 2
    here = capsys.readouterr().out
    assert main(["recordings", "verify", str(folder), "--ray", cluster.address]) == 2
    assert capsys.readouterr().out == here
    assert here.count("identical   ") >= 3 and "UNREADABLE" in here


@pytest.mark.slow
def test_recordings_are_exported_on_a_cluster_as_they_are_here(
    cluster: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_grid(small_grid(agents=["idle"], partners=["idle"], seeds=3, ticks=20), tmp_path, workers=1, record=True)
    folder = tmp_path / "recordings"

    def exported(name: str, to: str, *options: str) -> dict[str, bytes]:
        command = ["recordings", "export", str(folder), "--to", to, "--out", str(tmp_path / f"{to}-{name}")]
        assert main([*command, "--test-share", "0.3", "--split-by", "episode", *options]) == 0
        files = sorted((tmp_path / f"{to}-{name}").rglob("*.*"))
        return {str(path.relative_to(tmp_path / f"{to}-{name}")): path.read_bytes() for path in files}

    for to in ("parquet", "csv", "lerobot", "official"):
        assert exported("ray", to, "--ray", cluster.address) == exported("here", to)
    (folder / "broken.mcap").write_bytes(b"nothing")
    command = ["recordings", "export", str(folder), "--out", str(tmp_path / "none"), "--ray", cluster.address]
    assert main([*command, "--to", "csv"]) == 2
    assert "broken.mcap" in capsys.readouterr().err
    assert main([*command, "--to", "gif"]) == 2
    assert "leave --ray out" in capsys.readouterr().err


@pytest.mark.slow
def test_demonstrations_are_made_on_a_cluster_as_they_are_here(
    cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    def made(action: str, out: str, *options: str) -> dict[str, Any]:
        assert main(["demos", action, "--out", out, "--json", *options]) == 0
        return {**json.loads(capsys.readouterr().out), "out": ""}

    few = ["--map", "HandOff", "--episodes", "2", "--ticks", "20"]
    for action, options in {
        "generate": ["--people", "2"],
        "label": ["--learner", "idle"],
        "prove": ["--count", "1"],
    }.items():
        options += few if action != "prove" else []
        there = made(action, f"{action}-ray", *options, "--ray", cluster.address)
        assert there == made(action, f"{action}-here", *options, "--workers", "1")
    assert Path("prove-ray").read_bytes() == Path("prove-here").read_bytes()
    files = [sorted(file.name for file in Path(f"label-{where}").iterdir()) for where in ("ray", "here")]
    assert files[0] == files[1] and len(files[0]) == 2
    assert all(verify(file).identical for file in Path("generate-ray").glob("*.mcap"))
    fault = ["--learner", f"{__name__}:Raising", *few, "--ray", cluster.address]
    assert main(["demos", "label", "--out", "none", *fault]) == 2
    assert "RuntimeError: no way home; finished episodes are kept" in capsys.readouterr().err


@pytest.mark.slow
def test_benches_play_on_a_cluster_as_they_do_here(cluster: Any, capsys: pytest.CaptureFixture[str]) -> None:
    few = ["--agents", f"{HERE}:Wanderer", "idle", "--partners", "greedy", "--runs", "3", "--ticks", "20", "--json"]
    few += ["--groups", "12 maps"]
    anywhere.main([*few, "--ray", cluster.address])
    there = capsys.readouterr().out
    anywhere.main([*few, "--workers", "1"])
    assert capsys.readouterr().out == there


def test_a_call_on_a_cluster_finds_the_modules_and_the_models_of_who_sent_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(MODELS_VARIABLE, "")
    monkeypatch.setattr(sys, "path", [*sys.path])
    assert calls._there([str(tmp_path)], "/models", model_roots)[0] == Path("/models")
    assert sys.path[-1] == str(tmp_path)


def test_demonstrations_on_a_cluster_that_is_not_there_are_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("ray", reason="the extra `cluster` is not installed")
    for action in ("generate", "label", "prove"):
        assert main(["demos", action, "--out", str(tmp_path / action), "--ray", "127.0.0.1:1"]) == 2
        assert "no Ray cluster answers at '127.0.0.1:1'" in capsys.readouterr().err


def test_verifying_on_a_cluster_that_is_not_there_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("ray", reason="the extra `cluster` is not installed")
    (tmp_path / "broken.mcap").write_bytes(b"nothing")
    assert main(["recordings", "verify", str(tmp_path), "--ray", "127.0.0.1:1"]) == 2
    assert "no Ray cluster answers at '127.0.0.1:1'" in capsys.readouterr().err


def test_a_cluster_that_is_not_there_is_said_in_a_sentence() -> None:
    pytest.importorskip("ray", reason="the extra `cluster` is not installed")
    with pytest.raises(MatchError, match=r"no Ray cluster answers at '127\.0\.0\.1:1'"):
        ray_worker_pool("127.0.0.1:1")
