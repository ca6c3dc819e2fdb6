"""Trained agents at play: onnxruntime and numpy on one thread, no torch.

A policy agent is asked every tick and decides every `execute` ticks; between decisions it plays the rest of its plan,
while the grasp follows what its hand really does.

A policy without memory that has come to a standstill decides the same again and again. With `restless` above 1 its
noise is wider then, until it moves: it tries what it would rarely do.
"""

from collections import deque
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import onnxruntime

from movingout.agents.base import THREADS, ActionChunk, EpisodeInfo, Observation
from movingout.agents.checkpoint.checkpoint import MODEL_ROOTS, Checkpoint, find_checkpoint
from movingout.agents.checkpoint.policy_spec import ACTION_WIDTH, PolicySpec
from movingout.agents.errors import AgentError, CheckpointError
from movingout.agents.hold import toggles
from movingout.agents.inference.device import providers
from movingout.agents.observation.features import FeatureEncoder, feature_encoder
from movingout.world.state import Floats, WorldState

Singles = npt.NDArray[np.float32]
STANDSTILL_TICKS = 20
STANDSTILL = 0.06  # [u] who keeps within this of where it is now, for so long, stands still


class Network:
    """An ONNX graph that runs on one thread, or on a GPU (agents.inference.device)."""

    def __init__(self, data: bytes) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = THREADS
        options.inter_op_num_threads = THREADS
        options.log_severity_level = 3
        where = providers()
        try:
            self._session = onnxruntime.InferenceSession(data, options, providers=where)
        except Exception as error:  # onnxruntime has no common base of its own errors
            raise CheckpointError(f"onnxruntime cannot load this network: {error}"[:300]) from error
        self._inputs = [argument.name for argument in self._session.get_inputs()]

    def __call__(self, **inputs: Singles) -> list[Any]:
        """The outputs for inputs by name, rows first; inputs that the graph does not have are left out.

        A row on its own is summed in another order than the same row beside others, and an agent must not play
        differently when it plays alone: so it is asked twice at once.
        """
        asked = {name: inputs[name] for name in self._inputs}
        if any(len(rows) != 1 for rows in asked.values()):
            return list(self._session.run(None, asked))
        twice = {name: np.concatenate((rows, rows)) for name, rows in asked.items()}
        return [rows[:1] for rows in self._session.run(None, twice)]


class PolicyNetwork:
    """A policy's network: observations in, chunks out."""

    def __init__(self, spec: PolicySpec, data: bytes) -> None:
        """Raises CheckpointError when the graph does not give what the spec says."""
        self.spec = spec
        self._network = Network(data)
        history = np.zeros((1, spec.obs_horizon, spec.features), dtype=np.float32)
        try:
            chunks = self.sample(history, np.random.default_rng(0))
        except Exception as error:  # a foreign graph may fail in any way that onnxruntime knows
            raise CheckpointError(f"the network does not take what its card says: {error}"[:300]) from error
        if chunks.shape != (1, spec.horizon, ACTION_WIDTH) or not np.isfinite(chunks).all():
            raise CheckpointError(f"the network answers with shape {chunks.shape}, not (1, {spec.horizon}, 5) numbers")

    def sample(self, history: Singles, random: np.random.Generator) -> Singles:
        """Chunks (B, H, 5) for observations (B, To, D), each from noise of its own."""
        return self.run(history, self.noise(len(history), random))

    def noise(self, count: int, random: np.random.Generator) -> Singles:
        """(count, rows, H, 5) for `run`."""
        spec = self.spec
        shape = (count, max(spec.noise_rows, 1), spec.horizon, ACTION_WIDTH)
        drawn: Singles = random.standard_normal(shape, dtype=np.float32)
        return drawn

    def run(self, history: Singles, noise: Singles) -> Singles:
        """Chunks (B, H, 5) for observations (B, To, D) and noise (B, rows, H, 5); each row for itself, to the bit."""
        chunks: Singles = self._network(observation=history, noise=noise)[0]
        return chunks


