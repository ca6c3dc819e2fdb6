"""`movingout study`: the commands of study/commands/study.py, plus `serve` and `simulate`, imported when they run."""

import argparse
import importlib
from pathlib import Path

from movingout.maps.commands.parser import filled
from movingout.server.options import add_options
from movingout.server.settings import Settings
from movingout.server.study.commands import links
from movingout.server.study_bots.commands import simulate as bots_command
from movingout.study.commands import study
from movingout.study.commands.study import run

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    commands = study.configure(parser)
    serve = commands.add_parser(
        "serve",
        help="run a study: a link for participants, and the experimenter's page",
        example="movingout study serve study.yaml --host 0.0.0.0 --tls",
    )
    add = serve.add_argument
    add("file", type=Path, metavar="FILE", help="the study file")
    add("--database", type=filled, metavar="URL", help="postgresql://...; default: a file in DIR")
    add("--identities", type=filled, metavar="URL", help="the database of identities; default: a file in DIR")
    add("--codes", action="store_true", help="admit only participants with a code from the experimenter")
    add("--signed", action="store_true", help="admit only who has a link of `movingout study links`, or a code")
    add(
        "--any-device", action="store_true",
        help="let people continue in another browser with a platform's link, which anybody who knows their id can make",
    )  # fmt: skip
    add_options(serve, Settings, without=("partner", "maps", "countdown_s"))
    add(
        "--rehearse", type=float, metavar="SPEED",
        help="admit only simulated participants, at SPEED times the speed of people; the data are marked as simulated",
    )  # fmt: skip
    serve.set_defaults(perform=_serve)
    links.configure(commands)
    bots_command.configure(commands)


def _serve(args: argparse.Namespace) -> int:
    code: int = importlib.import_module("movingout.server.study.commands.serve").serve(args)
    return code
