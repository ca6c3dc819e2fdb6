"""A partner out of the generative model at play: a policy that is told in every decision who it is."""

import numpy as np

from movingout.agents.agent_options import whole_number
from movingout.agents.base import EpisodeInfo
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.generative.latent_option import parsed_latent
from movingout.agents.inference.network import PolicyNetwork, Singles
from movingout.agents.inference.policy_agent import PolicyAgent

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
        self.seed = whole_number("seed", seed)
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
