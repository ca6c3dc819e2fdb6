"""An agent of a policy that draws its actions, with more, less or none of its noise."""

import numpy as np

from movingout.agents.agent_options import noise_factor
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.inference.network import PolicyNetwork, Singles
from movingout.agents.inference.policy_agent import PolicyAgent


class SamplingAgent(PolicyAgent):
    """Plays one seat with the actor of MAPPO."""

    def __init__(self, spec: PolicySpec, network: PolicyNetwork, noise: float = 1.0) -> None:
        """`noise`: a factor on what is drawn. Raises AgentError when it is out of range."""
        super().__init__(spec, network)
        self._noise = np.float32(noise_factor(noise))

    def noise(self, count: int) -> Singles:
        """(count, 1, 1, 5) for a decision."""
        drawn: Singles = super().noise(count) * self._noise
        return drawn
