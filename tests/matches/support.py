"""Small agents and grids for tests of matches; workers load them as `tests.matches.support:Name`."""

import contextlib
import ctypes
import os
import signal
import time
from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path

import numpy as np

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.matches.experiment.grid import Grid

HERE = "tests.matches.support"


class Wanderer:
    """Drives to an item, grabs it now and then and drags it about: cheap, and different for every seed and seat."""

    def reset(self, episode: EpisodeInfo) -> None:
        self.random = np.random.default_rng([episode.seed, episode.seat])
        self.item = int(self.random.integers(len(episode.map.items)))

    def act(self, observation: Observation) -> ActionChunk:
        state, seat = observation.state, observation.seat
        away = state.item_poses[self.item, :2] - state.robot_poses[seat, :2]
        if state.held[seat] >= 0:
            away = self.random.normal(size=2)
        cos, sin = away[::-1] * (1.0, -1.0) / np.hypot(*away)
        return np.array([[1.0, cos, sin, float(self.random.random() < 0.3)], *[[1.0, cos, sin, 0.0]] * 3])


class Fleet(Wanderer):
    """The same, asked in batches."""

    sizes: list[int] = []  # noqa: RUF012  # of the batches, for a look from tests

    @property
    def batch_key(self) -> Hashable:
        return "fleet"

    @staticmethod
    def act_many(agents: Sequence["Fleet"], observations: Sequence[Observation]) -> Sequence[ActionChunk]:
        Fleet.sizes.append(len(agents))
        return [agent.act(seen) for agent, seen in zip(agents, observations, strict=True)]


class Keyless(Fleet):
    """Cannot say with whom it goes together."""

    @property
    def batch_key(self) -> Hashable:
        raise ValueError("no key")


class Stumbling(Fleet):
    """Fails in a match with an odd seed at tick 8, and with it the whole batch."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self.doomed = episode.seed % 2 == 1

    @staticmethod
    def act_many(agents: Sequence["Fleet"], observations: Sequence[Observation]) -> Sequence[ActionChunk]:
        for agent, seen in zip(agents, observations, strict=True):
            if seen.tick >= 8 and isinstance(agent, Stumbling) and agent.doomed:
                raise ValueError("I fell")
        return Fleet.act_many(agents, observations)


class Listed(Fleet):
    """Says with whom it goes together by what cannot be hashed."""

    @property
    def batch_key(self) -> Hashable:
        return ["fleet"]  # type: ignore[return-value]


class Interrupting(Wanderer):
    """Raises what Ctrl-C raises."""

    def act(self, observation: Observation) -> ActionChunk:
        raise KeyboardInterrupt


class Rowless(Wanderer):
    """Does not know how many of its rows are to be played."""

    execute_rows = None


class Talker(Wanderer):
    """Says when it was asked."""

    def act(self, observation: Observation) -> ActionChunk:
        self.detail: dict[str, object] = {"heard": observation.tick}
        return super().act(observation)


class Asking(Wanderer):
    """Waits for somebody at the keyboard, as one with a forgotten `breakpoint()` does."""

    def act(self, observation: Observation) -> ActionChunk:
        input()
        return super().act(observation)


class Counting(Wanderer):
    """Counts things, not all of them in whole numbers."""

    episode_counts: Mapping[str, object] = {"questions": np.int64(4), "useful": 1, "share": 0.25}


class Absent(Wanderer):
    """Cannot say whether it played."""

    @property
    def not_played(self) -> str:
        raise ValueError("no account")


class Mumbler(Wanderer):
    """Says what no file can hold."""

    def act(self, observation: Observation) -> ActionChunk:
        self.detail = {"self": self}
        return super().act(observation)


class Late(Wanderer):
    """Never comes to an end at tick 8, and swallows every exception."""

    def act(self, observation: Observation) -> ActionChunk:
        while observation.tick == 8:
            with contextlib.suppress(Exception):  # as bad as it gets
                sum(range(1000))
        return super().act(observation)


class Crashing(Wanderer):
    """Takes its process with it at tick 4, always in matches with an odd seed."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self.doomed = episode.seed % 2 == 1

    def act(self, observation: Observation) -> ActionChunk:
        if observation.tick >= 4 and self.doomed:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().act(observation)


class Slow(Wanderer):
    """Takes its time, so that there is a middle in which something can go wrong."""

    def act(self, observation: Observation) -> ActionChunk:
        time.sleep(0.01)
        return super().act(observation)


class Deaf(Wanderer):
    """Hangs outside of Python: no signal handler gets its turn, whichever thread of the process the signal reaches."""

    def act(self, observation: Observation) -> ActionChunk:
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
        ctypes.PyDLL(None).sleep(1000)
        raise AssertionError("was not ended")


def small_grid(**changes: object) -> Grid:
    """Two wanderers on two maps, 3 seeds, 60 ticks: 24 matches that take a moment."""
    document: dict[str, object] = {
        "name": "small",
        "agents": [f"{HERE}:Wanderer", "idle"],
        "maps": ["DistancePriority", "FourCorners"],
        "seeds": 3,
        "ticks": 60,
    }
    return Grid.model_validate(document | changes)


def written(folder: Path, text: str) -> Path:
    """A grid file."""
    path = folder / "grid.yaml"
    path.write_text(text, encoding="utf-8")
    return path
