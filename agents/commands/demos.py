"""`movingout demos …`: demonstrations by scripted people, as training data."""

import argparse
import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from movingout.agents.catalogue import load_agent
from movingout.agents.data.dagger import EXPERT, LabellingJob, labelling_jobs, shuffled_partners
from movingout.agents.data.demonstrations import (
    EpisodeJob,
    Player,
    WrittenEpisode,
    episode_jobs,
    label_all,
    of_other_code,
    variant_jobs,
    write_all,
)
from movingout.agents.data.proving import maps_per_mode, prove
from movingout.agents.data.repeats import folder_sentences
from movingout.agents.data.rollout import check_undelivered
from movingout.agents.errors import AgentError, DataError
from movingout.agents.partners.families import (
    ALL,
    FAMILY,
    Family,
    families,
    family_of,
    group,
    installed_families,
    is_group,
    test_people_caution,
    to_try,
)
from movingout.agents.scripted.populations import POPULATIONS, manifest, population
from movingout.maps import MapSpec, load_map
from movingout.maps.commands.map_cautions import map_cautions
from movingout.maps.commands.parser import add_out
from movingout.maps.files.list_file import LIST
from movingout.maps.files.output_file import write_output
from movingout.maps.generated.names import PREFIX, SPLITS, is_generated, test_maps_caution
from movingout.maps.randomize import SPLITS as VARIANT_SPLITS
from movingout.maps.randomize import Split, randomize
from movingout.maps.selection import HELP as MAPS_HELP
from movingout.maps.selection import selected_maps
from movingout.maps.suggestion import counted, known_names
from movingout.maps.symmetry import SEPARATOR, split_name
from movingout.recordings.commands import imports
from movingout.recordings.ray_cluster import connect, processors
from movingout.world.constants import LIMIT_TICKS, MAX_SEED, MAX_TICKS

_GROUPS_HELP = "a family as family:greedy, families, families:without-greedy, or @FILE (agent ids, one per line)"


