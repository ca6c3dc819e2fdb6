"""`movingout doctor`: can this machine serve the game? One line per question, and what to do where the answer is no."""

import argparse
import importlib.metadata
import json
import platform
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from movingout.agents.baseline.idle import IdleAgent
from movingout.agents.baseline.timed_agent import TimedAgent
from movingout.agents.catalogue import agent_cards, damaged_cards, load_agent
from movingout.agents.data.rollout import rollout
from movingout.agents.decision_time import unhindered
from movingout.maps import MovingOutError, load_map
from movingout.maps.commands.parser import folder
from movingout.maps.files.terminal import printable_lines
from movingout.server.commands.exactness_probe import PROBES, deviation
from movingout.server.settings import Settings, port
from movingout.server.uvicorn_server import CannotListen, listen
from movingout.world import World
from movingout.world.constants import TICK_MS
from movingout.world.exactness import inexact_engine

DEFAULTS = Settings()
FREE_BYTES = 500e6
TICK_BUDGET_MS = 2.0
NOTICEABLE = 1e-3  # units of the world
AGENT_MAP = "DistancePriority"
AGENT_TICKS = 100  # of play per agent


class DoctorFinding(NamedTuple):
    """One line of the report. `grade` is ok, note (works, but) or fault."""

    question: str
    grade: str
    sentence: str


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--port", type=port, default=DEFAULTS.port, help="port to try (%(default)s)")
    parser.add_argument(
        "--data", type=folder, default=DEFAULTS.data, metavar="DIR", help="data folder to try (%(default)s)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def run(args: argparse.Namespace) -> int:
    findings = examine(args.port, args.data)
    faults = [finding for finding in findings if finding.grade == "fault"]
    if args.json:
        print(json.dumps({"healthy": not faults, "answers": [finding._asdict() for finding in findings]}))
    else:
        for finding in findings:
            print(printable_lines(f"{finding.grade:5}  {finding.question:12}  {finding.sentence}"))
    return 1 if faults else 0


def examine(port: int, data: Path) -> list[DoctorFinding]:
    """All findings, in the order of a set-up."""
    checks: list[Callable[[], DoctorFinding]] = [
        _python, _pymunk, _exactness, _speed, lambda: _data(data), lambda: _port(port), _gamepad,
    ]  # fmt: skip
    return [check() for check in checks] + [_agent(card.id) for card in agent_cards()] + _damaged()


def _python() -> DoctorFinding:
    return DoctorFinding("Python", "ok", platform.python_version())


def _pymunk() -> DoctorFinding:
    inexact = inexact_engine()
    return DoctorFinding("pymunk", "note" if inexact else "ok", inexact or importlib.metadata.version("pymunk"))


def _exactness() -> DoctorFinding:
    """Bit equality with the official benchmark, by simulation, whatever the version of the engine promises."""
    away = {probe.what: deviation(probe) for probe in PROBES}
    differing = [f"{what} ends {distance:.1e} away" for what, distance in away.items() if distance]
    if not differing:
        return DoctorFinding("exactness", "ok", f"carrying {' and '.join(away)} is bit-equal to the reference")
    say = f"the physics are not exact here: {', '.join(differing)}; recordings from elsewhere may play differently"
    return DoctorFinding("exactness", "note" if max(away.values()) < NOTICEABLE else "fault", say)


def _speed() -> DoctorFinding:
    world = World(load_map("HandOff"))
    started = unhindered()
    for tick in range(200):
        world.step([[1.0, tick / 9.0, 0.0], [0.7, -tick / 7.0, 0.0]])
    tick_ms = (unhindered() - started) / 200 * 1e3
    grade = "ok" if tick_ms < TICK_BUDGET_MS else "note"
    return DoctorFinding("speed", grade, f"{tick_ms:.2f} ms per tick of the world; a room has {TICK_MS} ms")


def _data(folder: Path) -> DoctorFinding:
    existing = folder
    try:
        existing = next(parent for parent in (folder.resolve(), *folder.resolve().parents) if parent.exists())
        with tempfile.TemporaryFile(dir=existing) as probe:
            probe.write(b"x")
        free = shutil.disk_usage(existing).free
    except (OSError, RuntimeError) as error:  # RuntimeError: a circle of links
        why = getattr(error, "strerror", None) or error
        say = f"cannot write to {existing} ({why}); choose another one: --data DIR"
        return DoctorFinding("data folder", "fault", say)
    if free < FREE_BYTES:
        say = f"only {free / 1e6:.0f} MB are free at {existing}; games go on without recording when it is full"
        return DoctorFinding("data folder", "note", say)
    return DoctorFinding("data folder", "ok", f"{existing} can be written, {free / 1e9:.1f} GB free")


def _port(port: int) -> DoctorFinding:
    try:
        listen(DEFAULTS.host, port).close()
    except CannotListen as error:
        return DoctorFinding("port", "note", str(error))
    return DoctorFinding("port", "ok", f"{port} is free")


def _gamepad() -> DoctorFinding:
    say = "work at http://localhost; on other machines browsers want https: movingout play --host 0.0.0.0 --tls"
    return DoctorFinding("gamepads", "ok", say)


def _agent(agent_id: str) -> DoctorFinding:
    """Whether an agent can be loaded and decides in time here, on the map of a first game."""
    try:
        timed = TimedAgent(load_agent(agent_id))
        ticks = sum(1 for _ in rollout(load_map(AGENT_MAP), (timed, IdleAgent()), seed=0, ticks=AGENT_TICKS))
    except MovingOutError as error:
        return DoctorFinding(agent_id, "fault", str(error))
    p99_ms = float(np.percentile(timed.decisions_ms, 99))
    say = f"{len(timed.decisions_ms)} decisions in {ticks} ticks, p99 {p99_ms:.1f} ms of {TICK_MS} ms"
    if p99_ms < TICK_MS:
        return DoctorFinding(agent_id, "ok", say)
    return DoctorFinding(agent_id, "note", f"{say}: too slow here, it will miss ticks")


def _damaged() -> list[DoctorFinding]:
    return [DoctorFinding("agent", "fault", sentence) for sentence in damaged_cards()]
