"""`movingout demos …`: demonstrations by scripted people, as training data."""

import argparse
import json
import os
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from movingout.agents.data.dagger import EXPERT, labelling_jobs
from movingout.agents.data.demonstrations import WrittenEpisode, episode_jobs, label_all, write_all
from movingout.agents.errors import DataError
from movingout.agents.scripted.populations import PEOPLE, POPULATIONS, manifest, population
from movingout.maps import MapSpec, load_map, map_names
from movingout.maps.commands.parser import add_out
from movingout.recordings.commands import imports
from movingout.world.constants import LIMIT_TICKS


def configure(parser: argparse.ArgumentParser) -> None:
    """`generate`, `label`, `import` and `people`."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    generate = actions.add_parser(
        "generate",
        help="record pairs of scripted people",
        example="movingout demos generate --population A --people 4 -o data/demos",
    )
    generate.add_argument(
        "--population", choices=POPULATIONS, default="A", help="population that plays (C is for tests)"
    )
    generate.add_argument("--people", type=int, default=PEOPLE, help=f"how many of them, an even number (1-{PEOPLE})")
    generate.add_argument("--map", default="all", help="a map's name, several joined by commas, or all")
    generate.add_argument("--challenge", type=int, choices=(1, 2), default=1, help="2: four variants of each map")
    generate.add_argument("--episodes", type=int, default=2, help="per pair and map; the pair changes seats after half")
    generate.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="limit of an episode")
    generate.add_argument("--seed", type=int, default=0)
    generate.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    add_out(generate, "DIR", "folder for the recordings (%(default)s)", default=Path("data/demos"))
    generate.add_argument("--json", action="store_true")
    label = actions.add_parser(
        "label",
        help="let an expert label what a learner does (DAgger)",
        example="movingout demos label --learner dp@mine -o data/corrections",
    )
    label.add_argument("--learner", default=EXPERT, help="agent id (default: the expert itself)")
    label.add_argument("--expert", default=EXPERT, help=f"agent id of the expert (default {EXPERT})")
    label.add_argument("--population", choices=("A", "B", "AB"), default="AB", help="populations of the partners")
    label.add_argument("--map", default="all", help="a map's name, several joined by commas, or all")
    label.add_argument("--challenge", type=int, choices=(1, 2), default=1, help="2: four variants of each map")
    label.add_argument("--episodes", type=int, default=8, help="per map")
    label.add_argument("--ticks", type=int, default=LIMIT_TICKS)
    label.add_argument("--seed", type=int, default=0)
    label.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    add_out(label, "DIR", "folder for the recordings (%(default)s)", default=Path("data/corrections"))
    label.add_argument("--json", action="store_true")
    official = actions.add_parser(
        "import",
        help="import official trajectories (same as `recordings import`)",
        example="movingout demos import trajectories -o data/official",
    )
    imports.configure(official)
    people = actions.add_parser("people", help="list the scripted people", example="movingout demos people")
    people.add_argument("--json", action="store_true")


def run(args: argparse.Namespace) -> int:
    """Dispatch."""
    perform = {"generate": _generate, "label": _label, "import": imports.perform, "people": _people}
    return perform[args.action](args)


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
    _check_counts(args)
    people = population(args.population)[: args.people]
    prefix = f"{args.population}{args.challenge}s{args.seed}"
    todo = episode_jobs(people, _maps(args), args.episodes, args.ticks, args.seed, prefix)
    made = _with_progress(len(todo), write_all(todo, args.out, args.workers))
    (args.out / "people.json").write_text(json.dumps(manifest(), indent=1))
    rates = [one.tcr for one in made]
    mean = sum(rates) / len(rates) if rates else 0.0
    if args.json:
        print(json.dumps({"out": str(args.out), "episodes": len(made), "mean_tcr": mean, "tcr": _per_map(made)}))
    else:
        print(f"{len(made)} episodes in {args.out}, mean TCR {mean:.2f}; {len(todo) - len(made)} existed already")
    return 0


def _label(args: argparse.Namespace) -> int:
    _check_counts(args)
    partners = [(person.name, person.agent_id) for name in args.population for person in population(name)]
    order = [partners[k * 7 % len(partners)] for k in range(len(partners))]  # A and B in turn
    todo = labelling_jobs(_maps(args), order, args.learner, args.expert, args.episodes, args.ticks, args.seed)
    made = _with_progress(len(todo), label_all(todo, args.out, args.workers))
    mean = sum(one.tcr for one in made) / max(len(made), 1)
    if args.json:
        print(json.dumps({"out": str(args.out), "episodes": len(made), "tcr": _per_map(made)}))
    else:
        print(f"{len(made)} episodes in {args.out}, mean TCR {mean:.2f}: {_per_map(made)}")
    return 0


def _check_counts(args: argparse.Namespace) -> None:
    if args.episodes < 1 or args.ticks < 1 or args.workers < 1:
        raise DataError("--episodes, --ticks and --workers must be at least 1")


def _per_map(made: list[WrittenEpisode]) -> dict[str, float]:
    names = sorted({one.map for one in made})
    rates = {name: [one.tcr for one in made if one.map == name] for name in names}
    return {name: round(sum(values) / len(values), 3) for name, values in rates.items()}


def _maps(args: argparse.Namespace) -> list[MapSpec]:
    names = map_names() if args.map == "all" else args.map.split(",")
    maps = [load_map(name) for name in names]
    if args.challenge == 1:
        return maps
    from movingout.maps.randomize import randomize

    return [randomize(the_map, args.seed + variant) for variant in range(4) for the_map in maps]


def _with_progress(total: int, episodes: Iterator[WrittenEpisode]) -> list[WrittenEpisode]:
    made: list[WrittenEpisode] = []
    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("episodes", total=total)
        for one in episodes:
            made.append(one)
            progress.advance(bar)
    return made