@dataclass(frozen=True, slots=True)
class View:
    """A state as a seat sees it."""

    encoder: FeatureEncoder
    seat: int
    state: WorldState


def encoded(views: Sequence[View]) -> list[Singles]:
    """The features (D,) of each view, encoded together where map and seat are the same."""
    groups: dict[tuple[FeatureEncoder, int], list[int]] = {}
    for index, view in enumerate(views):
        groups.setdefault((view.encoder, view.seat), []).append(index)
    features: dict[int, Singles] = {}
    for (encoder, seat), group in groups.items():
        states = [views[index].state for index in group]
        rows = encoder.encode_arrays(
            np.stack([state.robot_poses for state in states]),
            np.stack([state.robot_velocities for state in states]),
            np.stack([state.held for state in states]),
            np.stack([state.item_poses for state in states]),
            seat,
        )  # (B, D)
        features |= zip(group, rows.astype(np.float32), strict=True)
    return [features[index] for index in range(len(views))]


@dataclass(slots=True)
class Plan:
    """A chosen chunk and the tick of its first row."""

    chunk: Singles  # (H, 5)
    tick: int


class PolicyAgent:
    """Plays one seat with a policy network."""

    execute_rows = 1  # asked every tick; rows beyond the first are there for a missed deadline

    def __init__(self, spec: PolicySpec, network: PolicyNetwork, execute: int = 0) -> None:
        """`execute`: ticks between decisions; 0 means what the card says. Raises AgentError for another number."""
        if type(execute) is not int or not 0 <= execute <= spec.horizon:
            raise AgentError(f"execute is a whole number of ticks from 1 to {spec.horizon}, not {execute}")
        self.spec = spec
        self.network = network
        self.execute = min(execute or spec.execute, spec.horizon)
        self.detail: dict[str, object] = {}
        self._history: list[Singles] = []
        self._trail: deque[Floats] = deque(maxlen=STANDSTILL_TICKS)
        self._plan: Plan | None = None

    def reset(self, episode: EpisodeInfo) -> None:
        """Begin an episode: prepare the map, forget the last one."""
        self.episode = episode
        self.encoder: FeatureEncoder = feature_encoder(episode.map, self.spec.layout)
        self.random = np.random.default_rng([episode.seed, episode.seat])
        self._history = []
        self._trail.clear()
        self._plan = None
        self.detail = {}

    def act(self, observation: Observation) -> ActionChunk:
        """The rest of the plan (h, 4), after deciding anew when its executed part is over."""
        due = self._is_due(observation)
        if due or self.spec.obs_horizon > 1:
            self._remember(observation)
        if due:
            self._plan = Plan(self.decide(observation.state, self._stacked()), observation.tick)
        return self._planned(observation)

    @property
    def batch_key(self) -> Hashable:
        """Agents with one network decide together (`agents.base.BatchAgent`)."""
        return id(self.network)

    @staticmethod
    def act_many(agents: Sequence["PolicyAgent"], observations: Sequence[Observation]) -> list[ActionChunk]:
        """What `act` of each would answer, the decisions of all made in one batch."""
        seen = list(zip(agents, observations, strict=True))
        deciding = [(agent, observation) for agent, observation in seen if agent._is_due(observation)]
        type(agents[0]).remember_many(seen if agents[0].spec.obs_horizon > 1 else deciding)
        if deciding:
            histories = np.stack([agent._stacked() for agent, _ in deciding])
            states = [observation.state for _, observation in deciding]
            chunks = type(agents[0]).decide_many([agent for agent, _ in deciding], states, histories)
            for (agent, observation), chunk in zip(deciding, chunks, strict=True):
                agent._plan = Plan(chunk, observation.tick)
        return [agent._planned(observation) for agent, observation in seen]

    def decide(self, state: WorldState, history: Singles) -> Singles:
        """Choose a chunk (H, 5) for observations (To, D)."""
        chunk: Singles = self.network.run(history[None], self.noise(1))[0]
        return chunk

    def noise(self, count: int) -> Singles:
        """(count, rows, H, 5) for decisions now."""
        drawn = self.network.noise(count, self.random)
        return drawn * np.float32(self.spec.restless) if self._stands_still() else drawn

    def _stands_still(self) -> bool:
        trail = np.array(self._trail)
        return len(trail) == STANDSTILL_TICKS and bool(
            np.linalg.norm(trail - trail[-1], axis=1).max(initial=0.0) < STANDSTILL
        )

    @staticmethod
    def decide_many(
        agents: Sequence["PolicyAgent"], states: Sequence[WorldState], histories: Singles
    ) -> Sequence[Singles]:
        """What `decide` of each would choose, for observations (B, To, D)."""
        noise = np.concatenate([agent.noise(1) for agent in agents])
        return list(agents[0].network.run(histories, noise))

    @staticmethod
    def remember_many(seen: Sequence[tuple["PolicyAgent", Observation]]) -> None:
        """Take in what each sees."""
        views = [View(agent.encoder, agent.episode.seat, observation.state) for agent, observation in seen]
        for (agent, _), features in zip(seen, encoded(views), strict=True):
            agent._keep(features)

    def _is_due(self, observation: Observation) -> bool:
        """Whether it is time to decide anew; notes where one stands, forgets what was said of the last decision."""
        self._trail.append(observation.state.robot_poses[self.episode.seat, :2].copy())
        self.detail = {}
        return self._plan is None or not 0 <= observation.tick - self._plan.tick < self.execute

    def _planned(self, observation: Observation) -> ActionChunk:
        """The rest of the plan (h, 4)."""
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
        """Policy numbers (h, 5) as an agent's chunk (h, 4)."""
        return agent_rows(chunk, holding=holding, levels=self.spec.grasp == "hold")


