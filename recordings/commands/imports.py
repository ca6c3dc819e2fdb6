"""`movingout recordings import`: official trajectories become recordings, with a report."""

import argparse
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import get_args

from movingout.maps.commands.parser import add_json, add_out
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.recordings.commands.arguments import add_data, positive, print_json
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.imports.convert import AGREE, ImportReport, PlayerKind, import_source, names_people
from movingout.recordings.imports.known_plays import known_plays
from movingout.recordings.imports.map_match import maps_of
from movingout.recordings.imports.participants import read_participants, with_participants
from movingout.recordings.imports.sources import read_all, without_copies
from movingout.recordings.progress import map_in_processes
from movingout.world.constants import LIMIT_TICKS, MAX_TICKS

PUBLIC_SALT = "movingout"
GUESSED = "whoever guesses a name can check it by its pseudonym; import with a secret --salt, into a new folder"
NAMELESS = "no participant-disjoint split is possible; name them with --participants, into a new folder"


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths",
        nargs="+",
        type=Path,
        metavar="FILE|DIR",
        help="the official recorder's or evaluator's .json, or data set rows as .parquet, .json or .jsonl",
    )
    add_data(parser)
    add_out(parser, "DIR", "where the recordings go (default: DATA/recordings)")
    parser.add_argument(
        "--salt",
        default=PUBLIC_SALT,
        metavar="SECRET",
        help="your secret text for turning names into pseudonyms (default: a word that everybody knows, %(default)s)",
    )
    parser.add_argument(
        "--kind",
        choices=get_args(PlayerKind),
        default="",
        help="who played (default: as the file says, else agents in the evaluator's files and people in others)",
    )
    parser.add_argument(
        "--participants",
        type=Path,
        metavar="FILE.csv",
        help="who played, where the files do not say it: trajectory_id,blue,red",
    )
    parser.add_argument(
        "--limit-ticks",
        type=positive,
        default=LIMIT_TICKS,
        metavar="N",
        help="after how many ticks an episode was out of time, where the file does not say it (default: %(default)s)",
    )
    parser.add_argument("--workers", type=positive, default=os.cpu_count() or 1, help="processes (default: all cores)")
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Exit code 1 when a trajectory was refused. Raises RecordingError."""
    folder = args.out or args.data / "recordings"
    _make(folder)
    found, others = read_all(args.paths)
    for file in others:
        tell(printable(f"left out: {file}, which has no trajectories"))
    if args.participants is not None:
        found = with_participants(found, read_participants(args.participants))
    sources = without_copies(found)
    if args.salt == PUBLIC_SALT and any(names_people(source, args.kind) for source in sources):
        tell(GUESSED)
    known = known_plays(folder, maps_of(sources), args.workers)
    if args.limit_ticks > MAX_TICKS:
        raise RecordingError(f"--limit-ticks is at most {MAX_TICKS}")
    convert = partial(
        import_source, folder=folder, salt=args.salt, kind=args.kind, known=known, limit_ticks=args.limit_ticks
    )
    reports = list(map_in_processes(convert, sources, args.workers, "importing"))
    if args.json:
        trajectories = [report.to_json() for report in reports]
        print_json({"folder": str(folder), "copies": len(found) - len(sources), "trajectories": trajectories})
    else:
        print("\n".join(map(printable, _page(reports, folder, len(found) - len(sources)))))
    return int(any(report.problem for report in reports))


def _make(folder: Path) -> None:
    """Make the folder, so that one that cannot be written is reported before the work."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot("write to", folder, error) from error
    if not os.access(folder, os.W_OK):
        raise RecordingError(f"cannot write to {folder}; change its permissions, or choose another folder: --out DIR")


def _page(reports: Sequence[ImportReport], folder: Path, copies: int) -> list[str]:
    made = [report for report in reports if not report.problem]
    new = [report for report in made if not report.unchanged]
    lines = [f"{len(new)} of {len(reports)} trajectories imported into {folder}"]
    lines += [f"  {r.file}, {r.place}: {r.unchanged}" for r in made if r.unchanged]
    lines += [f"  copies: {copies} more, of trajectories that are among these, were left out"] if copies else []
    lines += [f"  refused: {r.file}, {r.place}: {r.problem}" for r in reports if r.problem]
    if not made:
        return lines
    exact = sum(report.drift_tick < 0 for report in made)
    nameless = sum(not report.participants_known for report in made)
    return [
        *lines,
        f"  replay: {exact} re-simulate exactly, {len(made) - exact} drift (largest {max(r.drift for r in made):.3g})",
        *_maps(made),
        f"  actions: magnitude up to {max(r.largest_magnitude for r in made):.3g}, "
        f"angle up to {max(r.largest_angle for r in made):.3g} rad",
        f"  grasp: {sum(r.presses for r in made)} presses, {sum(r.idle_presses for r in made)} of them without effect, "
        f"{sum(r.unpressed_changes for r in made)} changes without a press, "
        f"{sum(r.inferred_holds for r in made)} held items inferred",
        f"  positions outside the arena: {sum(r.outside for r in made)}",
        f"  last tick: {sum(r.last_tick == 'simulated' for r in made)} simulated, "
        f"{sum(r.last_tick == 'left out' for r in made)} left out",
        *_stopped(new),
        *([f"  ! {nameless} name no participants: {NAMELESS}"] if nameless else []),
        *_drifting(made),
    ]


def _maps(made: Sequence[ImportReport]) -> list[str]:
    """How many are on a map as designed, and by what the others differ, one line per map."""
    changed, varied = (sum(map(bool, flags)) for flags in ([r.differences for r in made], [r.varied for r in made]))
    hair = f", {changed - varied} of them by a hair: they count as designed" if changed > varied else ""
    lines = [f"  maps: {changed} differ from the map as designed{hair}"]
    for name in sorted({report.map for report in made if report.varied}):
        there = [report for report in made if report.varied and report.map == name]
        by = sorted({difference for report in there for difference in report.differences})
        more = f" and {len(by) - 3} more" if len(by) > 3 else ""
        lines.append(f"  ! {name}: {len(there)} count as varied (Challenge 2), by {', '.join(by[:3])}{more}")
    return lines


def _stopped(new: Sequence[ImportReport]) -> list[str]:
    """What reports leave out of their averages: it may have been delivered in the last tick, or had a shorter limit."""
    stopped = [report for report in new if report.outcome == "stopped" and not report.outcome_known]
    limits = [report.limit_ticks for report in stopped if report.last_tick != "left out"]
    lines = []
    if cut := len(stopped) - len(limits):
        said = "they may have been delivered in that tick, and are left out of averages"
        lines.append(f"  ! {cut} ended undelivered without their last tick, which does not re-simulate: {said}")
    if limits:
        limit = " or ".join(str(ticks) for ticks in sorted(set(limits)))
        said = "their limit was shorter? Import them into a new folder with --limit-ticks"
        lines.append(f"  ! {len(limits)} ended undelivered before {limit} ticks, and are left out of averages: {said}")
    return lines


def _drifting(made: Sequence[ImportReport]) -> list[str]:
    """The trajectories that our world does not reproduce, one line each."""
    return [
        f"  drifts: {r.file}, {r.place} ({r.map}) from tick {r.drift_tick}, {_how_far(r)}"
        for r in made
        if r.drift_tick >= 0
    ]


def _how_far(report: ImportReport) -> str:
    """Positions agree where a file has its angles in degrees, say."""
    return f"up to {report.drift:.3g}" if report.drift > AGREE else "in angles [rad] or hands alone"
