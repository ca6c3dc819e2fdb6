"""BASS from pictures at play: candidates are simulated as pictures, and the one that leads farthest is played.

How far a picture is along is its distance from the episode's first picture in a learned embedding (paper, "Scalability
to more complex environments"); nothing is known of where items and goals are.
"""

from collections.abc import Sequence

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.agent import BassAgent, acting, candidates_of
from movingout.agents.bass.selection import Choice, choice_from_scores, joint_chunks
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.inference.network import Network, PolicyNetwork, Singles
from movingout.agents.inference.policy_agent import PolicyAgent
from movingout.agents.observation.seat_observation import start_state
from movingout.world.observation import encode_state
from movingout.world.state import Floats, WorldState


class PictureBassAgent(BassAgent):
    """A policy that sees pictures, with simulation and selection on top."""

    def __init__(
        self, spec: PolicySpec, network: PolicyNetwork, dynamics: Network, progress: Network, selection: SelectionSpec,
        execute: int = 0,
    ) -> None:  # fmt: skip
        super().__init__(spec, network, dynamics, selection, execute)
        self.progress = progress

    def reset(self, episode: EpisodeInfo) -> None:
        PolicyAgent.reset(self, episode)
        self._partner_history = []
        first = encode_state(episode.map, start_state(episode.map), episode.seat, self.spec.layout)
        self._first = self.progress(picture=first[None].astype(np.float32))[0]  # (1, Z)

    @staticmethod
    def decide_many(
        agents: Sequence[PolicyAgent], states: Sequence[WorldState], histories: Singles
    ) -> Sequence[Singles]:
        """What `decide` of each would return; candidates of all are sampled, simulated and embedded in one batch."""
        bass = [agent for agent in agents if isinstance(agent, PictureBassAgent)]
        candidates = candidates_of(bass, states, histories)
        joints = [
            joint_chunks(0, acting(own), acting(guesses), agent.selection)
            for agent, (own, guesses) in zip(bass, candidates, strict=True)
        ]
        counts = [len(joint) for joint in joints]
        after = _network(bass[0].dynamics)(
            picture=np.repeat(histories[:, -1], counts, axis=0), actions=np.concatenate(joints).astype(np.float32)
        )[0]
        embedded = np.split(bass[0].progress(picture=after)[0], np.cumsum(counts)[:-1])
        return [
            agent._chosen(own, guesses, agent._choice(each))
            for agent, (own, guesses), each in zip(bass, candidates, embedded, strict=True)
        ]

    def _choice(self, embedded: Singles) -> Choice:
        """The candidate whose pictures (R, Z) are farthest from the first one."""
        far: Floats = np.linalg.norm((embedded - self._first).astype(np.float64), axis=1)
        return choice_from_scores(far, np.empty((len(far), 0, 0)), self.selection)

    def _trace(self, own: Singles, guesses: Singles, choice: Choice) -> dict[str, object]:
        """As of every BASS agent, but for where robots and items are expected: it knows no places."""
        return {
            "chosen": choice.index,
            "scores": np.round(choice.scores, 4).tolist(),
            "plan": f"candidate {choice.index + 1} of {len(own)}, by pictures",
        }


def _network(dynamics: Network | None) -> Network:
    assert dynamics is not None
    return dynamics
