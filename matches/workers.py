"""The options that say who plays: processes of this machine, or a Ray cluster."""

import argparse
import os

from matches.errors import MatchError
from matches.processes import LocalCrew
from matches.run import CrewMaker


def add_workers(parser: argparse.ArgumentParser) -> None:
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--workers", type=int, metavar="N", help="processes; default: all cores")


def workers_of(args: argparse.Namespace) -> int:
    """How many workers are asked for."""
    if args.workers is not None and args.workers < 1:
        raise MatchError(f"--workers must be at least 1, not {args.workers}")
    return args.workers or os.cpu_count() or 1


def crew_of(args: argparse.Namespace) -> CrewMaker:
    """Where they are."""
    return LocalCrew
