"""Handing jobs to workers, wherever they run, and getting along without those that die or fall silent.

A job of a lost worker is played again, each of its unfinished matches alone; a match that loses its worker three times
is lost, with the reason. Results are the same whoever plays.
"""

from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

from movingout.matches.errors import MatchError
from movingout.matches.match import Match, MatchResult, lost

ATTEMPTS = 3
LARGEST_JOB = 64


@dataclass(frozen=True, slots=True)
class News:
    """Something a worker has to say."""

    worker: int
    kind: Literal["result", "done", "died", "stop"]
    result: MatchResult | None = None
    reason: str = ""


class Crew(Protocol):
    """Workers, numbered; each plays one job at a time."""

    size: int

    def send(self, worker: int, matches: Sequence[Match]) -> None:
        """Let a worker play; one that died is replaced first."""

    def news(self) -> News:
        """Wait for what happens next."""

    def close(self) -> None:
        """Send everybody home at once."""


@dataclass(slots=True)
class Job:
    """Matches for one worker."""

    unfinished: dict[Match, None]
    attempt: int = 1


@dataclass(slots=True)
class _Desk:
    """Who works on what."""

    waiting: deque[Job]
    running: dict[int, Job] = field(default_factory=dict)


def jobs_of(matches: Sequence[Match], workers: int) -> list[Job]:
    """Matches in jobs: large enough for company in lock-step, small enough that all workers finish together."""
    size = max(1, min(LARGEST_JOB, -(-len(matches) // (4 * workers))))
    return [Job(dict.fromkeys(matches[start : start + size])) for start in range(0, len(matches), size)]


def dispatch(crew: Crew, matches: Sequence[Match]) -> Generator[MatchResult, None, None]:
    """All results as they come. Raises MatchError when a worker says that going on makes no sense (a full disk)."""
    desk = _Desk(deque(jobs_of(matches, crew.size)))
    try:
        for worker in range(crew.size):
            _next_job(crew, desk, worker)
        while desk.running:
            news = crew.news()
            job = desk.running[news.worker]
            if news.kind == "stop":
                raise MatchError(news.reason)
            if news.result is not None:
                job.unfinished.pop(news.result.match, None)
                yield news.result
            elif news.kind == "died":
                yield from _again(desk, job, news.reason)
            if news.kind in ("done", "died"):
                del desk.running[news.worker]
                for worker in set(range(crew.size)) - desk.running.keys():
                    _next_job(crew, desk, worker)
    finally:
        crew.close()


def _next_job(crew: Crew, desk: _Desk, worker: int) -> None:
    if desk.waiting:
        job = desk.waiting.popleft()
        desk.running[worker] = job
        crew.send(worker, list(job.unfinished))


def _again(desk: _Desk, job: Job, reason: str) -> list[MatchResult]:
    """Queue the unfinished matches of a lost worker, each alone; give up those that were lost too often."""
    if job.attempt >= ATTEMPTS:
        return [lost(match, f"lost its worker process {ATTEMPTS} times: {reason}") for match in job.unfinished]
    desk.waiting += [Job({match: None}, job.attempt + 1) for match in job.unfinished]
    return []
