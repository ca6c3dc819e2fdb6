"""Episodes of an agent with partners, to compare partners: all of them play on the same maps, seats and seeds."""

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass

from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.catalogue import load_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.maps import load_map
from movingout.maps.errors import MovingOutError
from movingout.recordings.process_pool import process_pool
from movingout.world.metrics import task_completion_rate
from movingout.world.scoring import delivered_items


@dataclass(frozen=True, slots=True)
class Trial:
    """One episode: the agent, its partner, and where they play."""

    agent: str
    partner: str
    map: str
    seat: int  # the agent's
    seed: int
    ticks: int


@dataclass(frozen=True, slots=True)
class Occasion:
    """What all partners are tried on."""

    maps: tuple[str, ...]
    episodes: int  # with each partner
    ticks: int

    def trials(self, agent: str, partner: str, seed: int) -> list[Trial]:
        """The episodes with a partner: maps in turn, each in both seats by turns, another `seed` for each."""
        count = len(self.maps)
        return [
            Trial(agent, partner, self.maps[turn % count], sum(divmod(turn, count)) % 2, seed + turn, self.ticks)
            for turn in range(self.episodes)
        ]


def completion(trial: Trial) -> float:
    """The TCR of an episode. Raises AgentError for whatever an agent raises."""
    the_map = load_map(trial.map)
    mine = IdleAgent() if trial.agent == "idle" else load_agent(trial.agent)
    agents = mine, load_agent(trial.partner)
    try:
        last = None
        for step in rollout(the_map, agents if trial.seat == 0 else agents[::-1], trial.seed, trial.ticks):
            last = step.after
    except MovingOutError:
        raise
    except (Exception, SystemExit) as error:
        sentence = f"{trial.agent} with {trial.partner} on {trial.map}: {type(error).__name__}: {error}"
        raise AgentError(located(sentence, error)) from error
    assert last is not None, "an episode has at least one tick"
    return task_completion_rate(the_map, delivered_items(the_map, last.item_poses))


class Stage:
    """Plays trials, in worker processes where there are several."""

    def __init__(self, pool: Executor | None) -> None:
        self._pool = pool

    def completions(self, trials: Sequence[Trial]) -> list[float]:
        """The TCR of each."""
        if self._pool is None:
            with redirect_stdout(sys.stderr):  # what agents print, as from worker processes
                return [completion(trial) for trial in trials]
        return list(self._pool.map(completion, trials))


@contextmanager
def stage(workers: int) -> Iterator[Stage]:
    """A stage with so many processes. Raises AgentError for none."""
    if workers < 1:
        raise AgentError("--workers must be at least 1")
    if workers == 1:
        yield Stage(None)
        return
    with process_pool(workers) as pool:
        yield Stage(pool)
