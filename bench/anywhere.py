"""Agents on maps and with partners that they may never have met, beside an idle partner and the scripted expert.

    python -m bench.anywhere --agents dp@any dp@all scripted idle --partners C --runs 24 --log data/anywhere.jsonl

One table per group of partners: a row per agent, a column per group of maps (the paper's twelve, these mirrored and
turned, generated test maps of each mode), with TCR, its standard error, and the difference to the idle partner over the
same episodes. `--runs` are episodes per cell; all agents play the same ones, and fewer are a prefix of more. With
`--log FILE` finished episodes are kept, and the same command resumes where it stopped.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from math import gcd

from bench.learning import add_options, partner_ids, play_all, refuse_unknown
from bench.results.episode_log import Outcome, Run
from movingout.maps import map_names
from movingout.maps.errors import MovingOutError
from movingout.maps.generated.names import MODE_WORDS
from movingout.maps.generated.proved import proved_maps
from movingout.maps.selection import selected_maps
from movingout.world.estimates import estimate, estimate_text

CONTROL = "idle"
Played = Mapping[str, Mapping[str, Sequence[Outcome]]]
"""Outcomes by agent and group of maps."""
_STRIDES = (
    7,
    3,
)  # between the maps and partners of neighbouring episodes; the latter odd, as leaders and followers alternate


def map_groups() -> dict[str, list[str]]:
    """The columns: names of maps by group."""
    groups = {"12 maps": list(map_names()), "mirrored, turned": selected_maps("all:symmetries")}
    tests = proved_maps("test")
    groups |= {f"generated: {word}": [name for name in tests if f":{word}:" in name] for word in MODE_WORDS.values()}
    return groups


def runs(agent: str, maps: Sequence[str], partners: Sequence[str], count: int, ticks: int) -> list[Run]:
    """`count` episodes of an agent, the same for every agent: maps, partners and seats in turn."""
    made = []
    for number in range(count):
        the_map, partner = (
            maps[_turn(number, len(maps), _STRIDES[0])],
            partners[_turn(number, len(partners), _STRIDES[1])],
        )
        made.append(Run(agent, partner, the_map, (number // 2 + number // len(maps)) % 2, number, ticks))
    return made


def _turn(number: int, count: int, stride: int) -> int:
    """Every index of `count` once in a row, neighbours `stride` apart, or a little more."""
    while gcd(count, stride) > 1:  # or some would never be drawn
        stride += 2
    return number * stride % count


def table(played: Played) -> str:
    """Markdown: agents by groups of maps, `TCR ± SE (difference to idle ± SE)`."""
    columns = list(next(iter(played.values())))
    lines = [f"| TCR | {' | '.join(columns)} | n per cell |", "|---" * (len(columns) + 2) + "|"]
    for agent, cells in played.items():
        texts = [_cell(cells[column], played.get(CONTROL, {}).get(column)) for column in columns]
        lines.append(f"| {agent} | {' | '.join(texts)} | {min(map(len, cells.values()))} |")
    return "\n".join(lines)


def _cell(mine: Sequence[Outcome], control: Sequence[Outcome] | None) -> str:
    text = estimate_text(estimate([one.tcr for one in mine]))
    if not control or control is mine:
        return text
    difference = estimate([one.tcr - other.tcr for one, other in zip(mine, control, strict=True)])
    assert difference is not None
    return f"{text} ({difference.mean:+.3f} ± {difference.stderr or 0.0:.3f})"


def main(words: Sequence[str] | None = None) -> dict[str, Played]:
    """Parse, play and print; returns what was played, by group of partners. Exits with a message if impossible."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_options(parser, ["scripted", CONTROL])
    parser.add_argument("--partners", nargs="+", default=["C"], help="groups: C, family:greedy, …, or agent ids")
    parser.add_argument("--groups", nargs="+", choices=map_groups(), default=list(map_groups()), help="columns")
    parser.add_argument("--runs", type=int, default=24, help="episodes per cell")
    args = parser.parse_args(words)
    if min(args.runs, args.ticks, args.workers) < 1:
        parser.error("--runs, --ticks and --workers must be at least 1")
    try:
        tables = {partners: _played(args, partners) for partners in args.partners}
    except MovingOutError as error:
        parser.error(str(error))
    if args.json:
        print(json.dumps({partners: _numbers(played) for partners, played in tables.items()}))
    else:
        for partners, played in tables.items():
            print(f"\nPartners: {partners}\n\n{table(played)}")
    return tables


def _played(args: argparse.Namespace, partners: str) -> Played:
    """Outcomes by agent and group of maps, with one group of partners."""
    ids = partner_ids(partners)
    refuse_unknown([*args.agents, *ids])
    groups = {name: maps for name, maps in map_groups().items() if name in args.groups}
    wanted = {
        (agent, name): runs(agent, maps, ids, args.runs, args.ticks)
        for agent in args.agents
        for name, maps in groups.items()
    }
    everything = list(dict.fromkeys(run for made in wanted.values() for run in made))
    done = {one.run: one for one in play_all(everything, args.workers, args.log)}
    return {agent: {name: [done[run] for run in wanted[agent, name]] for name in groups} for agent in args.agents}


def _numbers(played: Played) -> dict[str, dict[str, object]]:
    numbers: dict[str, dict[str, object]] = {}
    for agent, cells in played.items():
        for column, outcomes in cells.items():
            found = estimate([one.tcr for one in outcomes])
            assert found is not None
            numbers.setdefault(agent, {})[column] = {"tcr": found.mean, "stderr": found.stderr, "n": found.n}
    return numbers


if __name__ == "__main__":
    main()
