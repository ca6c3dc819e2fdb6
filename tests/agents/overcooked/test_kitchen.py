"""Overcooked-AI behind our interfaces; with the package alone where it is installed."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
import torch

from movingout.agents.errors import AgentError
from movingout.agents.overcooked import kitchen
from movingout.agents.overcooked.kitchen import (
    HEADINGS,
    INTERACT,
    KITCHEN_SIZE,
    STAY,
    Kitchen,
    action_of,
    features,
    is_installed,
    row_of,
)
from movingout.agents.overcooked.play import play_kitchen
from movingout.agents.overcooked.recordings import KitchenEpisode, kitchen_episodes
from movingout.agents.overcooked.training import KitchenParts, KitchenSizes, train_kitchen

needs_package = pytest.mark.skipif(not is_installed(), reason="the extra overcooked is not installed")
TINY = KitchenSizes(updates=2, simulator_updates=2, width=8, batch=4)
STATE = {
    "players": [
        {"position": [1, 2], "orientation": [0, -1]},
        {"position": [3, 1], "orientation": [1, 0], "held_object": {"name": "onion", "position": [3, 1]}},
    ],
    "objects": {"2,0": {"name": "soup", "position": [2, 0], "state": ["onion", 3, 10]}},
}


def test_every_action_is_a_row_and_back() -> None:
    for action in (*HEADINGS, STAY, INTERACT):
        assert action_of(row_of(action, (0, -1))) == action
    assert row_of(STAY, (1, 0)).tolist() == [0.0, 1.0, 0.0, 1.0, -1.0]


def test_the_other_cook_sees_the_same_with_the_cooks_exchanged() -> None:
    own, other = features(STATE, 0), features(STATE, 1)
    size = (KITCHEN_SIZE - 66) // 2
    assert own.shape == (KITCHEN_SIZE,) and np.array_equal(own[:size], other[size : 2 * size])
    assert np.array_equal(own[2 * size :], other[2 * size :])
    assert own[-6:].tolist() == [0.0, 0.0, 0.0, 1.0, 0.5, 0.0], "three onions, half done"


def test_without_the_package_there_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kitchen, "is_installed", lambda: False)
    with pytest.raises(AgentError, match=r"Overcooked-AI is not installed; install it with: .* -m pip install"):
        Kitchen()


def test_the_same_seed_trains_the_same_parts(tmp_path: Path) -> None:
    games = [_game("one", 0), _game("two", 1)]
    first, second = (train_kitchen(games, TINY, 0, tmp_path / name) for name in "ab")
    assert _weights(first) == _weights(second)


@needs_package
def test_a_state_of_today_is_seen_like_one_of_2019() -> None:
    room = Kitchen()
    then = {
        "players": [
            {"position": [1, 2], "orientation": [0, -1]},
            {"position": [3, 1], "orientation": [0, -1]},
        ],
        "objects": {},
    }
    assert np.array_equal(room.observation(0), features(then, 0))


@needs_package
def test_what_people_played_comes_with_the_package() -> None:
    games = kitchen_episodes(ticks=200)
    assert len(games) == 16 and {one.observations.shape for one in games} == {(200, 2, KITCHEN_SIZE)}
    assert sum(one.soups.sum() for one in games) > 16


@needs_package
def test_what_people_did_delivers_here_what_they_delivered_and_shows_what_they_saw() -> None:
    for game in kitchen_episodes()[:4]:
        room, points = Kitchen(), []
        for seen, rows in zip(game.observations, game.rows, strict=True):
            assert np.array_equal([room.observation(cook) for cook in (0, 1)], seen)
            points.append(room.step(rows))
        assert np.array_equal(points, 20.0 * game.soups) and sum(points) > 200


@needs_package
def test_a_pot_cooks_with_three_onions_by_itself_and_with_fewer_not_at_all() -> None:
    room = Kitchen()
    fetch = ((1, 0), INTERACT, (-1, 0), (0, -1), INTERACT)  # from (3, 1): an onion, to (2, 1), into the pot
    for onions in (1, 2, 3):
        _play(room, *fetch, INTERACT, (1, 0))
        pot = room.observation(1)[-6:]
        assert pot[onions] == 1.0 and (pot[4] > 0.0) == (onions == 3)


@needs_package
def test_trained_cooks_play_alone_and_with_simulation_and_the_same_seed_gives_the_same_points(tmp_path: Path) -> None:
    parts = train_kitchen([_game("one", 0), _game("two", 1)], TINY, 0, tmp_path)
    for bass in (False, True):
        first, second = (play_kitchen(parts, 2, 9, 3, bass=bass) for _ in range(2))
        assert first == second and len(first) == 2


def _play(room: Kitchen, *actions: tuple[int, int] | str) -> None:
    """The second cook acts, the first stays."""
    for action in actions:
        room.step(np.array([row_of(STAY, (0, -1)), row_of(action, (0, -1))]))


def _game(pair: str, seed: int) -> KitchenEpisode:
    random = np.random.default_rng(seed)
    rows = np.array(
        [[row_of(HEADINGS[random.integers(4)], (0, 1)) for _ in range(2)] for _ in range(20)], dtype=np.float32
    )
    seen = random.random((20, 2, KITCHEN_SIZE)).astype(np.float32)
    return KitchenEpisode(pair, seen, rows, (np.arange(20) == 15).astype(np.float32))


def _weights(parts: KitchenParts) -> str:
    networks: tuple[torch.nn.Module, ...] = (parts.policy, parts.dynamics, parts.value)
    tensors = (tensor for network in networks for tensor in network.state_dict().values())
    return hashlib.sha256(b"".join(tensor.numpy().tobytes() for tensor in tensors)).hexdigest()
