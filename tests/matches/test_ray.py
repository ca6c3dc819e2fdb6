"""A real Ray cluster of two nodes on this machine."""

import importlib
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from movingout.matches import MatchError, run_grid
from movingout.matches.execution.ray_workers import ray_worker_pool
from movingout.server.cli import main
from tests.matches.support import HERE, small_grid

pytestmark = pytest.mark.filterwarnings("ignore")  # Ray's own


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
