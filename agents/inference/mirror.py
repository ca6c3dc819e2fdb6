"""Decisions through the mirror: an agent that decides on mirrored states what is the mirror image of its decisions.

A policy that learned from mirrored windows is only nearly symmetric. Each decision is therefore drawn directly or, with
equal chance, through the mirror: what is seen is mirrored, a chunk is sampled, and the chunk is mirrored back. The
distribution of decisions is then exactly the mirror image on the mirrored state, whatever the policy is.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from movingout.agents.errors import AgentError
from movingout.agents.observation.features import FeatureSet, Singles

if TYPE_CHECKING:
    from movingout.agents.inference.network import PolicyNetwork

_SIN = 2  # column of an action's sideways component, relative to the own heading


class FeatureMirror:
    """The mirror of a layout in the own frame."""

    def __init__(self, seen: FeatureSet) -> None:
        """Raises AgentError for a layout without one."""
        mirror = seen.mirror
        if mirror is None:
            raise AgentError(f"mirrored=yes is for agents that see their own frame, not the layout {seen.layout}")
        self._order, self._signs = mirror[0], mirror[1].astype(np.float32)

    def image(self, features: Singles) -> Singles:
        """Features (..., D) as the mirrored state has them."""
        image: Singles = features[..., self._order] * self._signs
        return image

    def sample(self, network: "PolicyNetwork", histories: Singles, noise: Singles, flips: Sequence[bool]) -> Singles:
        """Chunks (B, H, 5) for observations (B, To, D), through the mirror where `flips` (B) says so."""
        through: npt.NDArray[np.bool_] = np.array(flips)[:, None, None]
        chunks = network.run(np.where(through, self.image(histories), histories), noise)
        back = chunks.copy()
        back[..., _SIN] *= -1.0
        drawn: Singles = np.where(through, back, chunks)
        return drawn


def sampled(
    network: "PolicyNetwork", histories: Singles, noise: Singles, mirror: FeatureMirror | None, flips: Sequence[bool]
) -> Singles:
    """Chunks (B, H, 5) for observations (B, To, D), through the mirror, if there is one, where `flips` (B) says so."""
    if mirror is None or not any(flips):
        chunks: Singles = network.run(histories, noise)
        return chunks
    return mirror.sample(network, histories, noise, flips)
