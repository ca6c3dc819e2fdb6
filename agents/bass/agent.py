"""BASS at play: own candidates and predictions of the partner are simulated together, and the best one is played."""

from collections.abc import Hashable, Sequence

import numpy as np

from movingout.agents.base import EpisodeInfo, Observation
from movingout.agents.bass.score_functions import Estimator, score_function, score_rollouts
from movingout.agents.bass.selection import Choice, Simulator, choice_from_scores, joint_chunks
from movingout.agents.bass.state_vector import constant, item_places, moving, robot_places
from movingout.agents.checkpoint.card import SelectionSpec
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.inference.mirror import sampled
from movingout.agents.inference.network import Network, PolicyNetwork, Singles
from movingout.agents.inference.policy_agent import PolicyAgent, encoded
from movingout.world.action import turned
from movingout.world.state import Floats, WorldState

SPREAD = 0.3  # standard deviation of the noise on distance, cos and sin for deterministic policies


class BassAgent(PolicyAgent):
    """Any base policy with simulation and selection on top."""

    def __init__(
        self, spec: PolicySpec, network: PolicyNetwork, dynamics: Network | None, selection: SelectionSpec,
        execute: int = 0,
        value: Estimator | None = None, mirrored: bool = False,
    ) -> None:  # fmt: skip
        """`dynamics`: the learned simulator; None for agents that have another one.

        `mirrored`: candidates and guesses are drawn directly or, with equal chance, through the mirror.
        """
        super().__init__(spec, network, execute, mirrored)
        self.dynamics = dynamics
        self.selection = selection
        self.value = value
        self._partner_history: list[Singles] = []

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._partner_history = []
        self.score_function = score_function(episode.map, episode.seat, self.selection, self.value)

    @property
    def batch_key(self) -> Hashable:
        """Agents that share network, simulator and selection decide together."""
        networks = id(self.network), id(self.dynamics), id(self.value and self.value.network)
        return type(self), *networks, self.selection, self.mirror is None

    def decide(self, state: WorldState, history: Singles) -> Singles:
        """Sample, simulate, select; leaves the trace of the decision in `detail`."""
        chunk: Singles = self.decide_many([self], [state], history[None])[0]
        return chunk

    @staticmethod
    def remember_many(seen: Sequence[tuple[PolicyAgent, Observation]]) -> None:
        """Add each agent's and each partner's observation to the histories."""
        bass = [(agent, observation.state) for agent, observation in seen if isinstance(agent, BassAgent)]
        own = [agent.view(state, agent.episode.seat) for agent, state in bass]
        theirs = [agent.view(state, 1 - agent.episode.seat) for agent, state in bass]
        features = encoded([*own, *theirs])
        for (agent, _), mine, partners in zip(bass, features, features[len(bass) :], strict=False):
            agent._keep(mine)
            agent._partner_history = [*agent._partner_history, partners][-agent.spec.obs_horizon :]

    @staticmethod
    def decide_many(
        agents: Sequence["PolicyAgent"], states: Sequence[WorldState], histories: Singles
    ) -> Sequence[Singles]:
        """What `decide` of each would return: one batch samples all candidates, another simulates all rollouts."""
        bass = [agent for agent in agents if isinstance(agent, BassAgent)]
        candidates = [
            (own, agent.guesses(partner, state))
            for agent, state, (own, partner) in zip(bass, states, candidates_of(bass, states, histories), strict=True)
        ]
        joints = [
            joint_chunks(agent.episode.seat, acting(own), acting(guesses), agent.selection)
            for agent, (own, guesses) in zip(bass, candidates, strict=True)
        ]
        predicted = type(bass[0]).simulate_many(bass, states, joints)
        views = [(agent.episode.map, agent.episode.seat) for agent in bass]
        scores = score_rollouts(views, joints, predicted, bass[0].selection, bass[0].value)
        return [
            agent._chosen(own, guesses, choice_from_scores(each, rollouts, agent.selection))
            for agent, (own, guesses), each, rollouts in zip(bass, candidates, scores, predicted, strict=True)
        ]

    @staticmethod
    def simulate_many(
        agents: Sequence["BassAgent"], states: Sequence[WorldState], joints: Sequence[Floats]
    ) -> Sequence[Floats]:
        """Predicted states of each agent's joint chunks, in one batch of the learned simulator."""
        counts = [len(joint) for joint in joints]
        starts = np.stack([moving(state) for state in states]).astype(np.float32)
        constants = np.stack([constant(agent.episode.map) for agent in agents]).astype(np.float32)
        dynamics = agents[0].dynamics
        assert dynamics is not None
        predicted: Floats = dynamics(
            state=np.repeat(starts, counts, axis=0),
            constant=np.repeat(constants, counts, axis=0),
            actions=np.concatenate(joints).astype(np.float32),
        )[0]
        return np.split(predicted, np.cumsum(counts)[:-1])

    def simulator(self, state: WorldState) -> Simulator:
        """The learned simulator, started in a state."""
        return lambda joint: self.simulate_many([self], [state], [joint])[0]

    def _views(self, history: Singles) -> Singles:
        """(own + partner, To, D): the own observation per own candidate, the partner's per predicted chunk."""
        missing = self.spec.obs_horizon - len(self._partner_history)
        theirs = np.stack([self._partner_history[0]] * missing + self._partner_history)
        counts = self.selection.own, self.selection.partner
        return np.concatenate(
            [np.repeat(seen[None], n, axis=0) for seen, n in zip((history, theirs), counts, strict=True)]
        )

    def _noises(self) -> tuple[Singles, Singles]:
        """Noise for the own candidates and for the partner's chunks; only the own noise grows at a standstill."""
        return self.noise(self.selection.own), self.network.noise(self.selection.partner, self.random)

    def guesses(self, partner: Singles, state: WorldState) -> Singles:
        """The predicted chunks of the partner (partner, H, 5): what this policy would do in its place."""
        return partner

    def _chosen(self, own: Singles, guesses: Singles, choice: Choice) -> Singles:
        self.detail = self._trace(own, guesses, choice)
        chunk: Singles = own[choice.index]
        return chunk

    def _trace(self, own: Singles, guesses: Singles, choice: Choice) -> dict[str, object]:
        """The trace for recordings and spectators (docs/looking-at-recordings.md); about 3 KB."""
        depth = choice.predicted.shape[1]
        robots = robot_places(choice.predicted[:, [depth // 2 - 1, depth - 1]])  # (R, 2, 2, 2)
        items = item_places(choice.predicted[:, -1], len(self.episode.map.items))  # (R, N, 2)
        _, first = np.unique(choice.pairs[:, 0], return_index=True)  # the first rollout of each candidate
        return {
            "chosen": choice.index,
            "scores": _rounded(choice.scores, 4),
            "candidates": _rounded(own[:, :, :3], 2),
            "guesses": _rounded(guesses[:, :, :3], 2),
            "pairs": choice.pairs.tolist(),
            "robots": _rounded(robots, 2),
            "items": _rounded(items[first], 2),
        }


def _rounded(numbers: Floats | Singles, decimals: int) -> object:
    """As nested lists with few decimals; single precision would be written with sixteen digits."""
    return np.round(numbers.astype(np.float64), decimals).tolist()


def acting(chunks: Singles) -> Floats:
    """Chunks (B, H, 5) in the form of the simulator (B, H, 4): distance, unit heading, grasp 0 or 1."""
    acting = np.empty((*chunks.shape[:-1], 4))
    acting[..., 0] = np.clip(chunks[..., 0], -1.0, 1.0)
    norms = np.maximum(np.linalg.norm(chunks[..., 1:3], axis=-1, keepdims=True), 1e-3)
    acting[..., 1:3] = chunks[..., 1:3] / norms
    acting[..., 3] = chunks[..., 4] > chunks[..., 3]
    return acting


def candidates_of(
    agents: Sequence[BassAgent], states: Sequence[WorldState], histories: Singles
) -> list[tuple[Singles, Singles]]:
    """Each agent's own chunks (own, H, 5) and the partner's (partner, H, 5), all sampled in one batch.

    The partner's come from the same policy in the partner's place. The chunks of a deterministic policy are perturbed.
    """
    views = [agent._views(history) for agent, history in zip(agents, histories, strict=True)]
    noises = [agent._noises() for agent in agents]
    noise = np.concatenate([part for both in noises for part in both])
    flips = [flip for agent, seen in zip(agents, views, strict=True) for flip in agent.flips(len(seen))]
    chunks = sampled(agents[0].network, np.concatenate(views), noise, agents[0].mirror, flips)
    each = np.split(chunks, np.cumsum([len(view) for view in views])[:-1])
    parts = [
        (mine[: agent.selection.own], mine[agent.selection.own :]) for agent, mine in zip(agents, each, strict=True)
    ]
    if agents[0].spec.own_frame:
        parts = [
            (_turned(mine, state, agent.episode.seat), _turned(theirs, state, 1 - agent.episode.seat))
            for agent, state, (mine, theirs) in zip(agents, states, parts, strict=True)
        ]
    if agents[0].network.noise_rows:
        return parts
    return [
        (spread(mine, noise), spread(theirs, guessed))
        for (mine, theirs), (noise, guessed) in zip(parts, noises, strict=True)
    ]


def _turned(chunks: Singles, state: WorldState, seat: int) -> Singles:
    """Chunks (B, H, 5) relative to the angle of a seat, with headings of the arena."""
    return turned(chunks, np.full(len(chunks), state.robot_poses[seat, 2]))


def spread(chunks: Singles, noise: Singles) -> Singles:
    """Different candidates from equal chunks (B, H, 5), given standard normal noise (B, rows, H, 5).

    The first candidate stays the policy's own. The others get another speed and direction for the whole chunk: noise
    drawn per tick would average out. Grasping is unchanged, as random releases would drop items. The paper does not
    say how it draws candidates from its GRU (Appendix "Ablation Study").
    """
    moved = chunks.copy()
    norms = np.maximum(np.linalg.norm(chunks[1:, :, 1:3], axis=-1, keepdims=True), np.float32(1e-3))
    moved[1:, :, 1:3] /= norms
    moved[1:, :, :3] += np.float32(SPREAD) * noise[1:, 0, :1, :3]
    moved[1:, :, 1:3] /= np.maximum(np.linalg.norm(moved[1:, :, 1:3], axis=-1, keepdims=True), np.float32(1e-3))
    return moved


class RandomPartnerBassAgent(BassAgent):
    """The ablation with random partner chunks (paper, "Effect of Random Partner Actions")."""

    def guesses(self, partner: Singles, state: WorldState) -> Singles:
        return self.random.uniform(-1.0, 1.0, partner.shape).astype(np.float32)


class SingleAgentBassAgent(BassAgent):
    """The ablation that simulates its own actions alone (paper, "Comparison with Single Agent BASS").

    The partner is taken to stand still and to keep what it holds.
    """

    def guesses(self, partner: Singles, state: WorldState) -> Singles:
        seat = 1 - self.episode.seat
        angle, holds = state.robot_poses[seat, 2], self.spec.grasp == "hold" and state.held[seat] >= 0
        yes = 1.0 if holds else -1.0
        still: Singles = np.broadcast_to(
            np.array([0.0, np.cos(angle), np.sin(angle), -yes, yes], dtype=np.float32), partner.shape
        )
        return still
