"""Agents on maps and with partners that they may never have met, beside an idle partner and the scripted expert.

    python -m bench.anywhere --agents dp@any dp@all scripted idle --partners C --runs 24 --log data/anywhere.jsonl

Tables for each group of partners, with a column per group of maps (the paper's twelve, these mirrored and turned,
generated test maps of each mode, and the twelve with the held-out items of Challenge 2): TCR and NFD of each agent with
the difference to the idle partner over the same episodes, the difference between the first two agents, the share of
episodes in which the idle partner was the better one, and interdependence (`world.interdependence`). `--runs` are
episodes per cell; all agents play the same ones, and fewer are a prefix of more. With `--log FILE` finished episodes
are kept, and the same command resumes where it stopped.
"""

import argparse
import json
from collections.abc import Sequence
from math import gcd
from typing import NamedTuple

from bench.learning import add_options, partner_ids, play_all, refuse_unknown
from bench.results.anywhere_tables import CONTROL, Played, gain, idle_share, over_maps, tables
from bench.results.episode_log import Run
from movingout.maps import map_names
from movingout.maps.errors import MovingOutError
from movingout.maps.generated.names import MODE_WORDS
from movingout.maps.generated.proved import proved_maps
from movingout.maps.selection import selected_maps
from movingout.matches.commands.worker_options import worker_pool_of, workers_of
from movingout.matches.match import Challenge
from movingout.world.estimates import Estimate

_STRIDES = (
    7,
    3,
)  # between the maps and partners of neighbouring episodes; the latter odd, as leaders and followers alternate


class MapGroup(NamedTuple):
    """A column of the tables."""

    maps: list[str]  # names
    challenge: Challenge = 1


def map_groups() -> dict[str, MapGroup]:
    """The columns."""
    twelve, tests = list(map_names()), proved_maps("test")
    groups = {"12 maps": MapGroup(twelve), "mirrored, turned": MapGroup(selected_maps("all:symmetries"))}
    for word in MODE_WORDS.values():
        groups[f"generated: {word}"] = MapGroup([name for name in tests if f":{word}:" in name])
    return {**groups, "Challenge 2": MapGroup(twelve, challenge=2)}


def runs(agent: str, group: MapGroup, partners: Sequence[str], count: int, ticks: int) -> list[Run]:
    """`count` episodes of an agent, the same for every agent: maps, partners and seats in turn."""
    maps, made = group.maps, []
    for number in range(count):
        the_map = maps[_turn(number, len(maps), _STRIDES[0])]
        partner, seat = partners[_turn(number, len(partners), _STRIDES[1])], (number // 2 + number // len(maps)) % 2
        made.append(Run(agent, partner, the_map, seat, number, ticks, group.challenge))
    return made


def _turn(number: int, count: int, stride: int) -> int:
    """Every index of `count` once in a row, neighbours `stride` apart, or a little more."""
    while gcd(count, stride) > 1:  # or some would never be drawn
        stride += 2
    return number * stride % count


def main(words: Sequence[str] | None = None) -> dict[str, Played]:
    """Parse, play and print; returns what was played, by group of partners. Exits with a message if impossible."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser, ["scripted", CONTROL])
    parser.add_argument("--partners", nargs="+", default=["C"], help="groups: C, family:greedy, @FILE, …, or agent ids")
    parser.add_argument("--groups", nargs="+", choices=map_groups(), default=list(map_groups()), help="columns")
    parser.add_argument("--runs", type=int, default=24, help="episodes per cell")
    args = parser.parse_args(words)
    if min(args.runs, args.ticks) < 1:
        parser.error("--runs and --ticks must be at least 1")
    try:
        found = {partners: _played(args, partners) for partners in args.partners}
    except MovingOutError as error:
        parser.error(str(error))
    if args.json:
        print(json.dumps({partners: _numbers(played) for partners, played in found.items()}))
    else:
        for partners, played in found.items():
            print(f"\nPartners: {partners}\n\n{tables(played)}")
    return found


def _played(args: argparse.Namespace, partners: str) -> Played:
    """Outcomes by agent and group of maps, with one group of partners."""
    ids = partner_ids(partners)
    refuse_unknown([*args.agents, *ids])
    groups = {name: group for name, group in map_groups().items() if name in args.groups}
    wanted = {
        (agent, name): runs(agent, group, ids, args.runs, args.ticks)
        for agent in args.agents
        for name, group in groups.items()
    }
    everything = list(dict.fromkeys(run for made in wanted.values() for run in made))
    pool, workers = worker_pool_of(args), workers_of(args)
    done = {one.run: one for one in play_all(everything, workers, args.log, pool)}
    return {agent: {name: [done[run] for run in wanted[agent, name]] for name in groups} for agent in args.agents}


def _numbers(played: Played) -> dict[str, dict[str, object]]:
    """What the tables say, for `--json`."""
    columns = next(iter(played.values()))
    numbers: dict[str, dict[str, object]] = {
        agent: {column: _cell(played, agent, column) for column in columns} for agent in played
    }
    one, other = [*played, "", ""][:2]
    if other:
        numbers[f"{one} minus {other}"] = {
            column: {metric: _mean_and_error(gain(played, one, other, column, metric)) for metric in ("tcr", "nfd")}
            for column in columns
        }
    return numbers


def _cell(played: Played, agent: str, column: str) -> dict[str, object]:
    outcomes = played[agent][column]
    found = over_maps(outcomes, "tcr")
    assert found is not None
    cell: dict[str, object] = {"tcr": found.mean, "stderr": found.stderr, "n": len(outcomes), "maps": found.n}
    cell |= {metric: _mean_and_error(over_maps(outcomes, metric)) for metric in ("nfd", "interdependence")}
    if CONTROL in played:
        cell["idle_was_better"] = idle_share(played, agent, column)
    return cell


def _mean_and_error(found: Estimate | None) -> tuple[float, float | None] | None:
    return None if found is None else (found.mean, found.stderr)


if __name__ == "__main__":
    main()
