"""`movingout demos generate`: records pairs of scripted people, or of partners."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from movingout.agents.commands.demonstrations.episode_options import (
    add_limits,
    add_maps,
    caution_of_maps,
    check_counts,
    designed_maps,
    played_maps,
    split_of,
)
from movingout.agents.commands.demonstrations.population_option import GROUPS_HELP, players_of, short_name
from movingout.agents.commands.demonstrations.written_episodes import WrittenEpisodes, other_code_told, with_progress
from movingout.agents.data.demonstrations import EpisodeJob, Player, episode_jobs, variant_jobs, write_all
from movingout.agents.data.repeats import folder_sentences
from movingout.agents.errors import DataError
from movingout.agents.scripted.populations import manifest
from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.list_file import LIST
from movingout.maps.files.output_file import write_output
from movingout.maps.randomize import SPLITS
from movingout.maps.selection import selected_maps
from movingout.maps.suggestion import counted


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--population",
        metavar="WHO",
        default="A",
        help=f"who plays (default %(default)s): A, B, C (for tests), {GROUPS_HELP}",
    )
    parser.add_argument("--people", type=int, help="how many of them, an even number; default: all")
    add_maps(parser)
    parser.add_argument(
        "--variants", type=int, default=0, metavar="N",
        help="challenge 2: N episodes per map instead, each on a variant of its own; pairs take turns (paper: 60)",
    )  # fmt: skip
    parser.add_argument(
        "--split", choices=SPLITS,
        help="challenge 2: variants without the combinations of size and shape of the evaluation (train), or "
        "without those of the map as designed (official)",
    )  # fmt: skip
    parser.add_argument(
        "--episodes", type=int, default=2, help="per pair and map; the pair changes seats after half (%(default)s)"
    )
    add_limits(parser)
    add_out(parser, "DIR", "folder for the recordings (%(default)s)", default=Path("data/demos"))
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Play and record what the folder lacks. Raises DataError and AgentError before anything is played."""
    people = _pairs(args)
    check_counts(args)
    _check_variants(args)
    todo = _jobs(args, people)
    caution_of_maps((job.map.name for job in todo), selected_maps(args.map))
    other = other_code_told(todo, args.out)
    for sentence in folder_sentences(todo, args.out):
        tell(sentence)
    made = with_progress(len(todo), write_all(todo, args.out, args.workers, args.ray))
    written = WrittenEpisodes(args.out, made, len(todo))
    write_output(args.out / "people.json", json.dumps(manifest(), indent=1).encode())
    if args.json:
        about = {**written.counts(), "other_code": other, "mean_tcr": written.mean_tcr()}
        print(json.dumps({**about, "tcr": written.tcr_per_map()}))
    else:
        print(written.summary())
    return 0


def _pairs(args: argparse.Namespace) -> Sequence[Player]:
    """Who plays, an even number of them. Raises DataError."""
    players = players_of(args.population)
    most = len(players) - len(players) % 2
    count = most if args.people is None else args.people
    if args.population.startswith(LIST) and len(players) % 2 and (args.people is None or most < 2):
        raise DataError(f"{args.population} names {counted(len(players), 'partner')}; pairs take an even number")
    if count < 2 or count > most or count % 2:
        raise DataError(f"--people must be an even number from 2 to {most}, not {count}")
    return players[:count]


def _check_variants(args: argparse.Namespace) -> None:
    if args.variants < 0 or (args.variants and args.challenge == 1):
        raise DataError("--variants is a number of episodes per map for --challenge 2")
    if args.split and args.challenge == 1:
        raise DataError("--split is of variants, which --challenge 2 has")


def _jobs(args: argparse.Namespace, people: Sequence[Player]) -> list[EpisodeJob]:
    prefix = f"{short_name(args.population)}{args.challenge}s{args.seed}"
    if args.variants and args.challenge == 2:
        designed = designed_maps(args)
        return variant_jobs(people, designed, args.variants, args.ticks, args.seed, prefix, split_of(args))
    return episode_jobs(people, played_maps(args), args.episodes, args.ticks, args.seed, prefix)
