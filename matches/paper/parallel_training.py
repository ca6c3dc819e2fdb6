"""Several agents of the tables trained at a time, each in a process of its own, after those that it is made of.

Each training has one thread: small networks gain little from more of them, and its numbers are then the same however
many run beside it.
"""

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool

from movingout.matches.errors import MatchError
from movingout.matches.paper.methods import TrainedId, trained_before
from movingout.matches.paper.training import train_agent
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.process_pool import process_pool

OnTrained = Callable[[TrainedId, float], None]
"""Called with an agent that has been trained, and the processor time [s] that it took."""


def train_agents(agents: Sequence[TrainedId], space: Workspace, on_trained: OnTrained) -> None:
    """Train agents, each after those that it is made of; as many at a time as the workspace says.

    When one fails, or at Ctrl-C, the others are ended as well: their resume files are there, and they are continued the
    next time. Raises what `train_agent` raises, and MatchError where a process was killed.
    """
    waiting = list(agents)
    running: dict[Future[float], TrainedId] = {}
    with process_pool(min(space.at_once, len(waiting))) as pool:
        try:
            while waiting or running:
                unfinished = {*waiting, *running.values()}
                ready = [agent for agent in waiting if unfinished.isdisjoint(trained_before(agent))]
                for agent in ready[: space.at_once - len(running)]:
                    waiting.remove(agent)
                    running[pool.submit(_train, agent, space)] = agent
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    on_trained(running.pop(future), future.result())
        except BaseException as error:  # Ctrl+C, too: no training goes on without us
            for process in multiprocessing.active_children():
                process.terminate()
            if isinstance(error, BrokenProcessPool):
                raise MatchError(
                    "a training was killed, probably because there was no memory left; run the same command again to "
                    "continue, with fewer --workers"
                ) from error
            raise


def _train(agent: TrainedId, space: Workspace) -> float:
    """In a process of its own: the processor time [s]."""
    begun = sum(os.times()[:4])
    train_agent(agent, space, shows_itself=False)
    return sum(os.times()[:4]) - begun
