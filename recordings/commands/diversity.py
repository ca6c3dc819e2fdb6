"""`movingout recordings diversity`: the paper's measures of diversity, for any recordings."""

import argparse
import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from movingout.maps.commands.parser import add_json, add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.maps.spec import MapSpec
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import add_challenge, add_styles, positive, print_json
from movingout.recordings.commands.selection import left_out_words
from movingout.recordings.diversity.augmented import AugmentedSet, Recombination, augmented_sets, with_augmented
from movingout.recordings.diversity.comparison import (
    COUNTS,
    MapDiversity,
    PopulationDiversity,
    Sampling,
    compared,
    over_maps,
)
from movingout.recordings.diversity.episodes import (
    ALL,
    GROUPINGS,
    STYLE,
    PathEpisode,
    Populations,
    Reading,
    by_map,
    populations,
    read_paths,
    unnamed,
    with_maps_apart,
)
from movingout.recordings.diversity.measures import DEFAULT, DiversityOptions
from movingout.recordings.diversity.position_plot import STYLES, Style, save_plots
from movingout.recordings.diversity.table import Shares, map_table, method, population_json, population_table, write_csv
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.target import new_target
from movingout.recordings.styles import given_styles
from movingout.world.constants import MAX_SEED
from movingout.world.state import Floats

PIECES = 400  # that the engine tries per population and way, as `paper tables` at `small`


def configure(parser: argparse.ArgumentParser, recombination: Callable[[], Recombination] | None = None) -> None:
    """With `--augmented` where `recombination` is given, which is called when it is needed."""
    parser.add_argument(
        "paths",
        nargs="+",
        type=Path,
        metavar="FILE|DIR",
        help="recordings, folders of them, or the official files (.json, .jsonl, .parquet)",
    )
    parser.add_argument(
        "--by",
        choices=(*GROUPINGS, STYLE),
        default="place",
        help="what makes a population: the folder named (default), who played together, each of them, the agents, "
        "the kind of player, the source, or the style of play",
    )
    add_styles(parser)
    parser.add_argument("--map", help="only these maps, as HandOff,LeftRight")
    add_challenge(parser)
    parser.add_argument(
        "--counts", choices=COUNTS, default="equal", help="equal (default): as many episodes as the smallest has"
    )
    parser.add_argument("--draws", type=positive, default=10, help="subsamples to average over (default: 10)")
    parser.add_argument(
        "--seed", type=_seed, default=0, help="seed of the subsamples and of what is recombined, from 0 (0)"
    )
    parser.add_argument("--points", type=_points, default=DEFAULT.points, help=f"per path (default: {DEFAULT.points})")
    parser.add_argument("--grid", type=_grid, default=DEFAULT.grid, help=f"cells per side ({DEFAULT.grid})")
    parser.add_argument(
        "--bandwidth",
        type=_width,
        default=DEFAULT.bandwidth,
        help=f"kernel of the entropy's density, in arena units ({DEFAULT.bandwidth:g})",
    )
    parser.add_argument(
        "--rbf-width",
        type=_width,
        default=DEFAULT.rbf_width,
        help=f"kernel of the coverage, in arena units ({DEFAULT.rbf_width:g})",
    )
    parser.add_argument(
        "--plot",
        choices=STYLES,
        default="dots",
        help="what the pictures show of positions (default: dots, as the paper)",
    )
    add_out(parser, "DIR", "also write tables and a picture of positions per map into this new folder")
    parser.add_argument("--workers", type=positive, default=os.cpu_count() or 1, help="processes (default: all cores)")
    add_json(parser)
    if recombination:
        _add_augmented(parser)
    parser.set_defaults(perform=partial(perform, recombination=recombination))


def _add_augmented(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--augmented",
        action="store_true",
        help="also each population with recombined episodes, as agents learn from them, and how many pieces are valid",
    )
    parser.add_argument(
        "--pieces", type=positive, help=f"with --augmented: that the engine tries per population and way ({PIECES})"
    )


def perform(args: argparse.Namespace, recombination: Callable[[], Recombination] | None = None) -> int:
    """Raises RecordingError."""
    if args.out is not None and args.out.exists():
        raise RecordingError(f"{args.out} exists already and is not overwritten; choose another name")
    options = DiversityOptions(args.points, args.grid, args.bandwidth, args.rbf_width)
    sampling = Sampling(args.counts, args.draws, args.seed)
    augmenting = _augmenting(args, recombination)
    content = augmenting.content if augmenting else None
    reading = read_paths(args.paths, args.workers, by_place=args.by == "place", content=content)
    episodes, of_one_name = with_maps_apart(_wanted(reading, args.map, args.challenge))
    groups = populations(episodes, args.by, given_styles(args.styles, args.by))
    sets, lacking = augmented_sets(groups, augmenting, args.seed, args.pieces or PIECES) if augmenting else ([], [])
    by_maps = list(with_augmented(compared(groups, options, sampling), sets, options, sampling))
    overall = over_maps(by_maps)
    shares = {one.name: one.valid for one in sets} if augmenting else None
    words = " ".join((method(options, sampling), *of_one_name, *([augmenting.method] if augmenting else [])))
    if args.out is not None:
        _write(args.out, _panels(groups, sets), by_maps, overall, words, args.plot, shares)
    if args.json:
        tables = {
            "overall": [population_json(one, shares) for one in overall],
            "maps": [one.to_json() for one in by_maps],
            **({"not_recombined": lacking} if augmenting else {}),
        }
        nameless = len(unnamed(episodes, groups))
        print_json({**tables, "method": words, "left_out": _left_out(reading), "nameless": nameless})
    else:
        print(f"{population_table(overall, shares)}\n\n{map_table(by_maps)}\n\n{words}")
    for sentence in [*lacking, *_of_nobody(episodes, groups), *_remarks(args, reading, groups, overall)]:
        tell(printable(sentence))
    return 0


