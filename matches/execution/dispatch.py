"""Hands out matches to workers, wherever they run, and replaces workers that die or stop answering.

The unfinished matches of a lost worker are played again, each as a job of its own. A match that loses its worker three
times has failed, with the reason. Results do not depend on which worker plays.
"""

from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

from movingout.matches.errors import MatchError
from movingout.matches.match import Match, MatchResult, failed_result

ATTEMPTS = 3
LARGEST_JOB = 64  # matches
SHARES_PER_WORKER = 4  # of what is left


@dataclass(frozen=True, slots=True)
class WorkerMessage:
    """A result, the end of a job, the death of a worker, or a reason to stop the whole run."""

    worker: int
    kind: Literal["result", "done", "died", "stop"]
    result: MatchResult | None = None
    reason: str = ""


class WorkerPool(Protocol):
    """Numbered workers; each plays one job at a time."""

    size: int

    def send(self, worker: int, matches: Sequence[Match]) -> None:
        """Start a job; a worker that died is replaced first."""

    def next_message(self) -> WorkerMessage:
        """Wait for the next message of any worker."""

    def close(self) -> None:
        """Stop all workers at once."""


@dataclass(slots=True)
class MatchJob:
    """Matches for one worker."""

    unfinished: dict[Match, None]
    attempt: int = 1


@dataclass(slots=True)
class JobQueue:
    """The jobs of a run that are not finished."""

    waiting: deque[MatchJob]
    running: dict[int, MatchJob] = field(default_factory=dict)  # by worker


def split_into_jobs(matches: Sequence[Match], workers: int) -> list[MatchJob]:
    """Large jobs first, which are played in batches, then smaller ones, so that workers finish at about the same time.

    Each job has a `SHARES_PER_WORKER * workers`-th of the matches that are left (guided self-scheduling).
    """
    jobs, start = [], 0
    while start < len(matches):
        size = min(LARGEST_JOB, -(-(len(matches) - start) // (SHARES_PER_WORKER * workers)))
        jobs.append(MatchJob(dict.fromkeys(matches[start : start + size])))
        start += size
    return jobs


def dispatch(pool: WorkerPool, matches: Sequence[Match]) -> Generator[MatchResult, None, None]:
    """Yield results as they arrive. Raises MatchError when a worker stops the run, as for a full disk."""
    queue = JobQueue(deque(split_into_jobs(matches, pool.size)))
    try:
        for worker in range(pool.size):
            _start_next_job(pool, queue, worker)
        while queue.running:
            message = pool.next_message()
            job = queue.running[message.worker]
            if message.kind == "stop":
                raise MatchError(message.reason)
            if message.result is not None:
                job.unfinished.pop(message.result.match, None)
                yield message.result
            elif message.kind == "died":
                yield from _retry(queue, job, message.reason)
            if message.kind in ("done", "died"):
                del queue.running[message.worker]
                for worker in set(range(pool.size)) - queue.running.keys():
                    _start_next_job(pool, queue, worker)
    finally:
        pool.close()


def _start_next_job(pool: WorkerPool, queue: JobQueue, worker: int) -> None:
    if queue.waiting:
        job = queue.waiting.popleft()
        queue.running[worker] = job
        pool.send(worker, list(job.unfinished))


def _retry(queue: JobQueue, job: MatchJob, reason: str) -> list[MatchResult]:
    """Queue each unfinished match of a lost worker as a job of its own; after the last attempt, fail them."""
    if job.attempt >= ATTEMPTS:
        return [failed_result(match, f"lost its worker process {ATTEMPTS} times: {reason}") for match in job.unfinished]
    queue.waiting += [MatchJob({match: None}, job.attempt + 1) for match in job.unfinished]
    return []
