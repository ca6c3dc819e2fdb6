"""`movingout recordings list`: the recordings in a folder, newest first."""

import argparse
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import get_args

from movingout.maps.commands.parser import add_json
from movingout.maps.commands.sentences import tell
from movingout.maps.files.terminal import printable
from movingout.recordings.commands.arguments import MOST_NAMED, add_data, data_folder, places_below, print_json
from movingout.recordings.episode import Outcome
from movingout.recordings.storage.index import Filter, list_recordings
from movingout.recordings.storage.listing import Summary, Unreadable, recording_paths
from movingout.world.constants import TICKS_PER_SECOND

_HOW_TO_RECORD = """Two ways to change that:
  movingout play                                                            people play in the browser
  movingout match --blue scripted --red scripted --record data/recordings   agents play"""
_HEADINGS = ("id", "started (UTC)", "map", "blue", "red", "time", "delivered", "TCR", "outcome")


def configure(parser: argparse.ArgumentParser) -> None:
    add_data(parser)
    parser.add_argument("folder", nargs="?", type=Path, help="default: DATA/recordings")
    parser.add_argument("--map", help="only this map, by its name or title")
    parser.add_argument("--agent", help="only with this agent or participant in a seat (part of the name)")
    parser.add_argument("--study", help="only of this study")
    parser.add_argument("--since", type=_day, metavar="DATE", help="only from this day on (2026-11-20)")
    parser.add_argument("--until", type=_day, metavar="DATE", help="only up to and including this day")
    parser.add_argument("--outcome", choices=get_args(Outcome), metavar="HOW", help=", ".join(get_args(Outcome)))
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Print the recordings, and what cannot be read. Raises RecordingError."""
    folder = args.folder or data_folder(args) / "recordings"
    nothing = not (args.folder or folder.exists()) or not recording_paths(folder)
    wanted = Filter(args.map, args.agent, args.study, args.since, args.until, args.outcome)
    found, unreadable = ([], []) if nothing else list_recordings(folder, wanted)
    if args.json:
        problems = [{"path": str(entry.path), "problem": entry.problem} for entry in unreadable]
        print_json({"recordings": [entry.to_json() for entry in found], "unreadable": problems})
        return 0
    if nothing:
        print(_nothing_in(folder))
    else:
        print(_table(found) if found else _no_match(folder, wanted))
    for entry in unreadable:
        tell(printable(_with_folder(entry)))
    return 0


def _nothing_in(folder: Path) -> str:
    """The message where no recording lies in a folder itself; says in which below there are some."""
    if not (below := places_below(folder)):
        return f"Nothing has been recorded yet in {printable(str(folder))}. {_HOW_TO_RECORD}"
    return printable(f"No recordings in {folder} itself; {below}")


def _with_folder(entry: Unreadable) -> str:
    """What is wrong with a file, with the whole path: another folder may have a file of that name."""
    name, problem = entry.path.name, entry.problem
    if problem.startswith(name):
        return f"{entry.path}{problem.removeprefix(name)}"
    return problem if str(entry.path) in problem else f"{entry.path}: {problem}"


def _table(entries: Sequence[Summary]) -> str:
    """Columns as wide as their contents: for eyes and for `grep` alike."""
    rows = [_HEADINGS, *(tuple(map(printable, _row(entry))) for entry in entries)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADINGS))]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def _no_match(folder: Path, wanted: Filter) -> str:
    """The message when nothing matches; names the maps and players that there are."""
    entries, _ = list_recordings(folder)
    maps = sorted({entry.title or entry.map for entry in entries})
    seats = sorted({seat for entry in entries for seat in (entry.blue, entry.red)})
    hints = []
    if wanted.map is not None and wanted.map not in {*maps, *(entry.map for entry in entries)}:
        hints.append(f"no map {wanted.map!r}; maps here: {', '.join(maps)}")
    if wanted.agent is not None and not any(wanted.agent in seat for seat in seats):
        hints.append(f"nobody named {wanted.agent!r}; here played: {', '.join(seats[:MOST_NAMED])}")
    return "\n  ".join(["no recordings that match", *hints])


def _day(text: str) -> str:
    """A day in ISO format, to be compared with the start of recordings."""
    try:
        return date.fromisoformat(text).isoformat()
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text!r} is no day; write it like 2026-11-20") from error


def _row(entry: Summary) -> tuple[str, ...]:
    return (
        entry.id,
        entry.started[:16].replace("T", " "),
        (entry.title or entry.map) + (f" ({entry.variant})" if entry.variant else ""),
        entry.blue,
        entry.red,
        f"{entry.ticks / TICKS_PER_SECOND:.1f} s",
        f"{entry.metrics['delivered']:.0f} of {entry.metrics['items']:.0f}",
        f"{entry.metrics['tcr']:.2f}",
        entry.outcome + (" (damaged)" if entry.damage else ""),
    )
