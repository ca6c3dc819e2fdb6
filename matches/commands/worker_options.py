"""The options that say who plays: processes of this machine, or a Ray cluster."""

import argparse
import os

from movingout.matches.errors import MatchError
from movingout.matches.execution.local_workers import LocalCrew
from movingout.matches.execution.ray_workers import cluster_processors, ray_crew
from movingout.matches.run import CrewMaker


def add_workers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=int, metavar="N", help="processes, or actors; default: one per core")
    parser.add_argument("--ray", metavar="auto|ADDRESS", help="play on a Ray cluster instead (extra `cluster`)")


def crew_of(args: argparse.Namespace) -> CrewMaker:
    """Where the workers are. Raises MatchError when no Ray cluster answers."""
    return LocalCrew if args.ray is None else ray_crew(args.ray)


def workers_of(args: argparse.Namespace) -> int:
    """How many workers are asked for; ask for the crew first."""
    if args.workers is not None and args.workers < 1:
        raise MatchError(f"--workers must be at least 1, not {args.workers}")
    return args.workers or (os.cpu_count() or 1 if args.ray is None else cluster_processors())
