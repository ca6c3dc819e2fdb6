"""Verification: the actions must follow from the raw inputs, and re-simulating them must give equal bits."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from movingout.recordings.episode import Episode, InputSample
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.versions import why_not_exact
from movingout.world import World
from movingout.world.state import WorldState

_FIELDS = ("robot_poses", "robot_velocities", "held", "item_poses")


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first value that the inputs do not explain, or that re-simulation does not reproduce."""

    tick: int
    field: str  # robot_poses[0, 1], delivered[2], ...
    recorded: float
    simulated: float

    def __str__(self) -> str:
        return f"tick {self.tick}, {self.field}: recorded {self.recorded!r}, simulated {self.simulated!r}"


@dataclass(frozen=True, slots=True)
class Verification:
    """The verdict on one recording."""

    path: Path
    ticks: int
    first_divergence: Divergence | None
    caveat: str  # why equal bits are not promised, empty when they are
    damage: str  # what the file itself says is missing

    @property
    def identical(self) -> bool:
        return self.first_divergence is None


def verify(path: Path) -> Verification:
    """Re-simulate a recording or a journal; RecordingError when it cannot be read."""
    episode = read_episode(path)
    found = [divergence for divergence in (first_unexplained(episode), first_divergence(episode)) if divergence]
    first = min(found, key=lambda divergence: divergence.tick, default=None)
    return Verification(path, len(episode.ticks), first, why_not_exact(episode.versions), episode.damage)


def first_unexplained(episode: Episode) -> Divergence | None:
    """The first action that differs from the raw input that it names, if any.

    A stick that was released is at rest; so is one whose last input came before play began or went on and is not
    recorded. Sequence numbers begin anew on each connection, so inputs of an earlier one explain nothing.
    """
    inputs = iter(episode.inputs)
    waiting = next(inputs, None)
    returns = [event for event in episode.events if event.kind == "return"]
    known: dict[tuple[int, int, int], InputSample] = {}  # by seat, connection and sequence number
    for tick in episode.ticks:
        while waiting is not None and waiting.tick <= tick.state.tick:
            known[waiting.seat, waiting.connection, waiting.seq] = waiting
            waiting = next(inputs, None)
        connections = Counter(event.seat for event in returns if event.tick <= tick.state.tick)
        for seat, (seq, action) in enumerate(zip(tick.input_seqs, tick.actions.tolist(), strict=True)):
            said = known.get((seat, connections[seat], seq))
            found = None if seq < 0 else _unexplained(f"actions[{seat}]", tick.state.tick, action, said)
            if found is not None:
                return found
    return None


def _unexplained(field: str, tick: int, action: list[float], said: InputSample | None) -> Divergence | None:
    distance, heading, _ = action
    if said is not None and heading != said.heading:
        return Divergence(tick, f"{field}.heading", heading, said.heading)
    move = 0.0 if said is None else said.move
    return Divergence(tick, f"{field}.distance", distance, move) if distance not in (0.0, move) else None


def first_divergence(episode: Episode) -> Divergence | None:
    """The first recorded state that differs from what the recorded actions lead to, if any."""
    world = World(episode.header.map, record_sub_poses=False)
    found = difference(episode.initial, world.state())
    for tick in episode.ticks:
        if found is not None:
            return found
        world.step(tick.actions)
        found = difference(tick.state, world.state())
        if found is None and tick.delivered != (now := tuple(world.delivered().tolist())):
            found = _first_unequal(tick.state.tick, "delivered", np.array(tick.delivered), np.array(now))
    return found


def difference(recorded: WorldState, simulated: WorldState) -> Divergence | None:
    """The first field and index in which two states are not equal to the bit."""
    if recorded.tick != simulated.tick:
        return Divergence(recorded.tick, "tick", recorded.tick, simulated.tick)
    for name in _FIELDS:
        one, other = getattr(recorded, name), getattr(simulated, name)
        if one.tobytes() != other.tobytes():
            return _first_unequal(recorded.tick, name, one, other)
    return None


def _first_unequal(tick: int, name: str, one: np.ndarray, other: np.ndarray) -> Divergence:
    if one.shape != other.shape:
        return Divergence(tick, f"{name}.shape", one.size, other.size)
    index = tuple(int(axis[0]) for axis in np.nonzero(_bits(one) != _bits(other)))
    return Divergence(tick, f"{name}[{', '.join(map(str, index))}]", float(one[index]), float(other[index]))


def _bits(values: np.ndarray) -> np.ndarray:
    """Values compared as bits, so that -0.0 differs from 0.0 here too."""
    return values.view(np.uint64) if values.dtype == np.float64 else values
