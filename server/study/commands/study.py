"""`movingout study`: the commands of study/commands/study.py, plus `serve` and `simulate`, imported when they run."""

import argparse
import importlib
from pathlib import Path

from movingout.server.settings import AGENT_WORKERS, worker_count
from movingout.server.study_bots.commands import simulate as bots_command
from movingout.study.commands import study
from movingout.study.commands.study import run

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    commands = study.configure(parser)
    serve = commands.add_parser("serve", help="run a study: a link for participants, and the experimenter's page")
    add = serve.add_argument
    add("file", type=Path, metavar="FILE", help="the study file")
    add("--data", type=Path, default=Path("data"), metavar="DIR", help="the data folder (default: data)")
    add("--database", metavar="URL", help="postgresql://...; default: a file in DIR")
    add("--identities", metavar="URL", help="the database of identities; default: a file in DIR")
    add("--codes", action="store_true", help="admit only participants with a code from the experimenter")
    add("--host", default="127.0.0.1", help="address to serve (%(default)s); 0.0.0.0 for all networks")
    add("--port", type=int, default=8000, help="port to serve (%(default)s); 0 for any free one")
    add(
        "--tls",
        action="store_true",
        help="serve https with a self-signed certificate, which gamepads on other machines need",
    )
    add(
        "--origin",
        action="append",
        default=[],
        metavar="URL",
        help="also accept connections from pages of this origin (repeatable)",
    )
    add(
        "--proxy",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="trust the X-Forwarded-For of this reverse proxy (repeatable)",
    )
    add(
        "--agent-workers", type=worker_count, default=AGENT_WORKERS, metavar="N",
        help="agent processes (%(default)s)",
    )  # fmt: skip
    add(
        "--rehearse", type=float, metavar="SPEED",
        help="admit only simulated participants, at SPEED times the speed of people; the data are marked as simulated",
    )  # fmt: skip
    serve.set_defaults(perform=_serve)
    bots_command.configure(commands)


def _serve(args: argparse.Namespace) -> int:
    code: int = importlib.import_module("movingout.server.study.commands.serve").serve(args)
    return code