def configure(parser: argparse.ArgumentParser) -> None:
    """`generate`, `label`, `prove`, `import` and `people`."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    generate = actions.add_parser(
        "generate",
        help="record pairs of scripted people",
        example="movingout demos generate --population A --people 4 -o data/demos",
    )
    generate.add_argument(
        "--population",
        metavar="WHO",
        default="A",
        help=f"who plays (default %(default)s): A, B, C (for tests), {_GROUPS_HELP}",
    )
    generate.add_argument("--people", type=int, help="how many of them, an even number; default: all")
    generate.add_argument("--map", default="all", help=f"{MAPS_HELP}; default: all")
    generate.add_argument(
        "--challenge", type=int, choices=(1, 2), default=1, help="2: four variants of each map (default %(default)s)"
    )
    generate.add_argument(
        "--variants", type=int, default=0, metavar="N",
        help="challenge 2: N episodes per map instead, each on a variant of its own; pairs take turns (paper: 60)",
    )  # fmt: skip
    generate.add_argument(
        "--split", choices=VARIANT_SPLITS,
        help="challenge 2: variants without the combinations of size and shape of the evaluation (train), or "
        "without those of the map as designed (official)",
    )  # fmt: skip
    generate.add_argument(
        "--episodes", type=int, default=2, help="per pair and map; the pair changes seats after half (%(default)s)"
    )
    generate.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="limit of an episode (%(default)s)")
    generate.add_argument("--seed", type=int, default=0, help="seed of the first episode (%(default)s)")
    _add_workers(generate)
    add_out(generate, "DIR", "folder for the recordings (%(default)s)", default=Path("data/demos"))
    generate.add_argument("--json", action="store_true", help="print one JSON document")
    label = actions.add_parser(
        "label",
        help="let an expert label what a learner does (DAgger)",
        example="movingout demos label --learner dp@mine -o data/corrections",
    )
    label.add_argument("--learner", default=EXPERT, help="agent id (default: the expert itself)")
    label.add_argument("--expert", default=EXPERT, help=f"agent id of the expert (default {EXPERT})")
    label.add_argument(
        "--population",
        metavar="WHO",
        default="AB",
        help=f"the partners (default %(default)s): A, B, AB, {_GROUPS_HELP}",
    )
    label.add_argument("--map", default="all", help=f"{MAPS_HELP}; default: all")
    label.add_argument(
        "--challenge", type=int, choices=(1, 2), default=1, help="2: four variants of each map (default %(default)s)"
    )
    label.add_argument("--episodes", type=int, default=8, help="per map (%(default)s)")
    label.add_argument("--ticks", type=int, default=LIMIT_TICKS, help="limit of an episode (%(default)s)")
    label.add_argument("--seed", type=int, default=0, help="seed of the first episode (%(default)s)")
    _add_workers(label)
    add_out(label, "DIR", "folder for the recordings (%(default)s)", default=Path("data/corrections"))
    label.add_argument("--json", action="store_true", help="print one JSON document")
    proving = actions.add_parser(
        "prove",
        help="list generated maps on which a pair of experts delivers everything",
        example="movingout demos prove --split training --count 1000 -o data/maps.txt",
    )
    proving.add_argument("--split", choices=SPLITS, default="training", help="whose seeds to try (%(default)s)")
    proving.add_argument("--count", type=int, default=100, help="maps of each mode in the whole file (%(default)s)")
    _add_workers(proving)
    add_out(proving, "FILE", "the list, continued if it exists (%(default)s)", default=Path("data/maps.txt"))
    proving.add_argument("--json", action="store_true", help="print one JSON document")
    official = actions.add_parser(
        "import",
        help="import official trajectories (same as `recordings import`)",
        example="movingout demos import trajectories -o data/official",
    )
    imports.configure(official)
    people = actions.add_parser(
        "people", help="list the scripted people and the families of partners", example="movingout demos people"
    )
    people.add_argument("--json", action="store_true", help="print one JSON document")


def _add_workers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: all cores)")
    parser.add_argument("--ray", default="", metavar="auto|ADDRESS", help="play on a Ray cluster (extra `cluster`)")


def run(args: argparse.Namespace) -> int:
    """Dispatch."""
    perform = {
        "generate": _generate,
        "label": _label,
        "prove": _prove,
        "import": imports.perform,
        "people": _people,
    }
    return perform[args.action](args)


def _people(args: argparse.Namespace) -> int:
    if args.json:
        print(json.dumps({**manifest(), "families": _families()}))
        return 0
    print("name  habits        as an agent")
    for name in POPULATIONS:
        for person in population(name):
            print(f"{person.name:4}  {person.sha256[:12]}  {person.agent_id}")
    for family in _all_families():
        print(f"\nfamily:{family.name}: {family.about}{'' if family.trains else '; for measuring only'}")
        if not family.members:
            print(f"(none is trained here: {family.ids[0]}, …; see docs/learning.md)")
        for partner in family.members:
            print(f"{partner.name}  {partner.agent_id}")
    return 0


def _families() -> dict[str, object]:
    """The families for `demos people --json`."""
    return {
        family.name: {
            "about": family.about,
            "trains": family.trains,
            "members": [{"name": partner.name, "id": partner.agent_id} for partner in family.members],
        }
        for family in _all_families()
    }


def _all_families() -> Iterator[Family]:
    """Ours, then those of installed packages; a sentence about one that cannot be loaded."""
    yield from families().values()
    for name in installed_families():
        try:
            yield family_of(name)
        except AgentError as error:
            print(f"movingout: left out: {error}", file=sys.stderr)


def _players(who: str) -> Sequence[Player]:
    """The players that `--population` names. Raises DataError for an unknown name."""
    if who in POPULATIONS:
        return population(who)
    if not is_group(who):
        known = [*POPULATIONS, *(FAMILY + name for name in (*families(), *installed_families())), ALL, "@FILE"]
        raise DataError(f"unknown population {who!r}; {known_names(who, known)}")
    try:
        for agent_id in to_try(who):  # fail now rather than in some episode
            load_agent(agent_id)
        return group(who)
    except AgentError as error:
        raise DataError(f"--population: {error}") from error


def _short(who: str) -> str:
    """`--population` as the names of files begin with it."""
    return Path(who.removeprefix(LIST)).stem if who.startswith(LIST) else who.replace(":", "-")


def _generate(args: argparse.Namespace) -> int:
    players = _players(args.population)
    most = len(players) - len(players) % 2
    count = most if args.people is None else args.people
    if args.population.startswith(LIST) and len(players) % 2 and (args.people is None or most < 2):
        raise DataError(f"{args.population} names {counted(len(players), 'partner')}; pairs take an even number")
    if count < 2 or count > most or count % 2:
        raise DataError(f"--people must be an even number from 2 to {most}, not {count}")
    _check_counts(args)
    if args.variants < 0 or (args.variants and args.challenge == 1):
        raise DataError("--variants is a number of episodes per map for --challenge 2")
    if args.split and args.challenge == 1:
        raise DataError("--split is of variants, which --challenge 2 has")
    people = players[:count]
    prefix = f"{_short(args.population)}{args.challenge}s{args.seed}"
    if args.variants and args.challenge == 2:
        designed = _designed(args)
        todo = variant_jobs(people, designed, args.variants, args.ticks, args.seed, prefix, _split(args))
    else:
        todo = episode_jobs(people, _maps(args), args.episodes, args.ticks, args.seed, prefix)
    _caution((job.map.name for job in todo), selected_maps(args.map))
    other = _say_other_code(todo, args.out)
    for sentence in folder_sentences(todo, args.out):
        print(f"movingout: {sentence}", file=sys.stderr)
    made = _with_progress(len(todo), write_all(todo, args.out, args.workers, args.ray))
    write_output(args.out / "people.json", json.dumps(manifest(), indent=1).encode())
    if args.json:
        about = {
            **_counts(made, args.out, len(todo)),
            "other_code": other,
            "mean_tcr": _mean_tcr(made) if made else None,
        }
        print(json.dumps({**about, "tcr": _per_map(made)}))
    else:
        print(_summary(made, args.out, len(todo) - len(made)))
    return 0


def _label(args: argparse.Namespace) -> int:
    _check_counts(args)
    maps = _maps(args)
    if args.population in ("A", "B", "AB"):
        partners = [(person.name, person.agent_id) for name in args.population for person in population(name)]
        order = [partners[k * 7 % len(partners)] for k in range(len(partners))]  # A and B in turn
    else:
        players = [(player.name, player.agent_id) for player in _players(args.population)]
        order = shuffled_partners(players, len(maps) * args.episodes, args.seed)
    if caution := test_people_caution([args.population]):
        print(f"movingout: {caution}", file=sys.stderr)
    todo = labelling_jobs(maps, order, args.learner, args.expert, args.episodes, args.ticks, args.seed)
    _caution((job.map.name for job in todo), selected_maps(args.map))
    other = _say_other_code(todo, args.out)
    made = _with_progress(len(todo), label_all(todo, args.out, args.workers, args.ray))
    if args.json:
        print(json.dumps({**_counts(made, args.out, len(todo)), "other_code": other, "tcr": _per_map(made)}))
    else:
        print(_summary(made, args.out, len(todo) - len(made)))
        for line in _group_lines(made):
            print(line)
    return 0


def _prove(args: argparse.Namespace) -> int:
    if args.count < 1 or args.workers < 1:
        raise DataError("--count and --workers must be at least 1")
    _caution([f"{PREFIX}:{args.split}"])
    if args.ray:
        connect(args.ray)
    workers = processors() if args.ray else args.workers
    tried = solved = 0
    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("maps", total=None)
        for _, ticks in prove(args.split, args.out, args.count, workers, args.ray):
            tried, solved = tried + 1, solved + (ticks is not None)
            progress.update(bar, completed=tried, description=f"{solved} of {tried} maps solved")
    has = maps_per_mode(args.out)
    if args.json:
        print(json.dumps({"out": str(args.out), "tried": tried, "solved": solved, "maps": has}))
    else:
        listed = ", ".join(f"{count} of {mode}" for mode, count in has.items())
        print(f"{solved} of {tried} maps tried were solved; {args.out} has {listed}")
    return 0


def _check_counts(args: argparse.Namespace) -> None:
    if args.episodes < 1 or args.ticks < 1 or args.workers < 1:
        raise DataError("--episodes, --ticks and --workers must be at least 1")
    if args.ticks > MAX_TICKS or not 0 <= args.seed <= MAX_SEED:
        raise DataError(f"--ticks is at most {MAX_TICKS}, and --seed is a whole number from 0 to {MAX_SEED}")


def _caution(maps: Iterable[str], asked: Iterable[str] = ()) -> None:
    """Say so when test maps are among those played, as demonstrations are there to be trained on.

    Also say what is wrong with map files among those that were asked for.
    """
    for sentence in filter(None, [test_maps_caution(maps), *map_cautions(asked)]):
        print(f"movingout: {sentence}", file=sys.stderr)


def _say_other_code(todo: Sequence[EpisodeJob | LabellingJob], out: Path) -> int:
    """How many episodes of other code of ours are kept, which is said."""
    if other := of_other_code(todo, out):
        what = f"{counted(other, 'episode')} in {out} {'were' if other != 1 else 'was'}"
        print(
            f"movingout: {what} made with other code of this project; to make all with the present code, use an empty "
            "folder",
            file=sys.stderr,
        )
    return other


def _counts(made: list[WrittenEpisode], out: Path, wanted: int) -> dict[str, object]:
    """How many episodes were made, which alone have rates here, and how many were there already."""
    return {"out": str(out), "episodes": len(made), "already": wanted - len(made)}


def _mean_tcr(made: list[WrittenEpisode]) -> float:
    return sum(one.tcr for one in made) / len(made)


def _summary(made: list[WrittenEpisode], out: Path, before: int) -> str:
    kept = f"; {before} were there already" if before else ""
    if not made:
        return f"nothing new in {out}{kept}"
    return f"wrote {counted(len(made), 'episode')} to {out}, mean TCR {_mean_tcr(made):.2f}{kept}"


def _per_map(made: list[WrittenEpisode]) -> dict[str, float]:
    names = sorted({one.map for one in made})
    rates = {name: [one.tcr for one in made if one.map == name] for name in names}
    return {name: round(sum(values) / len(values), 3) for name, values in rates.items()}


def _group_lines(made: Iterable[WrittenEpisode]) -> Iterator[str]:
    """A line for each map with its symmetries, and for the generated maps of each mode."""
    groups: dict[str, list[WrittenEpisode]] = {}
    for one in sorted(made, key=lambda episode: episode.map):
        groups.setdefault(_group_of(one.map), []).append(one)
    for name, episodes in groups.items():
        rate = sum(one.tcr for one in episodes) / len(episodes)
        maps = len({one.map for one in episodes})
        counts = f"{counted(len(episodes), 'episode')}{f' on {maps} maps' if maps > 1 else ''}"
        yield f"  {name:21}  TCR {rate:.2f}  {counts}"


def _group_of(map_name: str) -> str:
    """The map without its symmetries; of a generated one `generated:MODE`."""
    if is_generated(map_name):
        return SEPARATOR.join(map_name.split(SEPARATOR)[:2])
    return split_name(map_name)[0]


def _designed(args: argparse.Namespace) -> list[MapSpec]:
    """Raises AgentError for a map on which nothing can be played."""
    maps = [load_map(name) for name in selected_maps(args.map)]
    for the_map in maps:
        check_undelivered(the_map)
    return maps


def _maps(args: argparse.Namespace) -> list[MapSpec]:
    maps = _designed(args)
    if args.challenge == 1:
        return maps
    return [randomize(the_map, args.seed + variant, _split(args)) for variant in range(4) for the_map in maps]


def _split(args: argparse.Namespace) -> Split:
    """Of variants; `label` has no other."""
    split: Split = getattr(args, "split", None) or "train"
    return split


def _with_progress(total: int, episodes: Iterator[WrittenEpisode]) -> list[WrittenEpisode]:
    made: list[WrittenEpisode] = []
    with Progress(console=Console(stderr=True)) as progress:
        bar = progress.add_task("episodes", total=total)
        for one in episodes:
            made.append(one)
            progress.advance(bar)
    return made
