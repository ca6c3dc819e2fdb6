"""How accurate the parts of BASS are, beside the paper's tables ("BASS Analysis"), on episodes not used for training.

    python -m bench.bass --agents bass@all:score=nfd,sampling=4x4 bass@all --challenge 1

What is measured is said in agents/bass/accuracy.py.

Without --data, pairs from population C play one episode on each map; in Challenge 2, on variants whose items occur in
no training map.
"""

import argparse
import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from bench.results.bass_tables import role, tables
from movingout.agents.bass.accuracy import bass_accuracy
from movingout.agents.bass.agent import BassAgent
from movingout.agents.catalogue import load_agent
from movingout.agents.data.corrections import SUFFIX, load_correction
from movingout.agents.data.dataset import Trajectory, read_trajectories, recording_files
from movingout.agents.data.held_out import held_out_episodes
from movingout.maps.errors import MovingOutError
from movingout.world.constants import LIMIT_TICKS


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
            name: asdict(bass_accuracy(agent, trajectories, args.moments, args.seed)) for name, agent in agents.items()
        }
    except MovingOutError as error:
        parser.error(str(error))
    if args.json:
        print(json.dumps({"challenge": args.challenge, "agents": measured}))
    else:
        print(tables(measured, {name: role(name, agent) for name, agent in agents.items()}, args.challenge))


if __name__ == "__main__":
    main()
