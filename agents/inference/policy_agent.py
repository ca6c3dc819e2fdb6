"""Trained agents at play: onnxruntime and numpy on one thread, no torch.

A policy agent is asked every tick and decides every `execute` ticks. Between decisions it plays the rest of its chunk,
and its grasp toggles follow the actual state of its hand.

A policy without memory can get stuck at a standstill, where it keeps deciding the same. With `restless` above 1, its
sampling noise is scaled by that factor until it moves.
"""

from collections import deque
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from movingout.agents.agent_options import ticks_between_decisions
from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.checkpoint.policy_spec import PolicySpec
from movingout.agents.grasp_encoding import toggles
from movingout.agents.inference.mirror import FeatureMirror, sampled
from movingout.agents.inference.network import PolicyNetwork, Singles
from movingout.agents.observation.features import FeatureSet
from movingout.maps import MapSpec
from movingout.world.action import turned
from movingout.world.observation import encoder
from movingout.world.state import Floats, WorldState

STANDSTILL_TICKS = 20
STANDSTILL = 0.06  # [u] a robot that stayed within this distance for so long stands still


@dataclass(frozen=True, slots=True)
class SeatView:
    """A state to be encoded for a seat, and what came before it, oldest first."""

    features: FeatureSet
    map: MapSpec
    seat: int
    state: WorldState
    past: Sequence[WorldState] = ()


def encoded(views: Sequence[SeatView]) -> list[Singles]:
    """The features (D,) of each view; views of the same map are encoded together."""
    groups: dict[tuple[FeatureSet, MapSpec], list[int]] = {}
    for index, view in enumerate(views):
        groups.setdefault((view.features, view.map), []).append(index)
    features: dict[int, Singles] = {}
    for (seen, the_map), group in groups.items():
        picked = [views[index] for index in group]
        states, pasts, seats = zip(*((one.state, one.past, one.seat) for one in picked), strict=True)
        features |= zip(group, seen.of_moments(the_map, states, pasts, seats), strict=True)
    return [features[index] for index in range(len(views))]


@dataclass(slots=True)
class CurrentChunk:
    """A chosen chunk and the tick of its first row."""

    chunk: Singles  # (H, 5)
    tick: int


