"""`movingout demos prove`: lists generated maps on which a pair of experts delivers everything."""

import argparse
import json
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from movingout.agents.commands.demonstrations.episode_options import add_workers, caution_of_maps
from movingout.agents.data.proving import maps_per_mode, prove
from movingout.agents.errors import DataError
from movingout.maps.commands.parser import add_out
from movingout.maps.generated.names import PREFIX, SPLITS
from movingout.recordings.ray_cluster import connect, processors


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--split", choices=SPLITS, default="training", help="whose seeds to try (%(default)s)")
    parser.add_argument("--count", type=int, default=100, help="maps of each mode in the whole file (%(default)s)")
    add_workers(parser)
    add_out(parser, "FILE", "the list, continued if it exists (%(default)s)", default=Path("data/maps.txt"))
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Try maps until the list has enough of each mode. Raises DataError."""
    if args.count < 1 or args.workers < 1:
        raise DataError("--count and --workers must be at least 1")
    caution_of_maps([f"{PREFIX}:{args.split}"])
    tried, solved = _tried(args)
    has = maps_per_mode(args.out)
    if args.json:
        print(json.dumps({"out": str(args.out), "tried": tried, "solved": solved, "maps": has}))
    else:
        listed = ", ".join(f"{count} of {mode}" for mode, count in has.items())
        print(f"{solved} of {tried} maps tried were solved; {args.out} has {listed}")
    return 0


def _tried(args: argparse.Namespace) -> tuple[int, int]:
    """How many maps were tried, and on how many of them all was delivered; a bar shows both."""
    if args.ray:
        connect(args.ray)
    workers = processors() if args.ray else args.workers
    tried = solved = 0
    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("maps", total=None)
        for _, ticks in prove(args.split, args.out, args.count, workers, args.ray):
            tried, solved = tried + 1, solved + (ticks is not None)
            progress.update(bar, completed=tried, description=f"{solved} of {tried} maps solved")
    return tried, solved
