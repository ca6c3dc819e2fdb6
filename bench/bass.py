"""How accurate the parts of BASS are, beside the paper's tables ("BASS Analysis"), on episodes not used for training.

    python -m bench.bass --agents bass@all:score=nfd,sampling=4x4 bass@all --challenge 1

1. next state: L2 distance between the predicted and the true moving state one tick ahead, and the share of all grasps
   and releases in these episodes that are predicted;
2. partner prediction: share of the partner's actions predicted within 10 % and 20 % (relative error over distance, cos
   and sin of the mean prediction, first action only);
3. selection: how often the learned simulator and the engine, given the same predictions of the partner, choose the
   same candidate.

Without --data, pairs from population C play one episode on each map; in Challenge 2, on variants whose items occur in
no training map.
"""

import argparse
import json
import math
import os
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from bench.results.bass_tables import role, tables
from movingout.agents.base import EpisodeInfo
from movingout.agents.bass.agent import BassAgent, OracleBassAgent, acting, engine_simulator, spread
from movingout.agents.bass.selection import choose
from movingout.agents.bass.state_vector import HELD_START, ITEMS_START, ROBOT_WIDTH, held_of, moving
from movingout.agents.catalogue import load_agent
from movingout.agents.data.corrections import SUFFIX, load_correction
from movingout.agents.data.dataset import Trajectory, read_trajectories, recording_files
from movingout.agents.data.demonstrations import episode_jobs, write_all
from movingout.agents.grasp_encoding import toggles
from movingout.agents.inference.network import Singles
from movingout.agents.scripted.populations import population
from movingout.maps import load_map, map_names
from movingout.maps.errors import MovingOutError
from movingout.maps.randomize import randomize
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS
from movingout.world.observation import ITEM_SLOTS, encoder
from movingout.world.state import Floats, WorldState


@dataclass(frozen=True, slots=True)
class Numbers:
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


def measure(agent: BassAgent, trajectories: list[Trajectory], moments: int, seed: int) -> Numbers:
    """Compare predictions with what happened at `moments` random ticks of each episode."""
    random, elsewhere = np.random.default_rng(seed), np.random.default_rng([seed, 1])
    rows: list[list[float]] = []
    hands: list[bool] = []
    for trajectory in trajectories:
        agent.reset(EpisodeInfo(trajectory.map, 0, seed, trajectory.ticks))
        last = trajectory.ticks - agent.selection.depth
        ticks = sorted(random.choice(max(last, 1), size=min(moments, max(last, 1)), replace=False).tolist())
        changes = set(np.flatnonzero((trajectory.held[1:] != trajectory.held[:-1]).any(axis=1)).tolist())
        world = World(trajectory.map, record_sub_poses=False)
        for tick in sorted(changes.union(ticks)):
            while world.tick < tick:
                world.step(trajectory.actions[world.tick])
            if tick in changes:
                hands += _hands(agent, trajectory, world)
            if tick in ticks:
                other = moving(_state(trajectory, int(elsewhere.integers(trajectory.ticks + 1))))
                rows.append([*_next_state(agent, trajectory, world, other), *_choices(agent, trajectory, world)])
    table = np.array(rows)
    apart = table[:, -1] > 0
    told_apart = float(table[apart, -2].mean()) if apart.any() else math.nan
    means = table[:, :-1].mean(axis=0).tolist()
    rest = float(np.mean(hands)) if hands else math.nan, told_apart, 1 / agent.selection.own, len(table)
    return Numbers(*(*means, *rest))


def _hands(agent: BassAgent, trajectory: Trajectory, world: World) -> list[bool]:
    """For each hand that changes in the next tick, whether the simulator predicts it."""
    state = world.state()
    if isinstance(agent, OracleBassAgent):
        agent.watch(world)
    predicted = agent.simulator(state)(_played(agent, trajectory, state))[0, :1]
    before, after = trajectory.held[state.tick], trajectory.held[state.tick + 1]
    right: list[bool] = (held_of(predicted)[0] == after)[before != after].tolist()
    return right


def _next_state(agent: BassAgent, trajectory: Trajectory, world: World, other: Floats) -> list[float]:
    """L2 errors of the prediction, of no motion and of the `other` state; over poses alone, of the first two."""
    state = world.state()
    if isinstance(agent, OracleBassAgent):
        agent.watch(world)
    now, after = moving(state), moving(_state(trajectory, world.tick + 1))
    predicted = agent.simulator(state)(_played(agent, trajectory, state))[0, 0]
    said = (predicted, now, other)
    poses = [_poses(row, len(trajectory.map.items)) for row in (after, predicted, now)]
    return [float(np.linalg.norm(row - after)) for row in said] + [
        float(np.linalg.norm(row - poses[0])) for row in poses[1:]
    ]


