"""Where an agent is worst among the partners of a generative model: the cross-entropy method over latents.

After GOAT (Chaudhary et al. 2025): the model is frozen and latents stay within a radius, so that what is found is a
partner as there are in the data, and no saboteur.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from movingout.agents.errors import AgentError
from movingout.world.state import Floats

ELITE = 0.25  # share of a round's candidates from which the next ones are drawn
KEPT = 0.3  # share of the old centre and spread in the new ones
NARROWEST = 0.2  # smallest spread, so that the search goes on
Score = Callable[[int, Sequence[Floats]], Sequence[float]]
"""Gives the score of each latent in a round; small is bad for the agent."""


@dataclass(frozen=True, slots=True)
class SearchPlan:
    """How latents are searched."""

    size: int  # numbers of a latent
    rounds: int = 6
    candidates: int = 12  # in each round
    radius: float = 3.0  # of latents; the mean length of a drawn one with 8 numbers is 2.7

    def check(self) -> None:
        """Raises AgentError for a plan that cannot be."""
        if self.rounds < 1 or self.candidates < 4:
            raise AgentError("a search has at least 1 round and 4 candidates in each")
        if not 0.0 < self.radius <= 8.0:
            raise AgentError(f"the radius of latents is more than 0 and at most 8, not {self.radius:g}")


@dataclass(frozen=True, slots=True, eq=False)
class TriedLatent:
    """A latent, the round in which it was tried, and its score there."""

    latent: Floats  # (size,)
    round: int
    score: float


def search(plan: SearchPlan, score: Score, random: np.random.Generator) -> list[TriedLatent]:
    """All latents that were tried, the worst for the agent first."""
    plan.check()
    centre, spread = np.zeros(plan.size), np.ones(plan.size)
    found: list[TriedLatent] = []
    for number in range(plan.rounds):
        drawn = centre + spread * random.standard_normal((plan.candidates, plan.size))
        latents = within(drawn, plan.radius)
        scores = score(number, list(latents))
        tried = [TriedLatent(latent, number, value) for latent, value in zip(latents, scores, strict=True)]
        found += tried
        elite = np.array([one.latent for one in _worst(tried)[: max(round(ELITE * plan.candidates), 2)]])
        centre = KEPT * centre + (1 - KEPT) * elite.mean(axis=0)
        spread = np.maximum(KEPT * spread + (1 - KEPT) * elite.std(axis=0), NARROWEST)
    return _worst(found)


def within(latents: Floats, radius: float) -> Floats:
    """Latents (N, size), shortened to the radius where they are longer."""
    lengths = np.linalg.norm(latents, axis=1, keepdims=True)
    shortened: Floats = latents * np.minimum(1.0, radius / np.maximum(lengths, 1e-9))
    return shortened


def _worst(found: Sequence[TriedLatent]) -> list[TriedLatent]:
    return sorted(found, key=lambda one: one.score)
