"""The cost of recording: CPU per tick during play, bytes per episode, and processing afterwards.

One episode is 500 ticks of two driving people, each sending inputs at 20 Hz; the red seat also reports ten
candidate paths twice a second, as a planning agent does. CPU times of this process; real time is 50 s an episode.
"""

import os
import statistics
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from bench import print_table
from movingout.maps import load_map
from movingout.recordings import (
    AgentDecision,
    EpisodeHeader,
    EpisodeWriter,
    InputSample,
    SeatInfo,
    TickRecord,
    browser_replay,
    finalise,
    read_episode,
    verify,
)
from movingout.recordings.exports import export
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.storage.index import Filter, list_recordings
from movingout.world import World
from movingout.world.constants import LIMIT_TICKS, TICK_SECONDS
from movingout.world.state import WorldState

TICKS = LIMIT_TICKS
ROUNDS = 5
EPISODE_S = TICKS * TICK_SECONDS
LISTED = 10_000
EXPORTED = 3
FORMATS = ("parquet", "csv", "lerobot", "robomimic", "official")
MAPS = ("HandOff", "AdaptiveAssist", "FourCorners")


def main() -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in MAPS:
            rounds = [measure(Path(folder), name, k) for k in range(ROUNDS)]
            rows.append([name, *(f"{statistics.median(values):,.3f}" for values in zip(*rounds, strict=True))])
        exporting = measure_exports(Path(folder), [Path(folder) / f"{MAPS[0]}-{k}.mcap" for k in range(EXPORTED)])
        listing = measure_listing(Path(folder), Path(folder) / f"{MAPS[0]}-0.mcap")
    rows.append(["to reach", "0.300", "", "500", "", "", "50", ""])
    columns = [
        "map",
        "ms per tick",
        "journal KiB",
        "file KiB",
        "finalise s",
        "read s",
        "verify x real time",
        "replay s",
    ]
    print_table(f"Recording {TICKS} ticks with two seats (CPU time, median of {ROUNDS})", columns, rows)
    print_table(
        f"Exporting {EXPORTED} episodes of {TICKS} ticks (wall time)", ["format", "s", "x real time"], exporting
    )
    print_table(f"A folder of {LISTED:,} recordings (wall time)", ["", "s", "to reach"], listing)


def measure(folder: Path, map_name: str, number: int) -> list[float]:
    """Write and use one episode; returns the columns of the table."""
    header, initial, ticks = played(map_name, f"{map_name}-{number}")
    writer = EpisodeWriter.create(folder, header, initial)
    writing = cpu_seconds(lambda: write(writer, ticks))
    journal = writer.close("time")
    journal_kib = journal.stat().st_size / 1024
    finishing = cpu_seconds(lambda: finalise(journal))
    path = folder / f"{header.episode_id}.mcap"
    return [
        writing / TICKS * 1e3,
        journal_kib,
        path.stat().st_size / 1024,
        finishing,
        cpu_seconds(lambda: read_episode(path)),
        EPISODE_S / cpu_seconds(lambda: verify(path)),
        cpu_seconds(lambda: browser_replay(path, 20000.0, 32768 / np.pi)),
    ]


def measure_exports(folder: Path, recordings: list[Path]) -> list[list[str]]:
    """Seconds to export episodes in each data format, library imports included."""
    rows = []
    for name in FORMATS:
        plan = ExportPlan(recordings, folder / f"export-{name}")
        seconds = wall_seconds(partial(export, name, plan))
        rows.append([name, f"{seconds:.2f}", f"{EXPORTED * EPISODE_S / seconds:,.0f}"])
    return rows


def measure_listing(folder: Path, recording: Path) -> list[list[str]]:
    """Seconds to index, list and filter a folder of links to one recording."""
    crowd = folder / "crowd"
    crowd.mkdir()
    for number in range(LISTED):
        os.link(recording, crowd / f"{number:05}.mcap")
    steps = {
        "index all (once)": (lambda: list_recordings(crowd), ""),
        "list all": (lambda: list_recordings(crowd), "1.0"),
        "filter": (lambda: list_recordings(crowd, Filter(map="LeftRight")), "1.0"),
    }
    return [[name, f"{wall_seconds(work):.2f}", reach] for name, (work, reach) in steps.items()]


def write(writer: EpisodeWriter, ticks: list[TickRecord]) -> None:
    """Write what a room would write during these ticks."""
    for tick in ticks:
        number = tick.state.tick
        for k in range(4):
            move, heading, _ = tick.actions[k % 2].tolist()
            writer.input(
                InputSample(number, k % 2, 2 * number + k // 2, 100.25 * number, move, heading, 3, "gamepad", 12.75)
            )
        if number % 5 == 0:
            writer.agent(AgentDecision(number, 1, 4.5, False, {"chosen": 3, "candidates": CANDIDATES}))
        writer.tick(tick)


def played(map_name: str, episode_id: str) -> tuple[EpisodeHeader, WorldState, list[TickRecord]]:
    """An episode of smooth random driving with occasional grasps."""
    spec = load_map(map_name)
    world = World(spec)
    random = np.random.default_rng(5)
    seats = (SeatInfo("human", "P-1", device="gamepad"), SeatInfo("agent", "bass@all"))
    header = EpisodeHeader(episode_id, spec, 5, TICKS, seats, time.time_ns(), "live")
    initial, heading, ticks = world.state(), random.uniform(-np.pi, np.pi, 2), []
    for _ in range(TICKS):
        heading += random.normal(0.0, 0.3, 2)
        actions = np.column_stack([random.uniform(0.2, 1.0, 2), heading, random.random(2) < 0.05])
        world.step(actions)
        delivered = tuple(world.delivered().tolist())
        ticks.append(TickRecord(actions, ("human", "agent"), (2 * world.tick, -1), world.state(), delivered, 0.08))
    return header, initial, ticks


def cpu_seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def wall_seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _candidates() -> list[dict[str, object]]:
    random = np.random.default_rng(6)
    return [
        {"score": float(s), "terms": random.random(2).tolist(), "x": random.random(8).tolist(), "y": [0.5] * 8}
        for s in random.random(10)
    ]


CANDIDATES = _candidates()
