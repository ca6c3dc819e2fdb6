"""What the actions of `movingout demos` that play have in common: options, how these are checked, and cautions."""

import argparse
import os
from collections.abc import Iterable

from movingout.agents.data.rollout import check_undelivered
from movingout.agents.errors import DataError
from movingout.maps import MapSpec, load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.commands.sentences import tell
from movingout.maps.generated.names import test_maps_caution
from movingout.maps.randomize import Split, randomize
from movingout.maps.selection import HELP as MAPS_HELP
from movingout.maps.selection import selected_maps
from movingout.world.constants import LIMIT_TICKS, MAX_SEED, MAX_TICKS


def add_maps(parser: argparse.ArgumentParser) -> None:
    """`--map` and `--challenge`."""
    parser.add_argument("--map", default="all", help=f"{MAPS_HELP}; default: all")
    parser.add_argument(
        "--challenge", type=int, choices=(1, 2), default=1, help="2: four variants of each map (default %(default)s)"
    )


def add_limits(parser: argparse.ArgumentParser) -> None:
    """`--ticks`, `--seed` and those of the workers."""
    parser.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="limit of an episode (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first episode (%(default)s)")
    add_workers(parser)


def add_workers(parser: argparse.ArgumentParser) -> None:
    """`--workers` and `--ray`."""
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")
    parser.add_argument("--ray", default="", metavar="auto|ADDRESS", help="play on a Ray cluster (extra `cluster`)")


def check_counts(args: argparse.Namespace) -> None:
    """Raises DataError for numbers with which nothing can be played."""
    if args.episodes < 1 or args.ticks < 1 or args.workers < 1:
        raise DataError("--episodes, --ticks and --workers must be at least 1")
    if args.ticks > MAX_TICKS or not 0 <= args.seed <= MAX_SEED:
        raise DataError(f"--ticks is at most {MAX_TICKS}, and --seed is a whole number from 0 to {MAX_SEED}")


def designed_maps(args: argparse.Namespace) -> list[MapSpec]:
    """The maps of `--map`. Raises AgentError for one on which nothing can be played."""
    maps = [load_map(name) for name in selected_maps(args.map)]
    for the_map in maps:
        check_undelivered(the_map)
    return maps


def played_maps(args: argparse.Namespace) -> list[MapSpec]:
    """The maps of `--map`; with challenge 2 four variants of each. Raises AgentError as `designed_maps`."""
    maps = designed_maps(args)
    if args.challenge == 1:
        return maps
    return [randomize(the_map, args.seed + variant, split_of(args)) for variant in range(4) for the_map in maps]


def split_of(args: argparse.Namespace) -> Split:
    """Of variants; `label` has no other."""
    split: Split = getattr(args, "split", None) or "train"
    return split


def caution_of_maps(maps: Iterable[str], asked: Iterable[str] = ()) -> None:
    """Say so when test maps are among those played, as demonstrations are there to be trained on.

    Also say what is wrong with map files among those that were asked for.
    """
    for sentence in filter(None, [test_maps_caution(maps), *map_cautions(asked)]):
        tell(sentence)
