"""Workers as actors of a Ray cluster (extra `cluster`). Each keeps its loaded agents and returns results job by job.

An actor that is lost with its node is replaced elsewhere and its job is played again (`dispatch`). Every node needs
this package, the agents' checkpoints and, for recordings, a folder that all nodes share.
"""

import os
import sys
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from movingout.agents.checkpoint.checkpoint import MODELS_VARIABLE, own_models
from movingout.maps.errors import MovingOutError
from movingout.matches.errors import MatchError
from movingout.matches.execution.dispatch import WorkerMessage, WorkerPool
from movingout.matches.execution.lockstep import Lockstep
from movingout.matches.match import Match, match_from_json, match_to_json, result_from_json
from movingout.recordings.ray_cluster import NoCluster, connect, processors, ray_module


class RayWorker:
    """The actor, which plays jobs. Its arguments and results are plain JSON values, never our classes."""

    def __init__(self, paths: list[str], models: str, agent_limit_s: float, record: str) -> None:
        sys.path += [path for path in paths if path not in sys.path]
        os.environ[MODELS_VARIABLE] = models
        self._lockstep = Lockstep(record=Path(record) if record else None, agent_limit_s=agent_limit_s)

    def play(self, matches: list[dict[str, Any]]) -> list[dict[str, Any]] | str:
        """The results, or a sentence that says why the run must stop."""
        try:
            return [result.to_json() for result in self._lockstep.play([match_from_json(one) for one in matches])]
        except MovingOutError as error:
            return str(error)


class RayWorkerPool:
    """A `WorkerPool` of actors."""

    def __init__(self, size: int, agent_limit_s: float, record: Path | None) -> None:
        self._ray = ray_module()
        self.size = min(size, cluster_processors())  # an actor beyond these would wait for ever
        paths = [path or str(Path.cwd()) for path in (*sys.path, "")]
        self._settings = (paths, own_models(), agent_limit_s, "" if record is None else str(record.resolve()))
        self._actors: dict[int, Any] = {}
        self._jobs: dict[Any, int] = {}  # worker by object reference
        self._inbox: deque[WorkerMessage] = deque()
        self._lost = False

    def send(self, worker: int, matches: Sequence[Match]) -> None:
        if worker not in self._actors:
            # Replacements reserve no processor: the one of a lost node is gone, and waiting for it would never end.
            actor = self._ray.remote(num_cpus=0 if self._lost else 1, scheduling_strategy="SPREAD")(RayWorker)
            self._actors[worker] = actor.remote(*self._settings)
        self._jobs[self._actors[worker].play.remote([match_to_json(match) for match in matches])] = worker

    def next_message(self) -> WorkerMessage:
        while not self._inbox:
            (done,), _ = self._ray.wait(list(self._jobs), num_returns=1)
            self._read(done, self._jobs.pop(done))
        return self._inbox.popleft()

    def close(self) -> None:
        for actor in self._actors.values():
            self._ray.kill(actor)
        self._actors.clear()

    def _read(self, done: Any, worker: int) -> None:
        try:
            answer = self._ray.get(done)
        except self._ray.exceptions.RayError as error:
            self._actors.pop(worker)
            self._lost = True
            first = str(error).strip().splitlines()[0]
            self._inbox.append(WorkerMessage(worker, "died", reason=f"the Ray actor was lost: {first}"[:300]))
            return
        if isinstance(answer, str):
            self._inbox.append(WorkerMessage(worker, "stop", reason=answer))
            return
        self._inbox += [WorkerMessage(worker, "result", result_from_json(one)) for one in answer]
        self._inbox.append(WorkerMessage(worker, "done"))


def ray_worker_pool(address: str) -> Callable[[int, float, Path | None], WorkerPool]:
    """Connect to a cluster: `auto` is the one that runs here. Raises MatchError when there is none."""
    try:
        connect(address)
    except NoCluster as error:
        raise MatchError(str(error)) from error
    return RayWorkerPool


def cluster_processors() -> int:
    """Processors of the connected cluster."""
    return processors()
