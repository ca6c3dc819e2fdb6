"""What torch has once per process, its random numbers and its threads, as a policy in a seat has them for itself."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import torch

from movingout.agents.base import THREADS, EpisodeInfo


class TorchState:
    """The random numbers of one policy. Other matches, or a learner with settings of its own, may share the process."""

    def __init__(self) -> None:
        self._drawn = _seeded(0)

    def reset(self, episode: EpisodeInfo) -> None:
        """Start the random numbers of an episode."""
        self._drawn = _seeded(int(np.random.default_rng([episode.seed, episode.seat]).integers(2**31)))

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """In this block torch draws this policy's numbers, on one thread; afterwards it is as it was before."""
        threads = torch.get_num_threads()
        with torch.random.fork_rng(devices=[]):
            torch.set_rng_state(self._drawn)
            _use_threads(THREADS)
            try:
                yield
            finally:
                self._drawn = torch.get_rng_state()
                _use_threads(threads)


def _seeded(seed: int) -> torch.Tensor:
    return torch.Generator().manual_seed(seed).get_state()


def _use_threads(count: int) -> None:
    if torch.get_num_threads() != count:
        torch.set_num_threads(count)
