"""The measures of diversity on trajectories of agents."""

from movingout.agents.data.diversity import diversity
from tests.agents.learning import walked


def test_equal_episodes_are_not_diverse_and_different_ones_are() -> None:
    same = diversity([walked("DistancePriority", seed=1)] * 3)
    different = diversity([walked("DistancePriority", seed=seed) for seed in (1, 2, 3)])
    assert (same.dtw_mean, same.dtw_variance, same.coverage) == (0.0, 0.0, 0.0)
    assert different.dtw_mean > 0 and different.dtw_variance > 0 and different.coverage > 0
    assert different.entropy > same.entropy
