"""How long an agent takes for a decision on this machine: asked before a round by a worker, and before a study begins

As a program (`agents/trial.py` starts it) it has the arguments AGENT MAP, and writes the milliseconds.
"""

import os
import statistics
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path

from movingout.agents.base import ActionChunk, Agent, EpisodeInfo
from movingout.agents.catalogue import load_live_agent
from movingout.agents.observation.seat_observation import observe, start_state
from movingout.agents.worker.parent_process import end_with_parent
from movingout.maps import MapSpec, MovingOutError, load_map
from movingout.world.constants import LIMIT_TICKS, TICK_SECONDS

DECISIONS = 5  # of a series
SERIES = 4  # at most: the best counts, so that a busy moment does not
LEAST = 2  # series before an agent is too slow
ENOUGH_S = 3.0  # after which no further series begins
_WAITED = Path("/proc/thread-self/schedstat")  # of Linux: processor time, time waited for a processor [ns], turns


def unhindered() -> float:
    """Seconds that pass without those in which this thread waits for a busy processor, where the system tells them.

    What an agent waits for otherwise counts: a GPU, other threads of its own.
    """
    now = time.perf_counter()
    try:
        return now - 1e-9 * int(_WAITED.read_bytes().split()[1])
    except OSError:
        return now


def first_decisions(agent: Agent, episode: EpisodeInfo, clock: Callable[[], float]) -> tuple[list[float], ActionChunk]:
    """The seconds of a few decisions, each the first of a fresh episode, and the last chunk, as the agent gave it."""
    seen = observe(episode.map, start_state(episode.map), episode.seat)
    times = []
    for _ in range(DECISIONS):
        agent.reset(episode)
        begun = clock()
        chunk = agent.act(seen)
        times.append(clock() - begun)
    return times, chunk


def median_decision_s(agent: Agent, the_map: MapSpec, clock: Callable[[], float] = unhindered) -> float:
    """The median decision [s] of the best of several short series; there is one series of an agent that keeps up."""
    episode = EpisodeInfo(the_map, seat=0, seed=0, ticks=LIMIT_TICKS)
    agent.reset(episode)
    agent.act(observe(the_map, start_state(the_map), episode.seat))  # the first one may be slow
    begun = clock()
    medians: list[float] = []
    while len(medians) < SERIES and (len(medians) < LEAST or clock() - begun < ENOUGH_S):
        medians.append(statistics.median(first_decisions(agent, episode, clock)[0]))
        if medians[-1] <= TICK_SECONDS:
            break
    return min(medians)


def main(agent_id: str, map_source: str) -> None:
    """Write the time; threads that the agent has started do not keep the process."""
    os.nice(10)  # as a worker: a server may be playing beside it
    end_with_parent()
    try:
        with redirect_stdout(sys.stderr):  # what the agent prints
            seconds = median_decision_s(load_live_agent(agent_id), load_map(map_source))
    except MovingOutError as error:
        sys.exit(f"movingout: {error}")
    sys.stdout.write(f"{1e3 * seconds}\n")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
