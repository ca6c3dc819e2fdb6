"""Self-play over options: what is paid, advantages over decisions of different length, equal weights, and learning."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

pytest.importorskip("torchrl")

from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.bass.value import progress
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import DataError
from movingout.agents.partners.greedy_walker import GreedyWalker
from movingout.agents.partners.options.features import SIZE
from movingout.agents.partners.options.option import MOST_OPTIONS
from movingout.agents.partners.options.trained import TrainedScores
from movingout.agents.reinforcement import option_episodes
from movingout.agents.reinforcement.option_episodes import OptionChoice, advantages, item_progress, play_episode
from movingout.agents.reinforcement.option_network import NEVER, OptionNetwork, export_options
from movingout.agents.reinforcement.self_play import (
    EARLY_NETWORK,
    SelfPlay,
    learn_self_play,
    padded,
    read_early_network,
)
from movingout.agents.reinforcement.self_play_config import SelfPlayConfig
from movingout.agents.training.run_folder import RESUME
from movingout.maps import load_map
from movingout.world.scoring import delivered_many

TINY = SelfPlayConfig(episodes=4, round_episodes=2, young=2, passes=2, batch=8, ticks=50, width=8)
MAPS = "Simple", "HandOff"


def weights(learner: SelfPlay) -> list[torch.Tensor]:
    return [tensor.clone() for tensor in learner.network.state_dict().values()]


def equal(one: list[torch.Tensor], other: list[torch.Tensor]) -> bool:
    return all(torch.equal(a, b) for a, b in zip(one, other, strict=True))


def test_equal_seeds_give_equal_weights_also_after_an_interruption(tmp_path: Path) -> None:
    torch.manual_seed(1)
    whole = SelfPlay(TINY, MAPS)
    told: list[dict[str, float]] = []
    learn_self_play(whole, tmp_path / "whole", told.append)
    assert [one["episodes"] for one in told] == [2, 4]
    begun = SelfPlay(TINY, MAPS)
    learn_self_play(replaced(begun, episodes=2), tmp_path / "begun", told.append)
    torch.manual_seed(2)
    continued = SelfPlay(TINY, MAPS)
    assert not equal(weights(continued), weights(begun)), "a round has changed them"
    learn_self_play(continued, tmp_path / "begun", told.append)
    assert equal(weights(continued), weights(whole)) and continued.decisions == whole.decisions
    assert not equal(weights(SelfPlay(replace(TINY, seed=1), MAPS)), weights(SelfPlay(TINY, MAPS)))
    young = list(read_early_network(tmp_path / "whole", TINY.width).state_dict().values())
    assert equal(young, weights(begun)) and not equal(young, weights(whole))


def replaced(learner: SelfPlay, episodes: int) -> SelfPlay:
    learner.config = replace(learner.config, episodes=episodes)
    return learner


def test_what_items_add_is_progress() -> None:
    the_map = load_map("Simple")
    steps = list(rollout(the_map, (GreedyWalker(), IdleAgent()), seed=0, ticks=300))
    states = [steps[0].before, *(step.after for step in steps)]
    gained, delivered = item_progress(the_map, states)
    poses = np.stack([state.item_poses for state in states])
    whole = progress(the_map, poses, delivered_many(the_map, poses).astype(np.float64))
    assert np.allclose(gained.sum(axis=1), np.diff(whole)) and whole[-1] > 0.3 and delivered[-1].any()


def test_who_is_paid_for_its_own_alone_gets_nothing_for_what_the_partner_carries() -> None:
    gained, held = np.array([[0.1, 0.0], [0.2, 0.4], [0.3, 0.0]]), np.array([-1, 0, 0, -1])
    config = replace(TINY, cost=0.0)
    paid = [
        option_episodes._rewards(gained, held, replace(config, own=own)) / option_episodes.UNIT
        for own in (0.0, 1.0, 0.5)
    ]
    assert paid[0] == pytest.approx([0.1, 0.6, 0.3])
    assert paid[1] == pytest.approx([0.1, 0.2, 0.3])  # also in the tick in which it takes or lets go
    assert paid[2] == pytest.approx([0.1, 0.4, 0.3])
    assert option_episodes._rewards(gained, held, TINY)[0] < option_episodes._rewards(gained, held, config)[0]


def test_rewards_and_advantages_are_discounted_by_the_ticks_of_a_decision() -> None:
    config = replace(TINY, discount=0.5, trace=0.5)
    choices = [OptionChoice(tick, np.zeros((1, SIZE), np.float32), 0) for tick in (0, 2)]
    play = option_episodes._seat_play(choices, np.array([1.0, 1.0, 4.0, 2.0, 0.0]), config)
    assert play.rewards == pytest.approx([1.5, 5.0]) and play.ticks.tolist() == [2, 3]
    second = 5.0 - 2.0
    first = 1.5 + 0.5**2 * 2.0 - 1.0
    assert advantages(play, np.array([1.0, 2.0]), config) == pytest.approx([first + 0.5**2 * 0.5 * second, second])


def test_an_episode_is_decisions_of_both_seats_that_cover_it() -> None:
    def scores(features: np.ndarray) -> np.ndarray:
        return np.zeros(len(features), np.float32)

    played = play_episode(load_map("Simple"), scores, 0, TINY)
    for seat in played.seats:
        assert int(seat.ticks.sum()) == TINY.ticks and len(seat.choices) == len(seat.rewards) == len(seat.ticks)
        assert all(choice.chosen < len(choice.options) for choice in seat.choices)


def test_what_is_not_offered_is_never_drawn_and_the_order_makes_no_difference() -> None:
    network, random = OptionNetwork(8), np.random.default_rng(0)
    choice = OptionChoice(0, random.standard_normal((3, SIZE)).astype(np.float32), 0)
    options, offered = padded([choice, OptionChoice(0, choice.options[::-1].copy(), 0)])
    with torch.inference_mode():
        scores = network(options, offered)
    assert (scores[:, 3:] == NEVER).all() and torch.allclose(scores[0, :3], scores[1, :3].flip(0), atol=1e-6)


def test_what_plays_is_what_has_learned() -> None:
    network, random = OptionNetwork(64), np.random.default_rng(0)
    features = random.standard_normal((5, SIZE)).astype(np.float32)
    with torch.inference_mode():
        wanted = network(torch.from_numpy(features)[None], torch.ones(1, 5))[0].numpy()
    assert TrainedScores(export_options(network))(features) == pytest.approx(wanted, abs=1e-3)
    assert options_shape(network) == [MOST_OPTIONS, SIZE]


def options_shape(network: OptionNetwork) -> list[int]:
    return TrainedScores(export_options(network))._network.input_shapes["options"][1:]


@pytest.mark.slow
def test_a_small_training_on_an_easy_map_brings_more_progress() -> None:
    config = SelfPlayConfig(episodes=24, round_episodes=4, young=4, ticks=100, rate=5e-3, passes=10, batch=64)
    learner = SelfPlay(config, ["Simple"])
    told = [learner.learn()["progress"] for _ in range(config.rounds)]
    assert np.mean(told[-3:]) > np.mean(told[:3]) + 0.15  # 0.22 to 0.27 with three seeds


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    learner = SelfPlay(TINY, MAPS)
    (tmp_path / RESUME).write_bytes(b"no tensors")
    with pytest.raises(DataError, match="is damaged or of another policy"):
        learner.resume(tmp_path / RESUME)
    with pytest.raises(DataError, match=f"{EARLY_NETWORK} is missing or damaged"):
        read_early_network(tmp_path, 8)


def test_a_copy_later_than_the_last_episode_is_refused() -> None:
    with pytest.raises(DataError, match="--young 5"):
        replace(TINY, young=5).check()