def _wanted(reading: Reading, maps: str | None, challenge: int | None) -> list[PathEpisode]:
    """The episodes of the wanted challenge on the wanted maps. Raises RecordingError when none is left."""
    if not reading.episodes:
        raise RecordingError(f"no finished episode was found ({', '.join(_left_out_words(reading))})")
    episodes = [one for one in reading.episodes if challenge in (None, 2 if one.map.variant else 1)]
    if not episodes:
        raise RecordingError(f"no finished episode is on maps {'as designed' if challenge == 1 else 'that are varied'}")
    names = sorted({one.map.name for one in episodes})
    wanted = names if maps is None else [name.strip() for name in maps.split(",")]
    if unknown := [name for name in wanted if name not in names]:
        raise RecordingError(f"no finished episode on {', '.join(unknown)}; maps here: {', '.join(names)}")
    return [one for one in episodes if one.map.name in wanted]


def _augmenting(args: argparse.Namespace, recombination: Callable[[], Recombination] | None) -> Recombination | None:
    """How to recombine where that is wanted. Raises RecordingError for options that count with it alone."""
    if recombination and args.augmented:
        return recombination()
    if recombination and args.pieces is not None:
        raise RecordingError("--pieces counts with --augmented alone")
    return None


Panels = dict[str, list[tuple[MapSpec, list[Floats]]]]  # the paths of each population, per map


def _panels(groups: Populations, sets: Sequence[AugmentedSet]) -> Panels:
    """Each population, and after it what recombination makes of it."""
    panels: Panels = {}
    for name, episodes in groups.items():
        panels[name] = [(spec, [one.path for one in there]) for spec, there in by_map(episodes)]
        for one in (one for one in sets if one.recorded == name):
            panels[one.name] = [(spec, one.paths[spec.name]) for spec, _ in panels[name]]
    return panels


def _write(
    target: Path,
    panels: Panels,
    by_maps: Sequence[MapDiversity],
    overall: Sequence[PopulationDiversity],
    words: str,
    style: Style,
    shares: Shares | None,
) -> None:
    with new_target(target) as part:
        part.mkdir()
        write_csv(part / "populations.csv", [population_json(one, shares) for one in overall])
        write_csv(part / "maps.csv", [one.to_json() for one in by_maps])
        pictures = save_plots(panels, part, style)
        shown = "\n".join(f"![{picture.stem}]({picture.name})" for picture in pictures)
        page = f"# Diversity\n\n{population_table(overall, shares)}\n\n{words}\n\n{map_table(by_maps)}\n\n{shown}\n"
        (part / "diversity.md").write_text(page, encoding="utf-8")


def _remarks(
    args: argparse.Namespace, reading: Reading, groups: Populations, overall: Sequence[PopulationDiversity]
) -> list[str]:
    """What a reader of the tables should know besides."""
    remarks = [f"left out: {', '.join(_left_out_words(reading))}"] if _left_out_words(reading) else []
    remarks += [one.problem for one in reading.unreadable]
    if len(groups) == 1 and args.by != "place":
        remarks.append(f"there is only one population by {args.by}, {next(iter(groups))}: nothing to compare it with")
    if not overall[0].maps:
        remarks.append("no map has three episodes of every population; name fewer populations, or another --by")
    if args.out is not None:
        remarks.append(f"wrote {args.out}: diversity.md, two tables and a picture per map")
    return remarks


def _of_nobody(episodes: Sequence[PathEpisode], groups: Populations) -> list[str]:
    """That some episodes are in no population, where some are."""
    count = len(unnamed(episodes, groups))
    if not count:
        return []
    names, are = ("names", "is") if count == 1 else ("name", "are")
    where = f"in “{ALL}” alone" if ALL in groups else "left out"
    return [f"{counted(count, 'episode')} {names} nobody and {are} {where}"]


def _left_out(reading: Reading) -> dict[str, int]:
    return {
        "unfinished": reading.unfinished,
        "tutorials": reading.tutorials,
        "unreadable": len(reading.unreadable),
        "uncounted": reading.uncounted,
        "copies": reading.copies,
    }


def _left_out_words(reading: Reading) -> list[str]:
    words = [f"{reading.unfinished} unfinished"] if reading.unfinished else []
    words += [counted(reading.tutorials, "tutorial")] if reading.tutorials else []
    words += [f"{len(reading.unreadable)} unreadable"] if reading.unreadable else []
    return words + left_out_words(reading.uncounted, reading.copies)


def _seed(text: str) -> int:
    return _whole(text, 0, MAX_SEED)


def _points(text: str) -> int:
    return _whole(text, 2, 1000)


def _grid(text: str) -> int:
    return _whole(text, 2, 500)


def _whole(text: str, least: int, most: int) -> int:
    try:
        value = int(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from error
    if not least <= value <= most:
        raise argparse.ArgumentTypeError(f"it must be from {least} to {most}")
    return value


def _width(text: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from error
    if not 0 < value < 100:
        raise argparse.ArgumentTypeError("a width is above 0 and below 100 arena units")
    return value
