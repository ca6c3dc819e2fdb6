"""The search finds the corner of the latents where a score is worst, and stays within its radius."""

from collections.abc import Sequence

import numpy as np
import pytest

from movingout.agents.errors import AgentError
from movingout.agents.generative.weakness import SearchPlan, search, within
from movingout.world.state import Floats

CORNER = np.array([1.5, -1.5, 0.5])


def _far_from_the_corner(_: int, latents: Sequence[Floats]) -> list[float]:
    return [float(np.linalg.norm(latent - CORNER)) for latent in latents]


def test_the_bad_corner_is_found() -> None:
    found = search(SearchPlan(3, rounds=10, candidates=16), _far_from_the_corner, np.random.default_rng(0))
    assert len(found) == 160 and found[0].score < 0.3
    assert [one.score for one in found] == sorted(one.score for one in found)
    last = [one.score for one in found if one.round == 9]
    assert np.mean(last) < 0.5 * np.mean([one.score for one in found if one.round == 0])


def test_what_lies_outside_the_radius_is_not_tried() -> None:
    plan = SearchPlan(3, rounds=8, candidates=8, radius=1.0)
    found = search(plan, _far_from_the_corner, np.random.default_rng(0))
    assert max(np.linalg.norm(one.latent) for one in found) <= 1.0 + 1e-9
    assert np.dot(found[0].latent, CORNER) / np.linalg.norm(CORNER) > 0.9  # the place nearest to the corner
    assert np.allclose(within(np.array([[3.0, 4.0], [0.3, 0.0]]), 1.0), [[0.6, 0.8], [0.3, 0.0]])


def test_equal_seeds_search_alike() -> None:
    one, same = (
        search(SearchPlan(3, rounds=2), _far_from_the_corner, np.random.default_rng(4))[0].latent for _ in range(2)
    )
    assert np.array_equal(one, same)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [({"rounds": 0}, "at least 1 round and 4 candidates"), ({"candidates": 3}, "4 candidates"), ({"radius": 9.0}, "9")],
)
def test_a_search_that_cannot_be_is_refused(changes: dict[str, float], sentence: str) -> None:
    with pytest.raises(AgentError, match=sentence):
        SearchPlan(3, **changes).check()  # type: ignore[arg-type]