def agent_rows(chunk: Singles, *, holding: bool, levels: bool) -> ActionChunk:
    """Policy numbers (h, 5) as an agent's chunk (h, 4): unit headings, toggles made from levels where they are that."""
    rows = np.empty((len(chunk), 4))
    rows[:, 0] = np.clip(chunk[:, 0], -1.0, 1.0)
    norms = np.hypot(chunk[:, 1], chunk[:, 2])
    rows[:, 1] = np.where(norms > 1e-3, chunk[:, 1] / np.maximum(norms, 1e-3), 1.0)
    rows[:, 2] = np.where(norms > 1e-3, chunk[:, 2] / np.maximum(norms, 1e-3), 0.0)
    wanted = chunk[:, 4] > chunk[:, 3]
    rows[:, 3] = toggles(wanted, holding) if levels else wanted
    return rows


@lru_cache(maxsize=4)
def _policy_network(spec: PolicySpec, data: bytes) -> PolicyNetwork:
    """One network for all agents of a process that have it."""
    return PolicyNetwork(spec, data)


def agent_of(checkpoint: Checkpoint, execute: int = 0, **variant: str) -> PolicyAgent:
    """The agent of a checkpoint, its files verified. `variant` is for BASS, see `agents.bass.agent.bass_agent`."""
    card = checkpoint.card
    network = _policy_network(card.policy, checkpoint.read("policy.onnx"))
    if card.kind == "bass":
        from movingout.agents.bass.agent import bass_agent

        return bass_agent(checkpoint, network, execute, **variant)
    if variant:
        raise AgentError(f"{card.id} chooses among nothing; only agents of kind bass take {', '.join(variant)}")
    return PolicyAgent(card.policy, network, execute)


def trained_agent(
    agent_id: str, execute: int = 0, simulator: str = "", partner: str = "", sampling: str = "", score: str = ""
) -> PolicyAgent:
    """The agent `agent_id` from the user's models or from those that come with the project, with its options."""
    options = {"simulator": simulator, "partner": partner, "sampling": sampling, "score": score}
    variant = {name: str(value) for name, value in options.items() if value != ""}  # `sampling=4` comes as a number
    return agent_of(find_checkpoint(agent_id, *MODEL_ROOTS), execute, **variant)
