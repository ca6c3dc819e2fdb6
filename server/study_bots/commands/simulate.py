"""`movingout study simulate`: what can be asked for. Everything else is imported only when it is."""

import argparse
import importlib
from pathlib import Path
from typing import Any

from movingout.maps.extras import needs_extra

MAX_SPEED = 20.0  # a tick of 5 ms: beyond it the server is busy all the time


def configure(commands: Any) -> None:
    """Add `simulate` to the sub-commands of `movingout study`."""
    simulate = commands.add_parser(
        "simulate",
        help="let simulated participants take the whole study, checked and marked as simulated; exit code 1 for a loss",
    )
    add = simulate.add_argument
    add("file", type=Path, metavar="FILE", help="the study file")
    add("--participants", type=int, metavar="N", help="how many (default: as many as the study wants)")
    add("--speed", type=_speed, default=1.0, metavar="N|max", help="times as fast as people (default: 1)")
    add("--data", type=Path, metavar="DIR", help="a new folder (default: data/simulated/ID-TIME)")
    add("--seed", type=int, default=0, help="of the answers, the people at the stick and the faults")
    add("--at-once", type=int, default=16, metavar="N", help="participants at the same time (%(default)s)")
    add(
        "--chaos",
        action="store_true",
        help="with reloads, broken connections, double clicks, absences and some who stop",
    )
    add("--kills", type=int, default=0, metavar="N", help="kill -9 the server so often, and start it again")
    add("--url", default="", help="a running server, started with `serve --rehearse`; without it one is started")
    add("--json", action="store_true", help="one JSON document on standard output")
    simulate.set_defaults(perform=_simulate)


def _simulate(args: argparse.Namespace) -> int:
    with needs_extra("simulate", "study simulate"):
        command = importlib.import_module("movingout.server.study_bots.commands.rehearsal_command")
    code: int = command.simulate(args)
    return code


def _speed(text: str) -> float:
    speed = MAX_SPEED if text == "max" else float(text)
    if not 0.1 <= speed <= MAX_SPEED:
        raise argparse.ArgumentTypeError(f"a speed is from 0.1 to {MAX_SPEED:g}, or max")
    return speed
