"""How accurate the parts of BASS are on episodes, as in the paper's "BASS Analysis". It plays blue; red is its partner.

1. next state: L2 distance between the predicted and the true moving state one tick ahead, and the share of all grasps
   and releases in these episodes that are predicted;
2. partner prediction: share of the partner's actions predicted within 10 % and 20 % (relative error over distance, cos
   and sin of the mean prediction, first action only);
3. selection: how often the learned simulator, given what the agent guesses of the partner, and the engine, given the
   policy's samples of the partner, choose the same candidate. The guesses are these samples unless the option
   `partner` of the agent's id says otherwise.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.agent import BassAgent, acting, spread
from movingout.agents.bass.engine_agent import OracleBassAgent, engine_simulator
from movingout.agents.bass.selection import choose
from movingout.agents.bass.state_vector import HELD_START, ITEMS_START, ROBOT_WIDTH, held_of, moving
from movingout.agents.data.dataset import Trajectory
from movingout.agents.grasp_encoding import toggles
from movingout.agents.inference.network import Singles
from movingout.agents.inference.policy_agent import SeatView, encoded
from movingout.world import World
from movingout.world.action import turned
from movingout.world.observation import ITEM_SLOTS
from movingout.world.state import Floats, WorldState

AGREE = 1e-9  # arena units or rad: what simulation may differ by from a recorded state that it explains


@dataclass(frozen=True, slots=True)
class BassAccuracy:
    """Means over `n` sampled moments."""

    next_state_l2: float
    nothing_moves_l2: float
    random_state_l2: float  # distance to another moment of the same episode
    poses_l2: float  # as next_state_l2, over poses alone
    nothing_moves_poses_l2: float
    partner_10: float
    partner_20: float
    selection: float
    hands: float  # share of all grasps and releases of the episodes, sampled or not
    selection_told_apart: float  # over moments in which the engine's scores differ
    selection_chance: float
    n: int


def bass_accuracy(agent: BassAgent, trajectories: list[Trajectory], moments: int, seed: int) -> BassAccuracy:
    """Compare predictions with what happened at `moments` random ticks of each episode: means."""
    values = moment_values(agent, trajectories, moments, seed)
    means = {
        name: float(np.mean([value for _, value in numbers])) if numbers else math.nan
        for name, numbers in values.items()
    }
    return BassAccuracy(**means, selection_chance=1 / agent.selection.own, n=len(values["selection"]))


_PER_MOMENT = (
    "next_state_l2", "nothing_moves_l2", "random_state_l2", "poses_l2", "nothing_moves_poses_l2", "partner_10",
    "partner_20", "selection",
)  # fmt: skip


def moment_values(
    agent: BassAgent, trajectories: list[Trajectory], moments: int, seed: int
) -> dict[str, list[tuple[str, float]]]:
    """What is averaged, by field of `BassAccuracy`: (episode, value) per moment, for `hands` per hand that changes.

    Moments of one episode are alike, so that an error has to take them together.
    """
    random, elsewhere = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    rows: list[tuple[str, list[float]]] = []
    hands: list[tuple[str, float]] = []
    for number, trajectory in enumerate(trajectories):
        episode = str(number)
        agent.reset(EpisodeInfo(trajectory.map, 0, seed, trajectory.ticks))
        last = trajectory.ticks - agent.selection.depth
        ticks = sorted(random.choice(max(last, 1), size=min(moments, max(last, 1)), replace=False).tolist())
        changes = set(np.flatnonzero((trajectory.held[1:] != trajectory.held[:-1]).any(axis=1)).tolist())
        for world, state in _moments(trajectory, sorted(changes.union(ticks))):
            if state.tick in changes:
                hands += [(episode, float(right)) for right in _hands(agent, trajectory, world, state)]
            if state.tick in ticks:
                other = moving(_state(trajectory, int(elsewhere.integers(trajectory.ticks + 1))))
                measured = _next_state(agent, trajectory, world, state, other)
                rows.append((episode, [*measured, *_choices(agent, trajectory, world, state)]))
    values = {name: [(episode, row[number]) for episode, row in rows] for number, name in enumerate(_PER_MOMENT)}
    values["hands"] = hands
    values["selection_told_apart"] = [(episode, row[-2]) for episode, row in rows if row[-1] > 0]
    return values


def _moments(trajectory: Trajectory, ticks: Sequence[int]) -> Iterator[tuple[World, WorldState]]:
    """The world at each of `ticks`, in order, and its state, both as recorded.

    The world is simulated. Imported episodes of another engine may drift from that; then it is made anew of the
    recorded state, since what followed there did not follow from ours.
    """
    world, reached = World(trajectory.map, record_sub_poses=False), 0
    for tick in ticks:
        for action in trajectory.actions[reached:tick]:
            world.step(action)
        reached, state, recorded = tick, replace(world.state(), tick=tick), _state(trajectory, tick)
        if _differ(state, recorded):
            world, state = World.from_state(trajectory.map, recorded), recorded
        yield world, state


def _differ(one: WorldState, other: WorldState) -> bool:
    pairs = (one.robot_poses, other.robot_poses), (one.item_poses, other.item_poses)
    same = all(np.allclose(mine, theirs, rtol=0.0, atol=AGREE) for mine, theirs in pairs)
    return not (same and np.array_equal(one.held, other.held))


def _hands(agent: BassAgent, trajectory: Trajectory, world: World, state: WorldState) -> list[bool]:
    """For each hand that changes in the next tick, whether the simulator predicts it."""
    if isinstance(agent, OracleBassAgent):
        agent.watch(world)
    predicted = agent.simulator(state)(_played(agent, trajectory, state))[0, :1]
    before, after = trajectory.held[state.tick], trajectory.held[state.tick + 1]
    right: list[bool] = (held_of(predicted)[0] == after)[before != after].tolist()
    return right


def _next_state(
    agent: BassAgent, trajectory: Trajectory, world: World, state: WorldState, other: Floats
) -> list[float]:
    """L2 errors of the prediction, of no motion and of the `other` state; over poses alone, of the first two."""
    if isinstance(agent, OracleBassAgent):
        agent.watch(world)
    now, after = moving(state), moving(_state(trajectory, state.tick + 1))
    predicted = agent.simulator(state)(_played(agent, trajectory, state))[0, 0]
    said = (predicted, now, other)
    poses = [_poses(row, len(trajectory.map.items)) for row in (after, predicted, now)]
    return [float(np.linalg.norm(row - after)) for row in said] + [
        float(np.linalg.norm(row - poses[0])) for row in poses[1:]
    ]


def _choices(agent: BassAgent, trajectory: Trajectory, world: World, state: WorldState) -> list[float]:
    """Whether the partner is predicted within 10 % and within 20 %, whether both simulators choose the same candidate,
    and the range of the engine's scores.
    """
    spec = agent.selection
    sampled = _samples(agent, trajectory, state, 1, spec.partner)
    guessed = acting(agent.guesses(sampled, state))
    mine = acting(_samples(agent, trajectory, state, 0, spec.own))
    actual = _played(agent, trajectory, state)[0, 0, 1, :3]
    error = float(np.linalg.norm(guessed[:, 0, :3].mean(axis=0) - actual)) / max(float(np.linalg.norm(actual)), 1e-6)
    learned = choose(agent.score_function, 0, mine, guessed, agent.simulator(state), spec)
    truth = engine_simulator(world.snapshot(), levels=agent.spec.grasp == "hold")
    oracle = choose(agent.score_function, 0, mine, acting(sampled), truth, spec)
    return [float(error < 0.1), float(error < 0.2), float(learned.index == oracle.index), float(np.ptp(oracle.scores))]


def _played(agent: BassAgent, trajectory: Trajectory, state: WorldState) -> Floats:
    """Actions (1, depth, 2, 4) of both seats from a state of an episode on, as input of the simulator."""
    joint = np.zeros((1, agent.selection.depth, 2, 4))
    rows = slice(state.tick, state.tick + agent.selection.depth)
    for seat in (0, 1):
        distance, heading, _ = trajectory.actions[rows, seat].T
        level = trajectory.held[rows.start + 1 : rows.stop + 1, seat] >= 0
        joint[0, : len(distance), seat] = np.stack((distance, np.cos(heading), np.sin(heading), level), axis=1)
        if agent.spec.grasp != "hold":
            joint[0, :, seat, 3] = toggles(joint[0, :, seat, 3], holding=bool(state.held[seat] >= 0))
    return joint


def _samples(agent: BassAgent, trajectory: Trajectory, state: WorldState, seat: int, count: int) -> Singles:
    """Chunks (count, H, 5) from a seat's view, as in play; the present observation fills the history."""
    first = max(0, state.tick - agent.features.memory_ticks)
    past = tuple(_state(trajectory, tick) for tick in range(first, state.tick + 1))
    seen = encoded([SeatView(agent.features, trajectory.map, seat, state, past)])[0]
    noise = agent.network.noise(count, agent.random)
    chunks = agent.network.run(np.tile(seen, (count, agent.spec.obs_horizon, 1)), noise)
    if agent.spec.own_frame:
        chunks = turned(chunks, np.full(count, state.robot_poses[seat, 2]))
    return chunks if agent.network.noise_rows else spread(chunks, noise)


def _state(trajectory: Trajectory, tick: int) -> WorldState:
    return WorldState(
        tick,
        trajectory.robot_poses[tick],
        trajectory.robot_velocities[tick],
        trajectory.held[tick],
        trajectory.item_poses[tick],
    )


def _poses(row: Floats, items: int) -> Floats:
    """Poses (2 + items, 4) of robots and items (x, y, cos and sin of the angle) from a moving state (58,)."""
    robots = row[:HELD_START].reshape(2, ROBOT_WIDTH)[:, :4]
    return np.concatenate((robots, row[ITEMS_START:].reshape(ITEM_SLOTS, 4)[:items]))
