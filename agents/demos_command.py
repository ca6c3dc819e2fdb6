"""`movingout demos …`: demonstrations by scripted people, to learn from where there are no people."""

import argparse
import json
import os
from pathlib import Path

from agents.demonstrations import Made, jobs, make_all
from agents.errors import DataError
from agents.populations import PEOPLE, POPULATIONS, manifest, population
from maps import MapSpec, load_map, map_names


def configure(parser: argparse.ArgumentParser) -> None:
    """`generate` and `people`."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    generate = actions.add_parser("generate", help="let scripted pairs play and record them")
    generate.add_argument("--population", choices=POPULATIONS, default="A", help="whose people play (C is for tests)")
    generate.add_argument("--people", type=int, default=PEOPLE, help=f"how many of them, an even number (1-{PEOPLE})")
    generate.add_argument("--map", default="all", help="a map's name, several joined by commas, or all")
    generate.add_argument("--challenge", type=int, choices=(1, 2), default=1, help="2: items randomised by seed")
    generate.add_argument("--episodes", type=int, default=2, help="per pair and map; roles change after half")
    generate.add_argument("--ticks", type=int, default=500, help="limit of an episode")
    generate.add_argument("--seed", type=int, default=0)
    generate.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    generate.add_argument("--out", type=Path, default=Path("data/demos"), help="folder for the recordings")
    generate.add_argument("--json", action="store_true")
    people = actions.add_parser("people", help="who is in the populations")
    people.add_argument("--json", action="store_true")


def run(args: argparse.Namespace) -> int:
    """Dispatch."""
    return _people(args) if args.action == "people" else _generate(args)


def _people(args: argparse.Namespace) -> int:
    if args.json:
        print(json.dumps(manifest()))
        return 0
    for name in POPULATIONS:
        for person in population(name):
            print(f"{person.name}  {person.sha256[:12]}  {person.agent_id}")
    return 0


def _generate(args: argparse.Namespace) -> int:
    if args.people < 2 or args.people > PEOPLE or args.people % 2:
        raise DataError(f"--people must be an even number from 2 to {PEOPLE}, not {args.people}")
    if args.episodes < 1 or args.ticks < 1 or args.workers < 1:
        raise DataError("--episodes, --ticks and --workers must be at least 1")
    people = population(args.population)[: args.people]
    prefix = f"{args.population}{args.challenge}s{args.seed}"
    todo = jobs(people, _maps(args), args.episodes, args.ticks, args.seed, prefix)
    made = _with_progress(todo, args)
    (args.out / "people.json").write_text(json.dumps(manifest(), indent=1))
    rates = [one.tcr for one in made]
    mean = sum(rates) / len(rates) if rates else 0.0
    if args.json:
        per_map = {
            name: [round(one.tcr, 4) for one in made if one.map == name] for name in sorted({o.map for o in made})
        }
        print(json.dumps({"out": str(args.out), "episodes": len(made), "mean_tcr": mean, "tcr": per_map}))
    else:
        print(f"{len(made)} episodes in {args.out}, mean TCR {mean:.2f}; {len(todo) - len(made)} were there already")
    return 0


def _maps(args: argparse.Namespace) -> list[MapSpec]:
    names = map_names() if args.map == "all" else args.map.split(",")
    maps = [load_map(name) for name in names]
    if args.challenge == 1:
        return maps
    from maps.randomize import randomize

    return [randomize(the_map, args.seed + variant) for variant in range(4) for the_map in maps]


def _with_progress(todo: list, args: argparse.Namespace) -> list[Made]:  # type: ignore[type-arg]
    from rich.console import Console
    from rich.progress import Progress

    made: list[Made] = []
    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("episodes", total=len(todo))
        for one in make_all(todo, args.out, args.workers):
            made.append(one)
            progress.advance(bar)
    return made