class PolicyAgent:
    """Plays one seat with a policy network."""

    execute_rows = 1  # asked every tick; rows beyond the first are there for a missed deadline

    def __init__(self, spec: PolicySpec, network: PolicyNetwork, execute: int = 0, mirrored: bool = False) -> None:
        """`execute`: ticks between decisions; 0 means as in the card. `mirrored`: see `agents.inference.mirror`.

        Raises AgentError when out of range, or for a layout without a mirror.
        """
        self.spec = spec
        self.network = network
        self.execute = min(ticks_between_decisions(execute, spec.horizon) or spec.execute, spec.horizon)
        self.detail: dict[str, object] = {}
        self.features = FeatureSet.of(spec)
        self.mirror = FeatureMirror(self.features) if mirrored else None
        self._history: list[Singles] = []
        self._past: deque[WorldState] = deque(maxlen=self.features.memory_ticks + 1)
        self._trail: deque[Floats] = deque(maxlen=STANDSTILL_TICKS)
        self._plan: CurrentChunk | None = None

    def reset(self, episode: EpisodeInfo) -> None:
        """Start an episode: prepare the map and forget the previous episode."""
        self.episode = episode
        encoder(episode.map, self.spec.layout)  # made now, because it takes a while
        self.random = np.random.default_rng([episode.seed, episode.seat])
        self._history = []
        self._past.clear()
        self._trail.clear()
        self._plan = None
        self.detail = {}

    def act(self, observation: Observation) -> ActionChunk:
        """The rest of the current chunk (h, 4); a new one is decided when `execute` ticks are over."""
        due = self._is_due(observation)
        if due or self.spec.obs_horizon > 1:
            self._remember(observation)
        if due:
            self._plan = CurrentChunk(self.decide(observation.state, self._stacked()), observation.tick)
        return self._planned(observation)

    @property
    def batch_key(self) -> Hashable:
        """Agents that share a network decide together (`agents.base.BatchAgent`)."""
        return id(self.network)

    @staticmethod
    def act_many(agents: Sequence["PolicyAgent"], observations: Sequence[Observation]) -> list[ActionChunk]:
        """What `act` of each would answer, with all decisions made in one batch."""
        seen = list(zip(agents, observations, strict=True))
        deciding = [(agent, observation) for agent, observation in seen if agent._is_due(observation)]
        type(agents[0]).remember_many(seen if agents[0].spec.obs_horizon > 1 else deciding)
        if deciding:
            histories = np.stack([agent._stacked() for agent, _ in deciding])
            states = [observation.state for _, observation in deciding]
            chunks = type(agents[0]).decide_many([agent for agent, _ in deciding], states, histories)
            for (agent, observation), chunk in zip(deciding, chunks, strict=True):
                agent._plan = CurrentChunk(chunk, observation.tick)
        return [agent._planned(observation) for agent, observation in seen]

    def decide(self, state: WorldState, history: Singles) -> Singles:
        """A chunk (H, 5) for observations (To, D)."""
        chunk: Singles = self.in_arena_frame(_sampled([self], history[None]), [state])[0]
        return chunk

    def in_arena_frame(self, chunks: Singles, states: Sequence[WorldState]) -> Singles:
        """Sampled chunks (B, H, 5) of this seat in states (B) with headings of the arena."""
        return _in_arena_frame([self] * len(chunks), chunks, states)

    def noise(self, count: int) -> Singles:
        """(count, rows, H, 5) for a decision in the present state."""
        drawn = self.network.noise(count, self.random)
        return drawn * np.float32(self.spec.restless) if self._stands_still() else drawn

    def flips(self, count: int) -> list[bool]:
        """Which of so many samples are drawn through the mirror."""
        return [self.mirror is not None and self.random.random() < 0.5 for _ in range(count)]

    def _stands_still(self) -> bool:
        trail = np.array(self._trail)
        return len(trail) == STANDSTILL_TICKS and bool(
            np.linalg.norm(trail - trail[-1], axis=1).max(initial=0.0) < STANDSTILL
        )

    @staticmethod
    def decide_many(
        agents: Sequence["PolicyAgent"], states: Sequence[WorldState], histories: Singles
    ) -> Sequence[Singles]:
        """What `decide` of each would return, for observations (B, To, D)."""
        return list(_in_arena_frame(agents, _sampled(agents, histories), states))

    @staticmethod
    def remember_many(seen: Sequence[tuple["PolicyAgent", Observation]]) -> None:
        """Add each agent's observation to its history."""
        views = [agent.view(observation.state, agent.episode.seat) for agent, observation in seen]
        for (agent, _), features in zip(seen, encoded(views), strict=True):
            agent._keep(features)

    def view(self, state: WorldState, seat: int) -> SeatView:
        """What a seat sees in the present state."""
        return SeatView(self.features, self.episode.map, seat, state, tuple(self._past))

    def _is_due(self, observation: Observation) -> bool:
        """Whether a new decision is due; also remembers the state and clears the last decision's trace."""
        self._trail.append(observation.state.robot_poses[self.episode.seat, :2].copy())
        self._past.append(observation.state)
        self.detail = {}
        return self._plan is None or not 0 <= observation.tick - self._plan.tick < self.execute

    def _planned(self, observation: Observation) -> ActionChunk:
        """The rest of the current chunk (h, 4)."""
        assert self._plan is not None
        rest = self._plan.chunk[observation.tick - self._plan.tick :]
        return self._world_rows(rest, holding=bool(observation.state.held[observation.seat] >= 0))

    def _remember(self, observation: Observation) -> None:
        self.remember_many([(self, observation)])

    def _keep(self, features: Singles) -> None:
        self._history = [*self._history[1 - self.spec.obs_horizon :], features] if self._history else [features]
        self._history = self._history[-self.spec.obs_horizon :]

    def _stacked(self) -> Singles:
        missing = self.spec.obs_horizon - len(self._history)
        return np.stack([self._history[0]] * missing + self._history)

    def _world_rows(self, chunk: Singles, *, holding: bool) -> ActionChunk:
        """A policy's output (h, 5) as an agent's chunk (h, 4)."""
        return agent_rows(chunk, holding=holding, levels=self.spec.grasp == "hold")


def _sampled(agents: Sequence[PolicyAgent], histories: Singles) -> Singles:
    """A chunk of each agent (B, H, 5), for observations (B, To, D); its generator draws noise, then the mirror."""
    noise = np.concatenate([agent.noise(1) for agent in agents])
    flips = [flip for agent in agents for flip in agent.flips(1)]
    mirror = next((agent.mirror for agent in agents if agent.mirror), None)
    return sampled(agents[0].network, histories, noise, mirror, flips)


def _in_arena_frame(agents: Sequence[PolicyAgent], chunks: Singles, states: Sequence[WorldState]) -> Singles:
    """Chunks (B, H, 5), one of each agent, with headings of the arena."""
    if not agents[0].spec.own_frame:
        return chunks
    angles = [state.robot_poses[agent.episode.seat, 2] for agent, state in zip(agents, states, strict=True)]
    return turned(chunks, np.array(angles))


def agent_rows(chunk: Singles, *, holding: bool, levels: bool) -> ActionChunk:
    """A policy's output (h, 5) as an agent's chunk (h, 4): unit headings, and toggles from levels if `levels`."""
    rows = np.empty((len(chunk), 4))
    rows[:, 0] = np.clip(chunk[:, 0], -1.0, 1.0)
    norms = np.hypot(chunk[:, 1], chunk[:, 2])
    rows[:, 1] = np.where(norms > 1e-3, chunk[:, 1] / np.maximum(norms, 1e-3), 1.0)
    rows[:, 2] = np.where(norms > 1e-3, chunk[:, 2] / np.maximum(norms, 1e-3), 0.0)
    wanted = chunk[:, 4] > chunk[:, 3]
    rows[:, 3] = toggles(wanted, holding) if levels else wanted
    return rows
