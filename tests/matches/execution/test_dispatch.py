"""Matches are handed out so that no worker waits long for the last ones."""

import heapq
from collections.abc import Mapping, Sequence

import pytest

from movingout.matches.execution.dispatch import LARGEST_JOB, WorkerMessage, dispatch, split_into_jobs
from movingout.matches.match import Match, failed_result


class TimedPool:
    """Workers that take a given time for each match; `ends` says when each had played its last."""

    def __init__(self, size: int, seconds: Mapping[Match, float]) -> None:
        self.size = size
        self.ends = [0.0] * size
        self._seconds = seconds
        self._coming: list[tuple[float, int, int, Match | None]] = []
        self._sent = 0
        self._now = 0.0

    def send(self, worker: int, matches: Sequence[Match]) -> None:
        at = self._now
        for match in [*matches, None]:
            at += self._seconds[match] if match is not None else 0.0
            self._sent += 1
            heapq.heappush(self._coming, (at, self._sent, worker, match))

    def next_message(self) -> WorkerMessage:
        self._now, _, worker, match = heapq.heappop(self._coming)
        self.ends[worker] = self._now
        if match is None:
            return WorkerMessage(worker, "done")
        return WorkerMessage(worker, "result", failed_result(match, "not played"))

    def close(self) -> None:
        """Nothing runs."""


def _matches(count: int) -> list[Match]:
    return [Match("HandOff", "idle", "idle", seed) for seed in range(count)]


@pytest.mark.parametrize("workers", [2, 7])
def test_workers_end_within_two_matches_of_each_other(workers: int) -> None:
    matches = _matches(240)
    pool = TimedPool(workers, {match: 1.0 + match.seed % 3 for match in matches})
    assert len(list(dispatch(pool, matches))) == 240
    assert max(pool.ends) - min(pool.ends) <= 2 * 3.0
    assert sum(2.0 for _ in matches) / (workers * max(pool.ends)) > 0.95


def test_jobs_hold_every_match_once_and_the_first_are_batches() -> None:
    matches = _matches(2000)
    jobs = [list(job.unfinished) for job in split_into_jobs(matches, 4)]
    assert [match for job in jobs for match in job] == matches
    assert len(jobs[0]) == LARGEST_JOB and len(jobs[-1]) == 1
    assert split_into_jobs([], 4) == []
