"""From episodes to a BASS agent: training its simulator, exporting it, playing with it."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.action_chunk import checked_chunk
from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.agent import BassAgent, spread
from movingout.agents.bass.checkpoint_parts import export_dynamics
from movingout.agents.bass.config import BassConfig, Order
from movingout.agents.bass.dynamics import Rollout, build_dynamics, carried, holding
from movingout.agents.bass.dynamics_training import train_dynamics, transitions_of
from movingout.agents.bass.engine_agent import engine_simulator
from movingout.agents.bass.state_vector import ITEMS_START, moving, moving_arrays
from movingout.agents.checkpoint.card import DynamicsKind, DynamicsSpec, SelectionSpec
from movingout.agents.checkpoint.checkpoint import find_checkpoint
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import DataError
from movingout.agents.inference.network import Network, PolicyNetwork, Singles
from movingout.agents.kinds.policy import build_policy
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.policies.export import export_policy, halved_weights
from movingout.agents.scripted import ScriptedAgent
from movingout.maps import load_map
from movingout.server.cli import main
from movingout.world import World
from tests.agents.learning import random_walk, recorded, tiny_spec, walked
from tests.agents.trained import load_checkpoint

TINY = ["--updates", "4", "--batch", "32", "--width", "16"]


@pytest.mark.parametrize(("kind", "ruled"), [("vae", False), ("gru", False), ("qvae", False), ("vae", True)])
def test_an_exported_simulator_gives_the_numbers_of_the_trained_one(kind: str, ruled: bool) -> None:
    torch.manual_seed(0)
    spec = DynamicsSpec(kind=kind, width=16, latent=8, rigid=ruled, grasping=ruled)  # type: ignore[arg-type]
    dynamics = build_dynamics(spec).eval()
    dynamics.load_state_dict(halved_weights(dynamics))  # as they are stored
    random = np.random.default_rng(0)
    inputs = {
        "state": random.standard_normal((5, 58), dtype=np.float32),
        "constant": random.standard_normal((5, 146), dtype=np.float32),
        "actions": random.random((5, 3, 2, 4), dtype=np.float32).round(),
    }
    (served,) = Network(export_dynamics(dynamics, 3, "hold"))(**inputs)
    with torch.inference_mode():
        expected = Rollout(dynamics, 3, "hold")(*(torch.from_numpy(value) for value in inputs.values())).numpy()
    assert served.shape == (5, 3, 58) and np.allclose(served, expected, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["vae", "gru", "qvae"])
def test_the_simulator_learns_to_be_better_than_saying_that_nothing_moves(kind: DynamicsKind, tmp_path: Path) -> None:
    trajectories = [walked("DistancePriority", ticks=60, seed=seed) for seed in range(11)]
    data = transitions_of(trajectories)
    config = BassConfig(dynamics=kind, width=64, latent=16, updates=400, batch=128, rate=3e-3, warmup=20, ema=0.98)
    dynamics = train_dynamics(config, data, tmp_path).network
    rows = np.flatnonzero(data.episodes == 9)  # never trained on
    with torch.inference_mode():
        arrays = data.before[rows], data.constants[data.maps[rows]], data.actions[rows]
        predicted = dynamics.step(*(torch.from_numpy(array) for array in arrays)).numpy()
    places = [0, 1, 7, 8]
    learned = np.abs(predicted - data.after[rows])[:, places].mean()
    nothing = np.abs(data.before[rows] - data.after[rows])[:, places].mean()
    assert learned < 0.8 * nothing


@pytest.mark.slow
@pytest.mark.parametrize(("order", "residual"), [("fine-tuned", False), ("separate", True)])
def test_a_simulator_fitted_part_by_part_learns_too(order: Order, residual: bool, tmp_path: Path) -> None:
    data = transitions_of([walked("DistancePriority", ticks=60, seed=seed) for seed in range(6)])
    config = BassConfig(
        width=64, latent=16, updates=600, batch=128, rate=3e-3, warmup=20, ema=0.98, order=order, residual=residual
    )
    untrained = build_dynamics(config.spec())
    dynamics = train_dynamics(config, data, tmp_path).network
    arrays = [torch.from_numpy(array) for array in (data.before, data.constants[data.maps], data.actions, data.after)]
    with torch.inference_mode():
        errors = [(one.step(*arrays[:3]) - arrays[3]).abs().mean() for one in (dynamics, untrained)]
    assert errors[0] < 0.5 * errors[1]
    assert (tmp_path / "step" / "resume.safetensors").exists()


def test_an_order_that_cannot_be_is_refused(tmp_path: Path) -> None:
    data = transitions_of([walked("DistancePriority", ticks=5)])
    for wrong in ({"order": "backwards"}, {"order": "separate", "dynamics": "gru"}, {"order": "fine-tuned"}):
        with pytest.raises(DataError, match="--order"):
            train_dynamics(BassConfig(width=16, latent=4, updates=1, **wrong), data, tmp_path)  # type: ignore[arg-type]


def test_the_engines_word_on_a_chunk_is_what_then_happens() -> None:
    world = World(load_map("DistancePriority"))
    for action in random_walk(15, seed=3):
        world.step(action)
    chunk = np.random.default_rng(1).uniform(-1, 1, (8, 2, 4))
    chunk[..., 3] = 0.0  # a desired level of 0: nobody holds, so nobody presses
    (predicted,) = engine_simulator(world.snapshot(), levels=True)(chunk[None])
    for row in chunk:
        world.step([[distance, np.arctan2(sin, cos), 0.0] for distance, cos, sin, _ in row])
    assert np.array_equal(predicted[-1], moving(world.state()))


def test_what_hands_hold_goes_where_the_engine_carries_it_and_nothing_else_moves() -> None:
    the_map = load_map("SingleRotation")  # one large item, carried by two
    steps = list(rollout(the_map, (ScriptedAgent(), ScriptedAgent(seed=1)), 0, 80))
    before, after = (np.array([moving(getattr(step, when)) for step in steps]) for when in ("before", "after"))
    robots_only = np.concatenate((after[:, :ITEMS_START], before[:, ITEMS_START:]), axis=1)
    found = carried(torch.from_numpy(before), torch.from_numpy(robots_only)).numpy()
    assert np.abs(before - after)[:, ITEMS_START:].max() > 0.03
    assert np.abs(found - after)[:, ITEMS_START:].max() < 0.01


def test_hands_are_read_from_the_state() -> None:
    trajectory = walked(ticks=2)
    held = np.array([[-1, 2], [0, -1], [3, 3]])
    rows = moving_arrays(trajectory.robot_poses, trajectory.robot_velocities, held, trajectory.item_poses)
    assert holding(torch.from_numpy(rows)).tolist() == [[0, 1], [1, 0], [1, 1]]


@pytest.mark.slow
def test_a_bass_agent_is_trained_on_top_of_a_policy_and_tells_what_it_weighed(tmp_path: Path) -> None:
    for number in range(2):
        recorded(tmp_path / "rec", f"e{number}", ticks=70, seed=number)
    common = [str(tmp_path / "rec"), "--data", str(tmp_path), *TINY]
    assert main(["train", "dp", *common, "--id", "dp@tiny", "--depth", "1"]) == 0
    bass = ["train", "bass", *common, "--id", "bass@tiny", "--base", "dp@tiny", "--latent", "4"]
    assert main([*bass, "--value-updates", "4", "--value-width", "16"]) == 0
    agent = load_checkpoint(find_checkpoint("bass@tiny", tmp_path / "models"))
    assert isinstance(agent, BassAgent)
    world = World(load_map("HandOff"))
    agent.reset(EpisodeInfo(world.map, 1, 5, 100))
    chunk = checked_chunk(agent.act(observe(world.map, world.state(), 1)))
    assert len(chunk) == 8
    assert agent.detail["chosen"] in range(8)
    assert np.array(agent.detail["scores"]).shape == (8,)
    assert np.array(agent.detail["items"]).shape == (8, len(world.map.items), 2)
    assert np.array(agent.detail["guesses"]).shape == (2, 8, 3)
    assert agent.detail["pairs"] == [[own, guess] for own in range(8) for guess in range(2)]
    assert np.array(agent.detail["robots"]).shape == (16, 2, 2, 2)
    assert len(json.dumps(agent.detail, separators=(",", ":"))) < 3500
    agent.reset(EpisodeInfo(world.map, 1, 5, 100))
    again = agent.act(observe(world.map, world.state(), 1))
    assert np.array_equal(chunk, again)


class _TheFirstItemIsCarriedByBlue(Network):
    """A simulator in which the first item goes where blue drives, whatever else happens."""

    def __init__(self) -> None: ...

    def __call__(self, **inputs: Singles) -> list[Singles]:
        states = np.repeat(inputs["state"][:, None], inputs["actions"].shape[1], axis=1)
        distance, cos, sin = np.moveaxis(inputs["actions"][:, :, 0, :3], -1, 0)
        states[..., ITEMS_START : ITEMS_START + 2] += 0.06 * np.cumsum(
            np.stack((-distance * sin, distance * cos), -1), 1
        )
        return [states]


def _chooser(kind: str, seed: int) -> BassAgent:
    """BASS on an untrained policy, in the seat of blue."""
    torch.manual_seed(0)
    spec = tiny_spec(kind=kind, obs_horizon=1)
    network = PolicyNetwork(spec, export_policy(build_policy(spec).eval()))
    agent = BassAgent(spec, network, _TheFirstItemIsCarriedByBlue(), SelectionSpec(own=4, partner=2))
    agent.reset(EpisodeInfo(load_map("DistancePriority"), 0, seed, 100))
    return agent


@pytest.mark.parametrize("kind", ["mlp", "gru"])
def test_of_a_policy_that_makes_no_noise_there_are_candidates_to_choose_among(kind: str) -> None:
    the_map = load_map("DistancePriority")
    agent = _chooser(kind, seed=3)
    chunk = agent.act(observe(the_map, start_state(the_map), 0))
    assert np.ptp(np.array(agent.detail["scores"])) > 0
    ways = np.array(agent.detail["candidates"])
    assert len(np.unique(ways, axis=0)) == 4
    (own,) = agent.network.sample(agent._stacked()[None], agent.random)
    assert np.allclose(ways[0], own[:, :3], atol=0.006)  # the policy's word is one of them
    assert np.allclose(np.hypot(ways[1:, :, 1], ways[1:, :, 2]), 1.0, atol=0.02)
    again, other = _chooser(kind, seed=3), _chooser(kind, seed=4)
    assert np.array_equal(chunk, again.act(observe(the_map, start_state(the_map), 0)))
    other.act(observe(the_map, start_state(the_map), 0))
    assert other.detail["scores"] != agent.detail["scores"]


def test_it_tells_where_the_simulator_sees_the_robots_halfway_and_in_the_end() -> None:
    the_map = load_map("DistancePriority")
    state = start_state(the_map)
    agent = _chooser("mlp", seed=3)
    agent.act(observe(the_map, state, 0))
    robots = np.array(agent.detail["robots"])  # of a simulator that moves none
    assert robots == pytest.approx(np.broadcast_to(state.robot_poses[:, :2], (8, 2, 2, 2)), abs=0.006)


def test_noise_from_outside_never_opens_a_hand() -> None:
    chunks = np.tile(np.array([0.5, 0.6, 0.8, -1.0, 1.0], dtype=np.float32), (3, 8, 1))
    noise = np.random.default_rng(0).standard_normal((3, 1, 8, 5), dtype=np.float32)
    moved = spread(chunks, noise)
    assert np.array_equal(moved[0], chunks[0]) and np.array_equal(moved[..., 3:], chunks[..., 3:])
    assert np.ptp(moved[1], axis=0).max() == 0 and not np.allclose(moved[1], moved[2])


@pytest.mark.slow
def test_a_simulator_serves_another_policy_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(tmp_path / "rec", "e0", ticks=20, seed=0)
    common = [str(tmp_path / "rec"), "--data", str(tmp_path), *TINY]
    for kind in ("dp", "gru"):
        assert main(["train", kind, *common, "--id", f"{kind}@tiny", "--horizon", "8", "--depth", "1"]) == 0
    by_distance = "--score", "nfd"
    bass = ["train", "bass", *common, "--id", "bass@tiny", "--base", "dp@tiny", "--latent", "4"]
    assert main(bass) == 2
    assert "use --score nfd" in capsys.readouterr().err  # too short to learn a value from
    assert main([*bass, *by_distance]) == 0
    other = ["train", "bass", "--data", str(tmp_path), "--id", "bass-gru@tiny", "--base", "gru@tiny", *by_distance]
    assert main([*other, "--simulator", "bass@tiny"]) == 0
    first, second = (find_checkpoint(name, tmp_path / "models") for name in ("bass@tiny", "bass-gru@tiny"))
    assert first.read("dynamics.onnx") == second.read("dynamics.onnx")
    assert second.read("policy.onnx") == find_checkpoint("gru@tiny", tmp_path / "models").read("policy.onnx")
    capsys.readouterr()
    assert main([*other, "--simulator", "dp@tiny"]) == 2
    assert "dp@tiny has no learned simulator" in capsys.readouterr().err
    assert main(other) == 2
    assert "name recordings to learn from" in capsys.readouterr().err
