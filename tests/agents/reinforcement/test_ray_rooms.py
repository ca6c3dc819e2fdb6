"""Rooms on a real Ray cluster: they play what they would play here, also when a node is lost."""

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torchrl")

from movingout.agents.reinforcement.learning_room import RoomPairing
from movingout.agents.reinforcement.mappo import Mappo, learn_mappo
from movingout.agents.reinforcement.mappo_config import MappoConfig
from movingout.agents.reinforcement.ray_rooms import RayRooms
from movingout.recordings.ray_cluster import NoCluster
from movingout.server.cli import main
from tests.agents.reinforcement.test_mappo import TINY, equal, mappo, weights

pytestmark = pytest.mark.filterwarnings("ignore")  # Ray's own
CONFIG = MappoConfig(envs=3, evaluate_every=1, threads=1, **TINY)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    ray: Any = importlib.import_module("ray")
    from ray.cluster_utils import Cluster

    cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    cluster.add_node(num_cpus=1)
    ray.init(address=cluster.address, logging_level="ERROR", log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


def test_without_a_cluster_there_is_a_sentence() -> None:
    with pytest.raises(NoCluster, match="start one with: ray start --head"):
        Mappo(CONFIG, CONFIG.spec("mappo"), ("HandOff",), ray="127.0.0.1:9")


@pytest.mark.slow
def test_a_cluster_gives_the_same_weights_also_after_an_interruption(cluster: Any, tmp_path: Path) -> None:
    here, there = mappo(CONFIG), mappo(CONFIG, ray=cluster.address)
    for one, name in ((here, "here"), (there, "there")):
        learn_mappo(one, tmp_path / name, lambda _: None)
    assert equal(weights(here), weights(there))
    begun, continued = (mappo(CONFIG, ray=cluster.address) for _ in range(2))
    begun.learn()
    begun.save(tmp_path / "begun.safetensors")
    begun.rooms.close()
    continued.resume(tmp_path / "begun.safetensors")
    continued.learn()
    continued.rooms.close()
    assert equal(weights(continued), weights(here))


@pytest.mark.slow
def test_frozen_partners_play_there_and_a_lost_worker_is_replaced(cluster: Any) -> None:
    frozen = (mappo(CONFIG).actor.requires_grad_(False),)
    pairings = [RoomPairing("partner", -0.5, 0), RoomPairing("mixed", 0.5, 0), RoomPairing()]
    here, there = (mappo(CONFIG, pairings, frozen=frozen, ray=ray) for ray in ("", cluster.address))
    for round_number in range(3):
        here.learn()
        there.learn()
        if round_number == 0:
            assert isinstance(there.rooms, RayRooms) and len(there.rooms._workers) == 2
            importlib.import_module("ray").kill(there.rooms._workers[0])
    there.rooms.close()
    assert equal(weights(here), weights(there))


@pytest.mark.slow
def test_the_command_plays_on_a_cluster(cluster: Any, tmp_path: Path) -> None:
    words = [f"--{name.replace('_', '-')}={value}" for name, value in {**TINY, "envs": 3, "threads": 1}.items()]
    train = ["train", "mappo", "--map", "HandOff", *words, "--data", str(tmp_path)]
    assert main([*train, "--id", "mappo@there", "--ray", cluster.address]) == 0
    assert main([*train, "--id", "mappo@here"]) == 0
    there, here = (tmp_path / "models" / name / "policy.onnx" for name in ("mappo-there", "mappo-here"))
    assert there.read_bytes() == here.read_bytes()
