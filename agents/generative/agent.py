"""A partner out of the generative model at play: a policy that is told in every decision who it is."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.agents.base import EpisodeInfo
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.errors import AgentError
from movingout.agents.inference.network import PolicyNetwork, Singles
from movingout.agents.inference.policy_agent import PolicyAgent

FARTHEST = 8.0  # of a number of a latent; what is learned lies within 3
_SALT = 0x7A7E


class LatentAgent(PolicyAgent):
    """Plays one latent: that of its options, or another one in every episode."""

    def __init__(
        self, spec: PolicySpec, network: PolicyNetwork, seed: int = 0, z: object = "", execute: int = 0
    ) -> None:
        """`seed`: with the seed of the episode, it says who plays. `z`: the latent itself, as `0.3/-1.2/…`.

        Raises AgentError for a seed or a latent that cannot be.
        """
        super().__init__(spec, network, execute)
        if type(seed) is not int:
            raise AgentError(f"seed is a whole number, not {seed!r}")
        self.seed = seed
        self._given = parsed_latent(str(z), spec.latent) if z != "" else None

    def reset(self, episode: EpisodeInfo) -> None:
        """Start an episode as the partner of the options, or as one that its seed draws."""
        super().reset(episode)
        random = np.random.default_rng([_SALT, self.seed % 2**31, episode.seed % 2**31, episode.seat])
        drawn = random.standard_normal(self.spec.latent, dtype=np.float32)
        self.latent: Singles = drawn if self._given is None else self._given

    def _stacked(self) -> Singles:
        rows = super()._stacked()
        return np.concatenate((rows, np.tile(self.latent, (len(rows), 1))), axis=1)


def parsed_latent(text: str, size: int) -> Singles:
    """The latent (size,) that an option names. Raises AgentError."""
    try:
        numbers = [float(word) for word in text.split("/")]
    except ValueError:
        raise AgentError(f"z is {size} numbers joined by /, such as 0.3/-1.2/…, not {text!r}") from None
    if len(numbers) != size:
        raise AgentError(f"z has {size} numbers in this model, not {len(numbers)}: {text!r}")
    if not all(math.isfinite(number) and abs(number) <= FARTHEST for number in numbers):
        raise AgentError(f"the numbers of z lie between -{FARTHEST:g} and {FARTHEST:g}: {text!r}")
    return np.array(numbers, dtype=np.float32)


def latent_text(latent: npt.NDArray[np.floating[Any]]) -> str:
    """A latent as the option `z` takes it."""
    return "/".join(f"{number:.3f}" for number in latent.tolist())
