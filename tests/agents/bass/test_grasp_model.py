"""Hands in the simulator of BASS, against the geometry of items and the engine."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.bass.config import BassConfig
from movingout.agents.bass.dynamics_training import train_dynamics, transitions_of
from movingout.agents.bass.grasp_model import Grasping, hands_of
from movingout.agents.bass.state_vector import ITEMS_START, MOVING_WIDTH, constant, moving
from movingout.agents.data.rollout import rollout
from movingout.agents.observation.seat_observation import start_state
from movingout.agents.scripted import ScriptedAgent
from movingout.maps import MapSpec, load_map, map_names
from movingout.maps.surface import surface_distance
from tests.agents.learning import walked

_FAR = 5.0


def _rows(the_map: MapSpec, count: int, seed: int) -> np.ndarray:
    """(count, 58) the start of a map, the robots anywhere."""
    random = np.random.default_rng(seed)
    rows = np.tile(moving(start_state(the_map)), (count, 1))
    for first in (0, 7):
        rows[:, first : first + 2] = random.uniform(-1.0, 1.0, (count, 2))
        angles = random.uniform(-np.pi, np.pi, count)
        rows[:, first + 2], rows[:, first + 3] = np.cos(angles), np.sin(angles)
    return rows


def _tensors(the_map: MapSpec, rows: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    of_map = np.tile(constant(the_map), (len(rows), 1))
    return torch.from_numpy(rows.astype(np.float32)), torch.from_numpy(of_map.astype(np.float32))


@pytest.mark.parametrize("name", map_names())
def test_gaps_are_the_distances_to_the_surfaces_of_items(name: str) -> None:
    the_map = load_map(name)
    rows = _rows(the_map, 100, seed=1)
    state, of_map = _tensors(the_map, rows)
    robots = state[:, :14].reshape(-1, 2, 7)
    gaps = Grasping().gaps(robots, state, of_map).numpy()
    for seat in (0, 1):
        x, y, cos, sin = rows[:, 7 * seat : 7 * seat + 4].T
        probes = np.stack((x - 0.095 * sin, y + 0.095 * cos), axis=1)
        for index, item in enumerate(the_map.items):
            place = start_state(the_map).item_poses[index]
            away, angle = probes - place[:2], place[2]
            turned = np.stack(
                (np.cos(angle) * away[:, 0] + np.sin(angle) * away[:, 1],
                 np.cos(angle) * away[:, 1] - np.sin(angle) * away[:, 0]), axis=1,
            )  # fmt: skip
            expected = surface_distance(item.shape, item.scale, turned)
            outside = expected > 0.0
            assert np.allclose(gaps[outside, seat, index], expected[outside], atol=1e-4)
    assert (gaps[:, :, len(the_map.items) :] > _FAR).all()


def test_a_small_item_that_the_other_one_holds_cannot_be_taken_and_a_middle_one_can() -> None:
    the_map = load_map("DistancePriority")
    sizes = [item.size for item in the_map.items]
    small, middle = sizes.index("small"), sizes.index("middle")
    rows = _rows(the_map, 2, seed=2)
    for row, held in zip(rows, (small, middle), strict=True):
        row[14 + 7], row[14 + held] = 0.0, 1.0
    state, of_map = _tensors(the_map, rows)
    gaps = Grasping().gaps(state[:, :14].reshape(-1, 2, 7), state, of_map)
    assert gaps[0, 1, small] > _FAR > gaps[1, 1, middle]
    assert gaps[0, 0, small] < _FAR


@pytest.mark.slow
def test_hands_change_as_the_engine_changes_them() -> None:
    """Blue's always; red's nearly always, since its hand moves half a tick later."""
    grasping = Grasping()
    right: list[list[bool]] = [[], []]
    for number, name in enumerate(("HandOff", "SingleRotation", "DistancePriority", "CornerDecision")):
        the_map = load_map(name)
        for step in rollout(the_map, (ScriptedAgent(), ScriptedAgent(seed=1)), number, 300):
            press = step.actions[:, 2] > 0.5
            state, of_map = _tensors(the_map, moving(step.before)[None])
            found = grasping(state, of_map, torch.from_numpy(press[None].astype(np.float32))).argmax(-1)[0]
            expected = hands_of(torch.from_numpy(moving(step.after)[None])).argmax(-1)[0]
            for seat in np.flatnonzero(press):
                right[seat].append(bool(found[seat] == expected[seat]))
            assert (found == expected)[~torch.from_numpy(press)].all()
    assert min(map(len, right)) > 12
    assert all(right[0])
    assert np.mean(right[1]) > 0.9


def test_a_trained_simulator_lets_go_when_a_hand_presses(tmp_path: Path) -> None:
    data = transitions_of([walked("DistancePriority", ticks=20, seed=seed) for seed in range(3)])
    dynamics = train_dynamics(BassConfig(width=16, latent=4, updates=2, batch=16), data, tmp_path).network
    the_map = load_map("DistancePriority")
    rows = _rows(the_map, 1, seed=3)
    rows[0, 14 + 7], rows[0, 14] = 0.0, 1.0  # blue holds the first item
    state, of_map = _tensors(the_map, rows)
    for press, held in ((0.0, 0), (1.0, 7)):
        after = dynamics.advance(state, of_map, torch.tensor([[0.5, 1.0, 0.0, press, 0.5, 1.0, 0.0, 0.0]]))
        assert after.shape == (1, MOVING_WIDTH)
        assert hands_of(after)[0].argmax(-1).tolist() == [held, 7]
    assert ITEMS_START not in dynamics.learned and 14 not in dynamics.learned
    losses = json.loads((tmp_path / "losses.jsonl").read_text(encoding="utf-8").splitlines()[-1])
    assert losses["validation/presses"] > 0.9
