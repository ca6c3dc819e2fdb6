"""The player over options: equal seeds give equal play, temperature, when it decides; what it sees has no places."""

from dataclasses import replace

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.data.rollout import rollout
from movingout.agents.partners.options.features import SIZE, OptionFeatures, Singles
from movingout.agents.partners.options.option import RobotOption, offered
from movingout.agents.partners.options.player import DECIDES_EVERY, OptionPlayer
from movingout.agents.partners.walking import Perceiver
from movingout.maps import load_map
from movingout.world.state import Floats
from tests.agents.partners.options.test_option import LIGHT, MAP, lying_in
from tests.agents.partners.scenes import asked, holding, scene, seated


def alike(features: Singles) -> Singles:
    return np.zeros(len(features), np.float32)


def eager(features: Singles) -> Singles:
    """Takes what is nearest and carries it to the nearest goal region."""
    taking, carrying = features[:, 0], features[:, 1]
    scores: Singles = 9 * (taking + carrying) - 9 * features[:, 7] * taking - 9 * features[:, 19] * carrying
    return scores


def played(player: OptionPlayer, seed: int = 0) -> Floats:
    agents = player, OptionPlayer(alike)
    return np.stack([step.after.robot_poses[0] for step in rollout(load_map(MAP), agents, seed, 80)])


def test_equal_seeds_give_equal_play_and_others_do_not() -> None:
    assert np.array_equal(played(OptionPlayer(alike, 3)), played(OptionPlayer(alike, 3)))
    assert not np.array_equal(played(OptionPlayer(alike, 3)), played(OptionPlayer(alike, 4)))
    assert not np.array_equal(played(OptionPlayer(alike, 3)), played(OptionPlayer(alike, 3), seed=1))


def test_at_temperature_0_the_best_is_taken_and_a_higher_one_draws_more_widely() -> None:
    def drawn(temperature: float) -> list[int]:
        player = OptionPlayer(lambda features: features[:, 0], temperature=temperature)
        seated(player, MAP)
        rows = np.zeros((3, SIZE), np.float32)
        rows[1, 0] = 1.0
        return [player.draw(0, rows) for _ in range(200)]

    assert set(drawn(0.0)) == {1}
    assert drawn(0.25).count(1) > drawn(1.0).count(1) > drawn(5.0).count(1)


def test_something_is_delivered_by_whoever_takes_the_nearest() -> None:
    agents = OptionPlayer(eager, temperature=0.0), OptionPlayer(eager, seed=1, temperature=0.0)
    the_map = load_map("Simple")
    last = list(rollout(the_map, agents, seed=0, ticks=300))[-1].after
    assert Perceiver(the_map, 0).perceive(last).delivered.any()


def test_it_decides_when_something_happens_and_else_a_few_times_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    decided: list[int] = []
    player = OptionPlayer(alike)

    def waits(tick: int, features: Singles) -> int:
        decided.append(tick)
        return 0

    monkeypatch.setattr(player, "draw", waits)
    seated(player, MAP)
    for tick in range(DECIDES_EVERY + 5):
        state = scene(MAP, tick=tick)
        if tick >= 3:
            state = replace(state, held=np.array([-1, LIGHT]))
        asked(player, MAP, state)
    assert decided == [0, 3, 3 + DECIDES_EVERY]


def test_what_is_delivered_is_let_go_of_whatever_was_chosen() -> None:
    state = lying_in(LIGHT, 0)
    poses = state.robot_poses.copy()
    poses[0] = [*state.item_poses[LIGHT, :2] - [0.0, 0.3], 0.0]
    state = replace(state, robot_poses=poses, held=np.array([LIGHT, -1]))
    player = OptionPlayer(alike)
    seated(player, MAP)
    assert asked(player, MAP, state)[0, 3] == 1.0


def first_features(map_name: str) -> Singles:
    the_map = load_map(map_name)
    now = Perceiver(the_map, 0).perceive(scene(map_name))
    features = OptionFeatures(EpisodeInfo(the_map, 0, 0, 500))
    features.see(now)
    return features.of(now, offered(now))


@pytest.mark.parametrize("symmetry", ["mirror", "rot90"])
def test_a_mirrored_or_turned_map_looks_the_same(symmetry: str) -> None:
    assert np.allclose(first_features(MAP), first_features(f"{MAP}:{symmetry}"), atol=0.06)


def test_how_long_something_was_tried_is_seen() -> None:
    the_map = load_map(MAP)
    features, perceiver = OptionFeatures(EpisodeInfo(the_map, 0, 0, 500)), Perceiver(the_map, 0)
    features.chosen(RobotOption("take", LIGHT), perceiver.perceive(scene(MAP)))
    for tick in range(1, 31):
        features.see(perceiver.perceive(scene(MAP, tick=tick)))
    now = perceiver.perceive(scene(MAP, tick=30))
    options = offered(now)
    rows = features.of(now, options)
    tried = options.index(RobotOption("take", LIGHT))
    assert rows[tried, 23:26] == pytest.approx([1.0, 0.3, 0.3])
    assert not np.delete(rows, tried, axis=0)[:, 23:26].any()


def test_a_held_item_that_nears_its_spot_is_seen() -> None:
    the_map, near, far = load_map(MAP), holding(MAP, LIGHT), holding(MAP, LIGHT)
    features, perceiver = OptionFeatures(EpisodeInfo(the_map, 0, 0, 500)), Perceiver(the_map, 0)
    features.see(perceiver.perceive(far))
    options = offered(perceiver.perceive(far))
    carried = next(index for index, option in enumerate(options) if option.kind == "carry")
    poses, (x, y) = near.item_poses.copy(), options[carried].spot
    poses[LIGHT, :2] += 0.1 * (np.array([x, y]) - poses[LIGHT, :2])
    now = perceiver.perceive(replace(near, item_poses=poses))
    features.see(now)
    assert features.of(now, offered(now))[carried, 40] > 0.1
