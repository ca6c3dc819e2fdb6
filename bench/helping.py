"""Whether an agent comes to help: a patient partner takes one end of a heavy item and waits.

    python -m bench.helping --agents bass@all dp@all scripted idle --maps all --episodes 3

Each item that needs two is held once per seat and episode. The table counts how often the partner got hold of it (other
items may be in the way, and clearing them helps too), how often the agent took the other end, how soon, and how often
they delivered it within 500 ticks.
"""

import argparse
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from bench import print_table
from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.agents.scripted.perception import Perception
from movingout.agents.scripted.task_choice import TaskSelector
from movingout.agents.scripted.tasks.lift import Lift
from movingout.agents.scripted.tasks.task import Task
from movingout.maps import load_map
from movingout.maps.errors import MovingOutError
from movingout.maps.selection import HELP as MAPS_HELP
from movingout.maps.selection import selected_maps
from movingout.world.constants import LIMIT_TICKS, TICKS_PER_SECOND

PATIENCE = TICKS = LIMIT_TICKS


class Holder(ScriptedAgent):
    """A partner who delivers one heavy item and nothing else."""

    def __init__(self, item: int, seed: int) -> None:
        super().__init__(seed, patience=PATIENCE)
        self._wanted = item

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self._selector = _OneItem(episode, self, self._wanted)


class _OneItem(TaskSelector):
    def __init__(self, episode: EpisodeInfo, player: ScriptedAgent, item: int) -> None:
        super().__init__(episode.map, player.style)
        self._item = item

    def next_task(self, now: Perception, task: Task | None) -> Task | None:
        if isinstance(task, Lift):
            return task
        return self._lift(now, self._item)


class Held(NamedTuple):
    """One episode: a heavy item that the partner holds, and the seat of the agent."""

    agent: str
    map: str
    item: int
    seat: int  # the agent's
    seed: int


class Seen(NamedTuple):
    """The first tick of each event, -1 if it never happened."""

    held: int
    came: int
    home: int


def play(run: Held) -> Seen:
    """Play one episode until the item is delivered."""
    the_map, agent = load_map(run.map), load_agent(run.agent)
    holder = Holder(run.item, run.seed)
    seats = (agent, holder) if run.seat == 0 else (holder, agent)
    held = came = -1
    for step in rollout(the_map, seats, run.seed, TICKS):
        hands, tick = step.after.held == run.item, step.after.tick
        held = tick if held < 0 and hands[1 - run.seat] else held
        came = tick if came < 0 and hands.all() else came
        if came >= 0 and Perception(the_map, step.after, run.seat).delivered[run.item]:
            return Seen(held, came, tick)
    return Seen(held, came, -1)


def main(words: Sequence[str] | None = None) -> None:
    """Play and print a row per agent and map, and a total per agent."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--agents", nargs="+", default=["bass@all", "dp@all", "scripted", "idle"], metavar="ID")
    parser.add_argument("--maps", default="all", help=MAPS_HELP)
    parser.add_argument("--episodes", type=int, default=2, help="per item and seat")
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args(words)
    if min(args.episodes, args.workers) < 1:
        parser.error("--episodes and --workers must be at least 1")
    try:
        for agent in args.agents:
            load_agent(agent)
        maps = [load_map(name).name for name in selected_maps(args.maps)]
    except MovingOutError as error:
        raise SystemExit(f"helping: {error}") from error
    runs = [
        Held(agent, name, item, seat, seed)
        for agent in args.agents
        for name in maps
        for item, spec in enumerate(load_map(name).items)
        if spec.size != "small"
        for seat in (0, 1)
        for seed in range(args.episodes)
    ]
    with ProcessPoolExecutor(args.workers, mp_context=get_context("spawn")) as pool:
        seen = list(pool.map(play, runs))
    print_table(
        f"A patient partner at a heavy item, {TICKS} ticks, {args.episodes} episodes per item and seat",
        ["agent", "map", "held", "came", "wait median [s]", "home", "of"],
        rows(runs, seen),
    )


def rows(runs: Sequence[Held], seen: Sequence[Seen]) -> list[list[str]]:
    """A row per agent and map, and per agent over all maps."""
    groups: dict[tuple[str, str], list[Seen]] = defaultdict(list)
    for run, outcome in zip(runs, seen, strict=True):
        groups[run.agent, run.map].append(outcome)
        groups[run.agent, "all"].append(outcome)
    return [[*key, *_counted(groups[key])] for key in sorted(groups, key=lambda key: (key[0], key[1] == "all", key[1]))]


def _counted(outcomes: Sequence[Seen]) -> list[str]:
    waits = [(one.came - one.held) / TICKS_PER_SECOND for one in outcomes if one.came >= 0]
    return [
        str(sum(one.held >= 0 for one in outcomes)),
        str(len(waits)),
        f"{float(np.median(waits)):.1f}" if waits else "–",
        str(sum(one.home >= 0 for one in outcomes)),
        str(len(outcomes)),
    ]


if __name__ == "__main__":
    main()
