"""`movingout doctor`: can this machine serve the game? One line per question, and what to do where the answer is no."""

import argparse
import importlib.metadata
import json
import platform
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from movingout.maps import load_map
from movingout.server.settings import Settings
from movingout.server.uvicorn_server import CannotListen, listen
from movingout.world import World
from movingout.world.constants import TICK_MS

DEFAULTS = Settings()
PINNED_PYMUNK = "6.11.1"
# Where blue is after PROBE_TICKS on HandOff, to the last bit, with the pinned engine on x86-64 Linux.
PROBE_TICKS = 60
PROBE_POSE = (0.09296550598054373, 0.16536406371550735, 6.555555555555555)
FREE_BYTES = 500e6
TICK_BUDGET_MS = 2.0


class Finding(NamedTuple):
    """One line of the report. `grade` is ok, note (works, but) or fault."""

    question: str
    grade: str
    sentence: str


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--port", type=int, default=DEFAULTS.port, help="port to try (%(default)s)")
    parser.add_argument("--data", type=Path, default=DEFAULTS.data, metavar="DIR", help="data folder to try")
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def run(args: argparse.Namespace) -> int:
    answers = examine(args.port, args.data)
    faults = [answer for answer in answers if answer.grade == "fault"]
    if args.json:
        print(json.dumps({"healthy": not faults, "answers": [answer._asdict() for answer in answers]}))
    else:
        for answer in answers:
            print(f"{answer.grade:5}  {answer.question:12}  {answer.sentence}")
    return 1 if faults else 0


def examine(port: int, data: Path) -> list[Finding]:
    """All answers, in the order of a set-up."""
    checks: list[Callable[[], Finding]] = [
        _python, _pymunk, _exactness, _speed, lambda: _data(data), lambda: _port(port), _gamepad,
    ]  # fmt: skip
    return [check() for check in checks]


def _python() -> Finding:
    return Finding("Python", "ok", platform.python_version())


def _pymunk() -> Finding:
    version = importlib.metadata.version("pymunk")
    if version != PINNED_PYMUNK:
        say = f"{version} is not {PINNED_PYMUNK}: the physics differ from the paper's; run `make venv`"
        return Finding("pymunk", "fault", say)
    return Finding("pymunk", "ok", version)


def _exactness() -> Finding:
    pose = probe_pose()
    if pose != PROBE_POSE:
        away = float(np.abs(np.array(pose) - np.array(PROBE_POSE)).max())
        say = f"this machine computes a run {away:.1e} away from the reference; recordings from elsewhere may diverge"
        return Finding("exactness", "note" if away < 1e-3 else "fault", say)
    return Finding("exactness", "ok", f"{PROBE_TICKS} ticks of HandOff are bit-equal to the reference")


def probe_pose() -> tuple[float, ...]:
    """Blue's pose after a fixed run that turns, drives and pushes against a wall."""
    world = World(load_map("HandOff"))
    for tick in range(PROBE_TICKS):
        world.step([[1.0, tick / 9.0, tick % 10 == 0], [0.7, -tick / 7.0, tick % 15 == 0]])
    return tuple(world.state().robot_poses[0].tolist())


def _speed() -> Finding:
    world = World(load_map("HandOff"))
    started = time.perf_counter()
    for tick in range(200):
        world.step([[1.0, tick / 9.0, 0.0], [0.7, -tick / 7.0, 0.0]])
    tick_ms = (time.perf_counter() - started) / 200 * 1e3
    grade = "ok" if tick_ms < TICK_BUDGET_MS else "note"
    return Finding("speed", grade, f"{tick_ms:.2f} ms per tick of the world; a room has {TICK_MS} ms")


def _data(folder: Path) -> Finding:
    existing = next(parent for parent in (folder.resolve(), *folder.resolve().parents) if parent.exists())
    try:
        with tempfile.TemporaryFile(dir=existing) as probe:
            probe.write(b"x")
    except OSError as error:
        say = f"cannot write to {existing} ({error.strerror}); choose another one: --data DIR"
        return Finding("data folder", "fault", say)
    free = shutil.disk_usage(existing).free
    if free < FREE_BYTES:
        say = f"only {free / 1e6:.0f} MB are free at {existing}; games go on without recording when it is full"
        return Finding("data folder", "note", say)
    return Finding("data folder", "ok", f"{existing} can be written, {free / 1e9:.1f} GB free")


def _port(port: int) -> Finding:
    try:
        listen(DEFAULTS.host, port).close()
    except CannotListen as error:
        return Finding("port", "note", str(error))
    return Finding("port", "ok", f"{port} is free")


def _gamepad() -> Finding:
    say = "work at http://localhost; on other machines browsers want https: movingout play --host 0.0.0.0 --tls"
    return Finding("gamepads", "ok", say)
