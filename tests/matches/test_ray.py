"""A real Ray cluster of two nodes on this machine."""

import importlib
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from movingout.matches import MatchError, run_grid
from movingout.matches.execution.ray_workers import ray_worker_pool
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


def test_a_cluster_that_is_not_there_is_said_in_a_sentence() -> None:
    pytest.importorskip("ray", reason="the extra `cluster` is not installed")
    with pytest.raises(MatchError, match=r"no Ray cluster answers at '127\.0\.0\.1:1'"):
        ray_worker_pool("127.0.0.1:1")
