"""BASS at play: own candidates and predictions of the partner are simulated together, and the best one is played."""

from collections.abc import Hashable, Sequence

import numpy as np

from movingout.agents.base import EpisodeInfo, Observation
from movingout.agents.bass.score_functions import score_function, score_rollouts
from movingout.agents.bass.selection import Choice, Simulator, choice_from_scores, joint_chunks
from movingout.agents.bass.state_vector import constant, item_places, moving, robot_places
from movingout.agents.bass.value import Value
from movingout.agents.checkpoint.checkpoint import Checkpoint, SelectionSpec
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.inference.network import Network, PolicyNetwork, Singles, shared_network, shared_policy_network
from movingout.agents.inference.policy_agent import PolicyAgent, SeatView, encoded
from movingout.world import World
from movingout.world.physics import Snapshot
from movingout.world.state import Floats, WorldState

SPREAD = 0.3  # standard deviation of the noise on distance, cos and sin for deterministic policies


class BassAgent(PolicyAgent):
    """Any base policy with simulation and selection on top."""

    def __init__(
        self, spec: PolicySpec, network: PolicyNetwork, dynamics: Network, selection: SelectionSpec, execute: int = 0,
        value: Value | None = None,
    ) -> None:  # fmt: skip
        super().__init__(spec, network, execute)
        self.dynamics = dynamics
        self.selection = selection
        self.value = value
        self._partner_history: list[Singles] = []

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._partner_history = []
        self._constant = constant(episode.map).astype(np.float32)
        self.score_function = score_function(episode.map, episode.seat, self.selection, self.value)

    @property
    def batch_key(self) -> Hashable:
        """Agents that share network, simulator and selection decide together."""
        return id(self.network), id(self.dynamics), id(self.value and self.value.network), self.selection

    def decide(self, state: WorldState, history: Singles) -> Singles:
        """Sample, simulate, select; leaves the trace of the decision in `detail`."""
        chunk: Singles = self.decide_many([self], [state], history[None])[0]
        return chunk

    @staticmethod
    def remember_many(seen: Sequence[tuple[PolicyAgent, Observation]]) -> None:
        """Add each agent's and each partner's observation to the histories."""
        bass = [(agent, observation.state) for agent, observation in seen if isinstance(agent, BassAgent)]
        own = [SeatView(agent.encoder, agent.episode.seat, state) for agent, state in bass]
        theirs = [SeatView(agent.encoder, 1 - agent.episode.seat, state) for agent, state in bass]
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
            (own, agent.guesses(partner))
            for agent, (own, partner) in zip(bass, _candidates(bass, histories), strict=True)
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
        constants = np.stack([agent._constant for agent in agents])
        predicted: Floats = agents[0].dynamics(
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

    def guesses(self, partner: Singles) -> Singles:
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


def _candidates(agents: Sequence[BassAgent], histories: Singles) -> list[tuple[Singles, Singles]]:
    """Each agent's own chunks (own, H, 5) and the partner's (partner, H, 5), all sampled in one batch.

    The partner's come from the same policy in the partner's place. The chunks of a deterministic policy are perturbed.
    """
    views = [agent._views(history) for agent, history in zip(agents, histories, strict=True)]
    noises = [agent._noises() for agent in agents]
    chunks = agents[0].network.run(np.concatenate(views), np.concatenate([part for both in noises for part in both]))
    each = np.split(chunks, np.cumsum([len(view) for view in views])[:-1])
    parts = [
        (mine[: agent.selection.own], mine[agent.selection.own :]) for agent, mine in zip(agents, each, strict=True)
    ]
    if agents[0].network.noise_rows:
        return parts
    return [
        (spread(mine, noise), spread(theirs, guessed))
        for (mine, theirs), (noise, guessed) in zip(parts, noises, strict=True)
    ]


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

    def guesses(self, partner: Singles) -> Singles:
        return self.random.uniform(-1.0, 1.0, partner.shape).astype(np.float32)


class OracleBassAgent(BassAgent):
    """The upper bound: simulates exactly, with the engine. Needs access to the world, so only in headless matches."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._watched: World | None = None

    def watch(self, world: World) -> None:
        """Be given the world that is played in; called once per episode, before the first tick."""
        self._watched = world

    @staticmethod
    def simulate_many(
        agents: Sequence[BassAgent], states: Sequence[WorldState], joints: Sequence[Floats]
    ) -> Sequence[Floats]:
        """States predicted by the engine, from each agent's own world."""
        return [agent.simulator(state)(joint) for agent, state, joint in zip(agents, states, joints, strict=True)]

    def simulator(self, state: WorldState) -> Simulator:
        """The engine, started from the present state."""
        if self._watched is None:
            if state.tick > 0:
                raise AgentError("simulator=oracle needs the world itself; use it in headless matches only")
            learned = BassAgent.simulate_many  # the warm-up decision of a worker
            return lambda joint: learned([self], [state], [joint])[0]
        return engine_simulator(self._watched.snapshot(), levels=self.spec.grasp == "hold")


def engine_simulator(moment: Snapshot, *, levels: bool) -> Simulator:
    """The true world from a snapshot on; each rollout simulates the episode so far again (50 us per tick)."""

    def simulate(joint: Floats) -> Floats:
        return np.array([_engine_rollout(moment, chunk, levels) for chunk in joint])

    return simulate


def _engine_rollout(moment: Snapshot, chunk: Floats, levels: bool) -> Floats:
    """Moving states (depth, 58) of one joint chunk (depth, 2, 4)."""
    world = World(moment.map, record_sub_poses=False)
    world.restore(moment)
    rows = []
    for distance, cos, sin, grasp in np.moveaxis(chunk, -1, 1):
        press = grasp != (world.state().held >= 0) if levels else grasp
        world.step(np.column_stack((distance, np.arctan2(sin, cos), press)))
        rows.append(moving(world.state()))
    return np.array(rows)


SAMPLINGS = {
    "4": {"own": 4, "partner": 4, "combine": "independent"},
    "2x2": {"own": 2, "partner": 2, "combine": "product"},
    "4x4": {"own": 4, "partner": 4, "combine": "product"},
    "8x2": {"own": 8, "partner": 2, "combine": "product"},
}


def bass_agent(
    checkpoint: Checkpoint, execute: int = 0, simulator: str = "learned", partner: str = "policy",
    sampling: str = "", score: str = "",
) -> BassAgent:  # fmt: skip
    """The agent of a checkpoint of kind bass.

    Options for experiments: `simulator` learned or oracle, `partner` policy or random, `sampling` 4, 2x2, 4x4 or 8x2,
    `score` nfd, nfd+ac or value. The defaults are those of the card.
    """
    card = checkpoint.card
    if card.dynamics is None or card.selection is None:
        raise CheckpointError(f"checkpoint {card.id} is of kind bass but has no dynamics or selection")
    if card.selection.depth > card.network.horizon:
        raise CheckpointError(
            f"checkpoint {card.id} simulates {card.selection.depth} ticks, "
            f"but its policy predicts {card.network.horizon}"
        )
    variants = {
        ("learned", "policy"): BassAgent,
        ("learned", "random"): RandomPartnerBassAgent,
        ("oracle", "policy"): OracleBassAgent,
    }
    if (simulator, partner) not in variants:
        raise AgentError(
            f"{card.id}: simulator=learned or oracle, partner=policy or random, not {simulator}, {partner}"
        )
    if sampling and sampling not in SAMPLINGS:
        raise AgentError(f"{card.id}: sampling is one of {', '.join(SAMPLINGS)}, not {sampling}")
    if score not in ("", "nfd", "nfd+ac", "value"):
        raise AgentError(f"{card.id}: score is nfd, nfd+ac or value, not {score}")
    if score == "value" and card.value is None:
        raise AgentError(f"{card.id} has no value network; train it with --score value, or use score=nfd")
    changes = {**SAMPLINGS.get(sampling, {}), **({"score": score} if score else {})}
    selection = card.selection.model_copy(update=changes)
    network = shared_policy_network(card.network, checkpoint.read("policy.onnx"))
    dynamics = shared_network(checkpoint.read("dynamics.onnx"))
    value = Value(card.value, shared_network(checkpoint.read("value.onnx"))) if card.value else None
    return variants[simulator, partner](card.network, network, dynamics, selection, execute, value)
