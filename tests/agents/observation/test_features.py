"""Features are the same live and in training, and decisions turn with the arena."""

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.data.dataset import SeatSamples, Trajectory, windows_of
from movingout.agents.data.rollout import RolloutStep, rollout
from movingout.agents.inference.network import PolicyNetwork
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.observation.features import FeatureSet
from movingout.agents.observation.seat_observation import observe
from movingout.agents.policies.diffusion_policy import DiffusionPolicy
from movingout.agents.policies.export import export_policy
from movingout.agents.policies.own_frame import OwnFrameAugmentation
from movingout.maps import load_map
from movingout.maps.symmetry import Symmetry, transformed
from movingout.world.action import turned
from tests.world.observation.test_relative import moved

torch = pytest.importorskip("torch")
SPEC = PolicySpec(
    kind="dp", layout="relative-v1", lags=(2, 5), obs_horizon=1, horizon=8, execute=2, width=16, depth=1,
    denoiser="items",
)  # fmt: skip
SEEN = FeatureSet.of(SPEC)


def played(name: str = "DistancePriority", ticks: int = 12) -> list[RolloutStep]:
    pair = load_agent("scripted"), load_agent("scripted")
    return list(rollout(load_map(name), pair, seed=0, ticks=ticks))


def trajectory(steps: list[RolloutStep], name: str = "DistancePriority") -> Trajectory:
    states = [steps[0].before, *[step.after for step in steps]]
    return Trajectory(
        load_map(name),
        ("a", "b"),
        np.array([state.robot_poses for state in states]),
        np.array([state.robot_velocities for state in states]),
        np.array([state.held for state in states]),
        np.array([state.item_poses for state in states]),
        np.array([step.actions for step in steps]),
    )


def test_features_of_an_episode_are_those_seen_live() -> None:
    steps = played()
    whole = trajectory(steps).features(1, SEEN)
    states = [step.before for step in steps]
    for tick, state in enumerate(states):
        live = SEEN.of_moments(load_map("DistancePriority"), [state], [states[: tick + 1]], [1])[0]
        np.testing.assert_array_equal(live, whole[tick])
    assert whole.shape == (12, SEEN.size) == (12, SPEC.features)


def test_chunks_are_relative_to_the_angle_of_their_own_row() -> None:
    made = trajectory(played())
    samples = SeatSamples("a", made.features(0, SEEN), made.targets(0, "hold"), made.angles(0, SEEN))
    windows = windows_of([samples])
    row = np.array([4])
    chunk = windows.chunks(row, 3)[0]
    relative = made.actions[4:7, 0, 1] - made.robot_poses[4, 0, 2]
    np.testing.assert_allclose(chunk[:, 1], np.cos(relative), atol=1e-6)
    np.testing.assert_allclose(chunk[:, 2], np.sin(relative), atol=1e-6)
    back = turned(chunk[None], made.robot_poses[4:5, 0, 2])[0]
    np.testing.assert_allclose(back, made.targets(0, "hold")[4:7], atol=1e-6)


def agent(seed: int = 0) -> PolicyAgent:
    torch.manual_seed(seed)
    return PolicyAgent(SPEC, PolicyNetwork(SPEC, export_policy(DiffusionPolicy(SPEC))))


@pytest.mark.parametrize("turn", [Symmetry(quarters=1), Symmetry(quarters=2)])
def test_decisions_turn_with_the_arena(turn: Symmetry) -> None:
    here, there, the_map = agent(), agent(), load_map("DistancePriority")
    turned = transformed(the_map, turn)
    here.reset(EpisodeInfo(the_map, 0, 7, 100))
    there.reset(EpisodeInfo(turned, 0, 7, 100))
    for step in played(ticks=6):
        state = step.before
        plain = here.act(observe(the_map, state, 0))
        other = there.act(observe(turned, moved(state, turn), 0))
        angles = np.arctan2(plain[:, 2], plain[:, 1]) + turn.quarters * np.pi / 2
        np.testing.assert_allclose(other[:, 1:3], np.stack((np.cos(angles), np.sin(angles)), axis=1), atol=2e-3)
        np.testing.assert_allclose(other[:, [0, 3]], plain[:, [0, 3]], atol=2e-3)


def test_decisions_in_a_batch_are_those_made_alone() -> None:
    alone, agents, the_map = agent(), [agent(), agent()], load_map("DistancePriority")
    alone.reset(EpisodeInfo(the_map, 1, 7, 100))
    for seat, each in enumerate(agents):
        each.network = agents[0].network
        each.reset(EpisodeInfo(the_map, seat, 7, 100))
    for step in played(ticks=5):
        rows = PolicyAgent.act_many(agents, [observe(the_map, step.before, seat) for seat in (0, 1)])
        np.testing.assert_allclose(alone.act(observe(the_map, step.before, 1)), rows[1], atol=1e-5)


def test_augmentation_mirrors_features_as_the_mirrored_episode_has_them() -> None:
    mirror, steps = Symmetry(mirrored=True), played(ticks=8)
    states = [moved(step.before, mirror) for step in steps]
    there = transformed(load_map("DistancePriority"), mirror)
    expected = np.stack([SEEN.of_moments(there, [one], [states[: k + 1]], [0])[0] for k, one in enumerate(states)])
    features = torch.from_numpy(trajectory(steps).features(0, SEEN))[:, None]
    chunk = torch.arange(40.0).reshape(1, 8, 5).repeat(8, 1, 1)
    augment = OwnFrameAugmentation(SEEN, 1.0, 0.0)
    seen, turned = augment(features, chunk)
    np.testing.assert_allclose(seen[:, 0].numpy(), expected, atol=1e-5)
    assert torch.equal(turned[..., 2], -chunk[..., 2]) and torch.equal(
        turned[..., [0, 1, 3, 4]], chunk[..., [0, 1, 3, 4]]
    )
    forgetful, _ = OwnFrameAugmentation(SEEN, 0.0, 1.0)(features, chunk)
    still = SEEN.of_moments(load_map("DistancePriority"), [steps[-1].before], [[]], [0])
    np.testing.assert_allclose(forgetful[-1].numpy(), still, atol=1e-6)
