"""Small episodes for the tests of recordings: really simulated, with everything a file can hold."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, field, fields, is_dataclass
from itertools import count
from pathlib import Path

import numpy as np

from movingout.maps import load_map
from movingout.recordings import (
    AgentDecision,
    Episode,
    EpisodeHeader,
    EpisodeWriter,
    Event,
    InputSample,
    SeatInfo,
    TickRecord,
)
from movingout.recordings.episode import Outcome
from movingout.recordings.official_format import Json, official_state, recorder_steps
from movingout.world import World
from movingout.world.state import Floats

STARTED_NS = 1_790_000_000_000_000_000


@dataclass
class Played:
    """What was handed to a writer."""

    header: EpisodeHeader
    world: World
    random: np.random.Generator
    ticks: list[TickRecord] = field(default_factory=list)
    inputs: list[InputSample] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    decisions: list[AgentDecision] = field(default_factory=list)


def header(map_name: str = "HandOff", episode_id: str = "episode", **changes: object) -> EpisodeHeader:
    values: dict[str, object] = {
        "episode_id": episode_id,
        "map": load_map(map_name),
        "seed": 7,
        "limit_ticks": 500,
        "seats": (SeatInfo("human", "P-3f2a", device="gamepad"), SeatInfo("agent", "scripted", "ab" * 32)),
        "started_ns": STARTED_NS,
        "source": "live",
        "study": {"study_id": "pilot", "session": "s-17"},
    }
    return EpisodeHeader(**(values | changes))  # type: ignore[arg-type]


def clock() -> Iterator[int]:
    return count(STARTED_NS, 1_000_000)


def begin(
    folder: Path, map_name: str = "HandOff", episode_id: str = "episode", seed: int = 0, **changes: object
) -> tuple[EpisodeWriter, Played]:
    """A writer at the start of an episode, and the world beside it."""
    head = header(map_name, episode_id, **changes)
    world = World(head.map)
    writer = EpisodeWriter.create(folder, head, world.state(), clock=clock().__next__)
    return writer, Played(head, world, np.random.default_rng(seed))


def play(writer: EpisodeWriter, played: Played, ticks: int) -> None:
    """Record some ticks of random driving, with inputs, events and decisions."""
    for _ in range(ticks):
        play_tick(writer, played)


def play_tick(writer: EpisodeWriter, played: Played) -> None:
    number = played.world.tick + 1
    decision = AgentDecision(number, 1, 3.25, number % 7 == 0, detail(number))
    event = Event(number, "grab", seat=0, item=2, detail="said “null”")
    actions = random_actions(played.random)
    move, heading, _ = actions[0].tolist()
    sample = InputSample(number, 0, 2 * number, 16.7 * number, move, heading, number % 256, "gamepad", 11.5)
    played.world.step(actions)
    record = TickRecord(
        actions=actions,
        sources=("human", "agent"),
        input_seqs=(2 * number, -1),
        state=played.world.state(),
        delivered=tuple(played.world.delivered().tolist()),
        late_ms=0.125,
        slack_ms=(40.5, -1.0),
        rtt_ms=(11.5, -1.0),
    )
    writer.input(sample)
    writer.agent(decision)
    if number % 5 == 0:
        writer.event(event)
        played.events.append(event)
    writer.tick(record)
    played.inputs.append(sample)
    played.decisions.append(decision)
    played.ticks.append(record)


def detail(number: int) -> dict[str, object]:
    candidates = [{"score": 0.5, "terms": [0.1, 0.4], "x": [0.0, 0.1], "y": [1.0, 1.1]}] if number % 3 else []
    return {"chosen": 0, "candidates": candidates, "plan": "fetch"} if candidates else {}


def random_actions(random: np.random.Generator) -> Floats:
    grasp = (random.random(2) < 0.1).astype(np.float64)
    return np.column_stack([random.uniform(-1, 1, 2), random.uniform(-np.pi, np.pi, 2), grasp])


def record(folder: Path, ticks: int = 30, outcome: Outcome = "time", **start: object) -> tuple[Path, Played]:
    """A whole episode as a closed journal."""
    writer, played = begin(folder, **start)  # type: ignore[arg-type]
    play(writer, played, ticks)
    return writer.close(outcome), played


def not_counted(data: Path, *episodes: str) -> None:
    """The database of a study, beside DATA/recordings, in which these rounds are marked as invalid."""
    (data / "studies" / "mine").mkdir(parents=True)
    with closing(sqlite3.connect(data / "studies" / "mine" / "study.sqlite")) as database, database:
        database.execute("CREATE TABLE rounds (episode, unit, valid, outcome)")
        database.execute("CREATE TABLE participants (unit, keep)")
        database.executemany("INSERT INTO rounds VALUES (?, 1, 0, 'time')", ((name,) for name in episodes))


def plain(value: object) -> object:
    """A value that compares as a whole: arrays by their bytes."""
    if isinstance(value, np.ndarray):
        return (value.dtype.str, value.shape, value.tobytes())
    if is_dataclass(value) and not isinstance(value, type):
        return {entry.name: plain(getattr(value, entry.name)) for entry in fields(value)}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    return value


def assert_holds(episode: Episode, played: Played, ticks: int | None = None) -> None:
    """The episode holds exactly what was recorded in its first `ticks` ticks."""
    kept = len(played.ticks) if ticks is None else ticks
    start = World(played.header.map).state()
    assert episode.header == played.header
    assert plain(episode.initial) == plain(start)
    assert plain(episode.ticks) == plain(played.ticks[:kept])
    assert list(episode.inputs) == played.inputs[:kept]
    assert list(episode.decisions) == played.decisions[:kept]
    told = [event for event in episode.events if event.kind != "collision"]  # which the writer sees by itself
    assert told == [event for event in played.events if event.tick <= kept]


def evaluator_steps(episode: Episode) -> list[Json]:
    """The steps as the official evaluation saves them: like the recorder's, but states are after the action."""
    steps = recorder_steps(episode)
    for step, tick in zip(steps, episode.ticks, strict=True):
        step["states"] = official_state(episode.header.map, tick.state)
        step["blue_name"], step["red_name"] = "model_2", "model_1"  # the evaluator swaps them
    return steps
