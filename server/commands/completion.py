"""`movingout completion SHELL`: prints a script with which the shell itself completes commands and options."""

import argparse
from pathlib import Path

import shtab

from movingout.maps.commands.parser import CommandParser, parsers_below
from movingout.server import cli


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=shtab.SUPPORTED_SHELLS, help="the shell that is to complete")


def run(args: argparse.Namespace) -> int:
    print(shtab.complete(whole_parser(), args.shell))
    return 0


def whole_parser() -> CommandParser:
    """All commands in one parser; what names a path is completed with the files that are there."""
    parser = CommandParser(prog="movingout", description="People and agents carry things together.")
    parser.add_argument("--version", action="store_true", help="print the version and exit")
    commands = parser.add_subparsers()
    for name in cli.COMMANDS:
        _, below = cli.configured(name)
        shown = commands.add_parser(name, help=cli.COMMANDS[name].help, add_help=False, parents=[below])
        shown.prog = below.prog
    for each in parsers_below(parser):
        for action in each._actions:
            if action.type is Path:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
    return parser
