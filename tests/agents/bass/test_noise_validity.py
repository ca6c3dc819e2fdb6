"""Noise on poses: which recorded states stand it, and of which episode they are."""

from movingout.agents.bass.noise_validity import valid_after_noise
from movingout.world.estimates import estimate, estimate_of_copies
from tests.agents.learning import walked


def test_moments_of_an_episode_are_alike_and_count_together() -> None:
    trajectories = [walked("SingleRotation", seed=seed) for seed in range(3)]
    found = valid_after_noise(trajectories, deviation=0.02, samples=60, seed=1)
    assert len(found) == 60 and {episode for episode, _ in found} == {"0", "1", "2"}
    assert {share for _, share in found} == {0.0, 1.0}
    together, apart = estimate_of_copies(found), estimate([share for _, share in found])
    assert together is not None and apart is not None and together.mean == apart.mean
    assert together.stderr != apart.stderr
