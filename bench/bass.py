"""How good the parts of BASS are, beside the paper's tables ("BASS Analysis"), on episodes it was not trained on.

    python -m bench.bass --agent bass@all --data data/demos-of-others

1. next state: L2 distance between predicted and true moving state, one tick ahead, and of saying "nothing moves";
2. partner prediction: share of the partner's actions predicted within 10 % and 20 % (relative error of distance, cos
   and sin together, of the mean of 4 samples, first action);
3. selection: how often the learned simulator and the engine choose the same of 4 candidates, and chance.
"""

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from agents.base import EpisodeInfo
from agents.bass.agent import BassAgent, acting, engine_simulator
from agents.bass.selection import choose
from agents.bass.state_vector import moving
from agents.catalogue import load_agent
from agents.corrections import SUFFIX, load_correction
from agents.dataset import Trajectory, read_trajectories, recording_files
from agents.features import feature_encoder
from agents.hold import toggles
from maps.errors import MovingOutError
from world import World
from world.state import Floats, WorldState

PAPER = {"next_state_l2": 0.0010, "partner_10": 0.7145, "partner_20": 0.9024, "selection": 0.6250}


@dataclass(frozen=True, slots=True)
class Numbers:
    """Means over the sampled moments; `n` of them."""

    next_state_l2: float
    nothing_moves_l2: float
    partner_10: float
    partner_20: float
    selection: float
    selection_told_apart: float  # the same, over moments in which the engine's scores differ at all
    n: int


def measure(agent: BassAgent, walks: list[Trajectory], moments: int, seed: int) -> Numbers:
    """Sample moments of episodes and compare."""
    random = np.random.default_rng(seed)
    rows: list[list[float]] = []
    for walk in walks:
        agent.reset(EpisodeInfo(walk.map, 0, seed, walk.ticks))
        last = walk.ticks - agent.selection.depth
        ticks = sorted(random.choice(max(last, 1), size=min(moments, max(last, 1)), replace=False).tolist())
        world = World(walk.map, record_sub_poses=False)
        for tick in ticks:
            while world.tick < tick:
                world.step(walk.actions[world.tick])
            rows.append(_moment(agent, walk, world, tick))
    table = np.array(rows)
    apart = table[:, 5] > 0
    means = table[:, :5].mean(axis=0).tolist()
    told_apart = float(table[apart, 4].mean()) if apart.any() else float("nan")
    return Numbers(means[0], means[1], means[2], means[3], means[4], told_apart, len(table))


def _moment(agent: BassAgent, walk: Trajectory, world: World, tick: int) -> list[float]:
    state = world.state()
    joint = np.zeros((1, agent.selection.depth, 2, 4))
    for seat in (0, 1):
        rows = slice(tick, tick + agent.selection.depth)
        distance, heading, _ = walk.actions[rows, seat].T
        level = walk.held[rows.start + 1 : rows.stop + 1, seat] >= 0
        joint[0, : len(distance), seat] = np.stack((distance, np.cos(heading), np.sin(heading), level), axis=1)
    if agent.spec.grasp != "hold":
        for seat in (0, 1):
            joint[0, :, seat, 3] = toggles(joint[0, :, seat, 3], holding=bool(state.held[seat] >= 0))
    after = moving(_after(walk, tick))
    predicted = agent.simulator(state)(joint)[0, 0]
    theirs = _samples(agent, walk, state, seat=1)
    mine = _samples(agent, walk, state, seat=0)
    actual = joint[0, 0, 1, :3]
    error = float(np.linalg.norm(theirs[:, 0, :3].mean(axis=0) - actual)) / max(float(np.linalg.norm(actual)), 1e-6)
    learned = choose(agent.judge, 0, mine, theirs, agent.simulator(state), agent.selection)
    truth = engine_simulator(world.snapshot(), levels=agent.spec.grasp == "hold")
    oracle = choose(agent.judge, 0, mine, theirs, truth, agent.selection)
    return [
        float(np.linalg.norm(predicted - after)),
        float(np.linalg.norm(moving(state) - after)),
        float(error < 0.1),
        float(error < 0.2),
        float(learned.index == oracle.index),
        float(np.ptp(oracle.scores)),
    ]


def _samples(agent: BassAgent, walk: Trajectory, state: WorldState, seat: int) -> Floats:
    """Four chunks (4, H, 4) from a seat's view; with a history, the present repeated."""
    seen = feature_encoder(walk.map, agent.spec.layout).encode(state, seat).astype(np.float32)
    history = np.tile(seen, (4, agent.spec.obs_horizon, 1))
    return acting(agent.network.sample(history, agent.random))


def _after(walk: Trajectory, tick: int) -> WorldState:
    return WorldState(
        tick + 1,
        walk.robot_poses[tick + 1],
        walk.robot_velocities[tick + 1],
        walk.held[tick + 1],
        walk.item_poses[tick + 1],
    )


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agent", default="bass@all")
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="recordings not used for training")
    parser.add_argument("--moments", type=int, default=10, help="per episode")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    agent = load_agent(args.agent)
    if not isinstance(agent, BassAgent):
        raise MovingOutError(f"{args.agent} is no agent of kind bass")
    files = recording_files(args.data, (".mcap", SUFFIX))
    labelled = [load_correction(file).trajectory for file in files if file.name.endswith(SUFFIX)]
    walks = labelled + read_trajectories([file for file in files if not file.name.endswith(SUFFIX)])
    numbers = asdict(measure(agent, walks, args.moments, args.seed))
    if args.json:
        print(json.dumps({"agent": args.agent, "ours": numbers, "paper": PAPER}))
        return
    print(f"| {args.agent} | ours | paper |\n|---|---|---|")
    for name, value in numbers.items():
        paper = f"{PAPER[name]:.4f}" if name in PAPER else ""
        print(f"| {name} | {value:.4f} | {paper} |")


if __name__ == "__main__":
    main()
