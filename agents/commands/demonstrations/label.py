"""`movingout demos label`: lets an expert label what a learner does (DAgger)."""

import argparse
import json
from pathlib import Path

from movingout.agents.commands.demonstrations.episode_options import (
    add_limits,
    add_maps,
    caution_of_maps,
    check_counts,
    played_maps,
)
from movingout.agents.commands.demonstrations.population_option import GROUPS_HELP, players_of
from movingout.agents.commands.demonstrations.written_episodes import WrittenEpisodes, other_code_told, with_progress
from movingout.agents.data.dagger import EXPERT, labelling_jobs, shuffled_partners
from movingout.agents.data.demonstrations import label_all
from movingout.agents.partners.families import test_people_caution
from movingout.agents.scripted.populations import population
from movingout.maps.commands.parser import add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.maps.selection import selected_maps


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--learner", default=EXPERT, help="agent id (default: the expert itself)")
    parser.add_argument("--expert", default=EXPERT, help=f"agent id of the expert (default {EXPERT})")
    parser.add_argument(
        "--population",
        metavar="WHO",
        default="AB",
        help=f"the partners (default %(default)s): A, B, AB, {GROUPS_HELP}",
    )
    add_maps(parser)
    parser.add_argument("--episodes", type=int, default=8, help="per map (%(default)s)")
    add_limits(parser)
    add_out(parser, "DIR", "folder for the recordings (%(default)s)", default=Path("data/corrections"))
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Play and label what the folder lacks. Raises DataError and AgentError before anything is played."""
    check_counts(args)
    maps = played_maps(args)
    order = _partners(args, len(maps) * args.episodes)
    if caution := test_people_caution([args.population]):
        tell(caution)
    todo = labelling_jobs(maps, order, args.learner, args.expert, args.episodes, args.ticks, args.seed)
    caution_of_maps((job.map.name for job in todo), selected_maps(args.map))
    other = other_code_told(todo, args.out)
    made = with_progress(len(todo), label_all(todo, args.out, args.workers, args.ray))
    written = WrittenEpisodes(args.out, made, len(todo))
    if args.json:
        print(json.dumps({**written.counts(), "other_code": other, "tcr": written.tcr_per_map()}))
    else:
        print(written.summary())
        for line in written.group_lines():
            print(printable(line))
    return 0


def _partners(args: argparse.Namespace, episodes: int) -> list[tuple[str, str]]:
    """Name and agent id of the partners, in the order in which they play."""
    if args.population in ("A", "B", "AB"):
        partners = [(person.name, person.agent_id) for name in args.population for person in population(name)]
        return [partners[k * 7 % len(partners)] for k in range(len(partners))]  # A and B in turn
    players = [(player.name, player.agent_id) for player in players_of(args.population)]
    return shuffled_partners(players, episodes, args.seed)
