"""What a seat of an agent takes of a core and of the memory: the figures of `movingout cluster plan`.

Options: `--agents ID ...`, `--maps NAME ...`, `--ticks N` (150). CPU time of this process alone, so that other programs
count little; each agent is measured in a process of its own, beside an idle partner. Memory is that of a process with
one agent, and what each further one adds.
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

from bench import print_table
from bench.memory import resident_mb
from movingout.agents.base import ActionChunk, Agent, Observation, Wrapper
from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.baseline.timed_agent import TimedAgent
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.maps import load_map
from movingout.world.constants import TICK_SECONDS

AGENTS = ("idle", "scripted", "dp@any", "bass@any")
MAPS = ("HandOff", "LeftRight", "PriorityPick")
MORE = 8  # seats beside the first one, for the memory of each


class AgentCost(NamedTuple):
    """Of one seat."""

    decision_ms: float  # CPU
    decisions_per_s: float  # of the game
    core_share: float
    first_mb: float  # a process with one seat
    further_mb: float  # each seat more


class CpuTimed(Wrapper):
    """An agent whose decisions are timed on the CPU clock of this process."""

    def __init__(self, agent: Agent) -> None:
        super().__init__(TimedAgent(agent))
        self.seconds, self.decisions = 0.0, 0

    def act(self, observation: Observation) -> ActionChunk:
        begun = time.process_time()
        chunk = self.agent.act(observation)
        self.seconds += time.process_time() - begun
        self.decisions += 1
        return chunk


def main(options: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench agents", description=__doc__)
    parser.add_argument("--agents", nargs="+", default=AGENTS, metavar="ID")
    parser.add_argument("--maps", nargs="+", default=MAPS, metavar="NAME")
    parser.add_argument("--ticks", type=int, default=150)
    args = parser.parse_args(options)
    rows = []
    for agent_id in args.agents:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
            found = process.submit(cost, agent_id, tuple(args.maps), args.ticks).result()
        rows.append([agent_id, f"{found.decision_ms:.2f}", f"{found.decisions_per_s:.1f}", f"{found.core_share:.4f}",
                     f"{found.first_mb:.0f}", f"{found.further_mb:.1f}"])  # fmt: skip
    columns = ["agent", "CPU ms a decision", "decisions/s", "share of a core", "MB, first seat", "MB, each more"]
    print_table(f"A seat of an agent on {', '.join(args.maps)}", columns, rows)


def cost(agent_id: str, maps: tuple[str, ...], ticks: int) -> AgentCost:
    """Measured in this process."""
    played, timed = 0, CpuTimed(load_agent(agent_id))
    for number, name in enumerate(maps):
        played += sum(1 for _ in rollout(load_map(name), (timed, IdleAgent()), seed=number, ticks=ticks))
    first = resident_mb()
    seats = [CpuTimed(load_agent(agent_id)) for _ in range(MORE)]
    for seat in seats:
        for _ in rollout(load_map(maps[0]), (seat, IdleAgent()), seed=0, ticks=min(ticks, 20)):
            pass
    further = max(0.0, resident_mb() - first) / MORE
    seconds = played * TICK_SECONDS
    return AgentCost(
        decision_ms=1e3 * timed.seconds / timed.decisions,
        decisions_per_s=timed.decisions / seconds,
        core_share=timed.seconds / seconds,
        first_mb=first,
        further_mb=further,
    )