def _choices(agent: BassAgent, trajectory: Trajectory, world: World) -> list[float]:
    """Whether the partner is predicted within 10 % and within 20 %, whether both simulators choose the same candidate,
    and the range of the engine's scores.
    """
    state, spec = world.state(), agent.selection
    sampled = _samples(agent, trajectory, state, 1, spec.partner)
    guessed = acting(agent.guesses(sampled))
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
    seen = encoder(trajectory.map, agent.spec.layout).encode(state, seat).astype(np.float32)
    noise = agent.network.noise(count, agent.random)
    chunks = agent.network.run(np.tile(seen, (count, agent.spec.obs_horizon, 1)), noise)
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


def held_out_episodes(challenge: int, ticks: int, workers: int) -> list[Trajectory]:
    """One episode per map by ten pairs of C in turn; in Challenge 2, on variants that nobody is trained on."""
    maps = [load_map(name) for name in map_names()]
    if challenge == 2:
        maps = [randomize(the_map, 0, "evaluation") for the_map in maps]
    people = population("C")
    todo = []
    for number, the_map in enumerate(maps):
        pair = [people[(2 * number + k) % len(people)] for k in (0, 1)]
        if number // 2 % 2:  # the first of a pair follows; swapping puts leaders in both seats
            pair.reverse()
        todo += episode_jobs(pair, [the_map], 1, ticks, seed=0, prefix="parts")
    with tempfile.TemporaryDirectory() as folder:
        list(write_all(todo, Path(folder), workers))
        return read_trajectories(recording_files([Path(folder)]))


def recorded_episodes(places: Sequence[Path], challenge: int) -> list[Trajectory]:
    """Read recordings and label files. Raises DataError; MovingOutError for maps of the other challenge."""
    files = recording_files(places, (".mcap", SUFFIX))
    labelled = [load_correction(file).trajectory for file in files if file.name.endswith(SUFFIX)]
    trajectories = labelled + read_trajectories([file for file in files if not file.name.endswith(SUFFIX)])
    for trajectory in trajectories:
        if bool(trajectory.map.variant) != (challenge == 2):
            kind = "a variant" if trajectory.map.variant else "as designed"
            raise MovingOutError(f"a recording has {trajectory.map.name} {kind}, which is not Challenge {challenge}")
    return trajectories


def bass_agent_of(agent_id: str) -> BassAgent:
    """Load a BASS agent. Raises AgentError if it is unknown, MovingOutError if it is of another kind."""
    agent = load_agent(agent_id)
    if not isinstance(agent, BassAgent):
        raise MovingOutError(f"{agent_id} is not a BASS agent: it has no simulator and no candidates")
    return agent


def main(words: Sequence[str] | None = None) -> None:
    """Parse, measure and print; exit with a message if that is impossible."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", nargs="+", default=["bass@all"], metavar="ID")
    parser.add_argument("--challenge", type=int, choices=(1, 2), default=1, help="which figures of the paper to show")
    parser.add_argument(
        "--data", type=Path, nargs="+", help="recordings not used for training (default: play new episodes)"
    )
    parser.add_argument("--moments", type=int, default=10, help="sampled moments per episode")
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="length limit of new episodes")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args(words)
    if min(args.moments, args.ticks, args.workers) < 1 or args.seed < 0:
        parser.error("--moments, --ticks and --workers must be at least 1, --seed at least 0")
    try:
        agents = {agent_id: bass_agent_of(agent_id) for agent_id in args.agents}
        if args.data:
            trajectories = recorded_episodes(args.data, args.challenge)
        else:
            trajectories = held_out_episodes(args.challenge, args.ticks, args.workers)
        measured = {
            name: asdict(measure(agent, trajectories, args.moments, args.seed)) for name, agent in agents.items()
        }
    except MovingOutError as error:
        parser.error(str(error))
    if args.json:
        print(json.dumps({"challenge": args.challenge, "agents": measured}))
    else:
        print(tables(measured, {name: role(name, agent) for name, agent in agents.items()}, args.challenge))


if __name__ == "__main__":
    main()
