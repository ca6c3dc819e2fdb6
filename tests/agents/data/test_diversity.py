"""The four measures of how different episodes are."""

import numpy as np

from movingout.agents.data.diversity import diversity, dynamic_time_warping, place_entropy
from tests.agents.learning import walked


def test_equal_episodes_are_not_diverse_and_different_ones_are() -> None:
    same = diversity([walked("DistancePriority", seed=1)] * 3)
    different = diversity([walked("DistancePriority", seed=seed) for seed in (1, 2, 3)])
    assert (same.dtw_mean, same.dtw_variance, same.coverage) == (0.0, 0.0, 0.0)
    assert different.dtw_mean > 0 and different.dtw_variance > 0 and different.coverage > 0
    assert different.entropy > same.entropy


def test_time_warping_forgives_a_pause_but_not_another_way() -> None:
    way = np.column_stack([np.linspace(0, 1, 20)] * 4)
    paused = np.concatenate((way[:10], np.tile(way[9], (15, 1)), way[10:]))
    assert dynamic_time_warping(way, paused) == 0.0
    assert dynamic_time_warping(way, way[:, ::-1] * (1, -1, 1, -1)) > 1.0


def test_entropy_is_one_when_all_places_are_visited_equally_and_small_for_one_place() -> None:
    everywhere = np.stack(np.meshgrid(*[np.linspace(-1.19, 1.19, 96)] * 2), axis=-1).reshape(-1, 2)
    assert place_entropy(everywhere) > 0.99
    assert place_entropy(np.zeros((10, 2))) < 0.5
