"""BASS at play: candidates for oneself and guesses of the partner, simulated together, the best one played."""

from collections.abc import Sequence

import numpy as np

from agents.base import EpisodeInfo, Observation
from agents.bass.selection import Choice, Simulator, choose
from agents.bass.state_vector import constant, item_places, moving
from agents.checkpoint import Checkpoint, SelectionSpec
from agents.errors import AgentError, CheckpointError
from agents.policy_spec import PolicySpec
from agents.serving import Network, PolicyAgent, PolicyNetwork, Singles
from world import World
from world.physics import Snapshot
from world.state import Floats, WorldState


class BassAgent(PolicyAgent):
    """Any base policy with simulation and selection on top."""

    def __init__(
        self, spec: PolicySpec, network: PolicyNetwork, dynamics: Network, selection: SelectionSpec, execute: int = 0
    ) -> None:
        super().__init__(spec, network, execute)
        self.dynamics = dynamics
        self.selection = selection
        self._partner_history: list[Singles] = []

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._partner_history = []
        self._constant = constant(episode.map).astype(np.float32)

    def _remember(self, observation: Observation) -> None:
        super()._remember(observation)
        seen = self.encoder.encode(observation.state, 1 - self.episode.seat).astype(np.float32)
        self._partner_history = [*self._partner_history, seen][-self.spec.obs_horizon :]

    def decide(self, state: WorldState, history: Singles) -> Singles:
        """Sample, simulate, select; what was weighed is left in `detail`."""
        own, partner = self._candidates(history)
        numbers = acting(np.concatenate((own, partner)))
        choice = choose(
            self.episode.map, self.episode.seat, numbers[: len(own)], numbers[len(own) :], self.simulator(state),
            self.selection,
        )  # fmt: skip
        self.detail = self._told(own, choice)
        chosen: Singles = own[choice.index]
        return chosen

    @staticmethod
    def remember_many(seen: Sequence[tuple[PolicyAgent, Observation]]) -> None:
        """Each for itself: it looks through the partner's eyes too."""
        for agent, observation in seen:
            agent._remember(observation)

    @staticmethod
    def decide_many(
        agents: Sequence["PolicyAgent"], states: Sequence[WorldState], histories: Singles
    ) -> Sequence[Singles]:
        """Each for itself: a decision is a batch already."""
        return [agent.decide(state, history) for agent, state, history in zip(agents, states, histories, strict=True)]

    def simulator(self, state: WorldState) -> Simulator:
        """The learned simulator, started in a state."""
        start = moving(state).astype(np.float32)

        def simulate(joint: Floats) -> Floats:
            count = len(joint)
            predicted: Floats = self.dynamics(
                state=np.broadcast_to(start, (count, len(start))),
                constant=np.broadcast_to(self._constant, (count, len(self._constant))),
                actions=joint.astype(np.float32),
            )[0]
            return predicted

        return simulate

    def _candidates(self, history: Singles) -> tuple[Singles, Singles]:
        """Chunks (own, H, 5) and (partner, H, 5): the same policy, for the partner in the partner's place."""
        missing = self.spec.obs_horizon - len(self._partner_history)
        theirs = np.stack([self._partner_history[0]] * missing + self._partner_history)
        counts = self.selection.own, self.selection.partner
        batch = np.concatenate(
            [np.repeat(seen[None], n, axis=0) for seen, n in zip((history, theirs), counts, strict=True)]
        )
        chunks = self.network.sample(batch, self.random)
        return chunks[: counts[0]], chunks[counts[0] :]

    def _told(self, own: Singles, choice: Choice) -> dict[str, object]:
        """Candidates, their scores and where the items would end, for the recording and the spectators."""
        count = len(self.episode.map.items)
        ends = item_places(choice.predicted[:, -1], count)
        first = [int(np.flatnonzero(choice.pairs[:, 0] == k)[0]) for k in range(len(own))]
        return {
            "chosen": choice.index,
            "scores": np.round(choice.scores, 4).tolist(),
            "candidates": np.round(own[:, :, :3], 2).tolist(),
            "items": np.round(ends[first], 3).tolist(),
        }


def acting(chunks: Singles) -> Floats:
    """Chunks (B, H, 5) as the simulator takes them (B, H, 4): distance, unit heading, grasp 0 or 1."""
    acting = np.empty((*chunks.shape[:-1], 4))
    acting[..., 0] = np.clip(chunks[..., 0], -1.0, 1.0)
    norms = np.maximum(np.linalg.norm(chunks[..., 1:3], axis=-1, keepdims=True), 1e-3)
    acting[..., 1:3] = chunks[..., 1:3] / norms
    acting[..., 3] = chunks[..., 4] > chunks[..., 3]
    return acting


class RandomPartnerBassAgent(BassAgent):
    """The ablation: the partner is expected to do anything (paper, "Effect of Random Partner Actions")."""

    def _candidates(self, history: Singles) -> tuple[Singles, Singles]:
        own, partner = super()._candidates(history)
        guesses = self.random.uniform(-1.0, 1.0, partner.shape).astype(np.float32)
        return own, guesses


class OracleBassAgent(BassAgent):
    """The upper bound: simulates with the engine itself, exactly. Needs to watch the world, so for headless matches."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._watched: World | None = None

    def watch(self, world: World) -> None:
        """Take notice of the world that is played in; called once per episode, before the first tick."""
        self._watched = world

    def simulator(self, state: WorldState) -> Simulator:
        """The engine, started at this very moment."""
        if self._watched is None:
            if state.tick > 0:
                raise AgentError("simulator=oracle needs the world itself; use it in headless matches only")
            return super().simulator(state)  # the warm-up decision of a worker
        return engine_simulator(self._watched.snapshot(), levels=self.spec.grasp == "hold")


def engine_simulator(moment: Snapshot, *, levels: bool) -> Simulator:
    """The true world from a moment on: each rollout simulates the episode so far again (50 us per tick)."""

    def simulate(joint: Floats) -> Floats:
        return np.array([_engine_rollout(moment, chunk, levels) for chunk in joint])

    return simulate


def _engine_rollout(moment: Snapshot, chunk: Floats, levels: bool) -> Floats:
    """(depth, 58) moving states of one joint chunk (depth, 2, 4)."""
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
}


def bass_agent(
    checkpoint: Checkpoint, network: PolicyNetwork, execute: int = 0, simulator: str = "learned",
    partner: str = "policy", sampling: str = "", score: str = "",
) -> BassAgent:  # fmt: skip
    """The agent of a checkpoint of kind bass.

    Options for experiments: `simulator` learned or oracle, `partner` policy or random, `sampling` 4, 2x2 or 4x4,
    `score` nfd or nfd+ac; what is not given is as in the card.
    """
    card = checkpoint.card
    if card.dynamics is None or card.selection is None:
        raise CheckpointError(f"checkpoint {card.id} is of kind bass but says nothing of dynamics or selection")
    if card.selection.depth > card.policy.horizon:
        raise CheckpointError(f"checkpoint {card.id} simulates {card.selection.depth} ticks of {card.policy.horizon}")
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
    if score not in ("", "nfd", "nfd+ac"):
        raise AgentError(f"{card.id}: score is nfd or nfd+ac, not {score}")
    changes = {**SAMPLINGS.get(sampling, {}), **({"score": score} if score else {})}
    selection = card.selection.model_copy(update=changes)
    dynamics = Network(checkpoint.read("dynamics.onnx"))
    return variants[simulator, partner](card.policy, network, dynamics, selection, execute)
