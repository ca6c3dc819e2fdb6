"""`movingout recordings`: list, inspect and recover here; the other actions have modules of their own."""

import argparse
import sys
from collections.abc import Callable, Sequence
from datetime import date
from pathlib import Path
from typing import get_args

from movingout.maps.commands.parser import add_json
from movingout.maps.files.terminal import printable
from movingout.recordings.commands import diversity, exports, failures, imports, upload, verify
from movingout.recordings.commands import report as report_command
from movingout.recordings.commands import split as split_command
from movingout.recordings.commands import view as viewer_command
from movingout.recordings.commands.arguments import MOST_NAMED, USUAL_DATA, add_data, places_below, print_json
from movingout.recordings.commands.info_page import info_json, info_page
from movingout.recordings.diversity.augmented import Recombination
from movingout.recordings.episode import Outcome
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.journal import JOURNAL_SUFFIX
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.storage.finished import SUFFIX, Recovery, recover, recover_journal
from movingout.recordings.storage.index import Filter, list_recordings, path_of
from movingout.recordings.storage.listing import Summary, Unreadable, recording_paths
from movingout.recordings.storage.repair import damaged_below, recover_recording
from movingout.world.constants import TICKS_PER_SECOND


def configure(parser: argparse.ArgumentParser, recombination: Callable[[], Recombination] | None = None) -> None:
    """`recombination`, called when it is needed, offers `diversity --augmented`."""
    commands = parser.add_subparsers(dest="action", metavar="COMMAND", required=True, title="commands")

    listing = commands.add_parser(
        "list", help="the recordings in a folder, newest first", example="movingout recordings list --map HandOff"
    )
    add_data(listing)
    listing.add_argument("folder", nargs="?", type=Path, help="default: DATA/recordings")
    listing.add_argument("--map", help="only this map, by its name or title")
    listing.add_argument("--agent", help="only with this agent or participant in a seat (part of the name)")
    listing.add_argument("--study", help="only of this study")
    listing.add_argument("--since", type=_day, metavar="DATE", help="only from this day on (2026-11-20)")
    listing.add_argument("--until", type=_day, metavar="DATE", help="only up to and including this day")
    listing.add_argument("--outcome", choices=get_args(Outcome), metavar="HOW", help=", ".join(get_args(Outcome)))
    add_json(listing)
    listing.set_defaults(perform=_list)

    info = commands.add_parser("info", help="one recording on a page", example="movingout recordings info game.mcap")
    info.add_argument("recording", help="a file, or an episode id in DATA/recordings")
    add_data(info)
    add_json(info)
    info.set_defaults(perform=_info)

    verify.configure(
        commands.add_parser(
            "verify",
            help="re-simulate and compare bit for bit; exit code 1 on a divergence",
            example="movingout recordings verify data/recordings",
        )
    )

    rescue = commands.add_parser(
        "recover",
        help="finish what a crash left behind; save the intact part of a damaged file",
        example="movingout recordings recover --data data",
    )
    rescue.add_argument("paths", nargs="*", type=Path, metavar="FILE|DIR", help="default: DATA/recordings")
    rescue.add_argument(
        "--all", action="store_true", help="in folders, end rounds, too, that a server goes on with when started again"
    )
    add_data(rescue)
    add_json(rescue)
    rescue.set_defaults(perform=_recover)

    viewer_command.configure(
        commands.add_parser(
            "view",
            help="look at recordings in 3D, or write one as a page",
            example="movingout recordings view game.mcap",
        )
    )
    report_command.configure(
        commands.add_parser(
            "report",
            help="a folder's results, heat maps and failures on one page",
            example="movingout recordings report data/recordings -o report.html",
        )
    )
    failures.configure(
        commands.add_parser(
            "failures",
            help="how often the paper's failure cases occur, by rules and as annotators confirm them",
            example="movingout recordings failures data/recordings -o findings.csv",
        )
    )
    diversity.configure(
        commands.add_parser(
            "diversity",
            help="how differently they were played: the paper's measures, and pictures of positions",
            example="movingout recordings diversity data/recordings --by group -o diversity",
        ),
        recombination,
    )

    split_command.configure(
        commands.add_parser(
            "split",
            help="divide them into groups of participants, for training",
            example="movingout recordings split data/recordings --groups 2 -o data/groups.csv",
        )
    )
    exports.configure(
        commands.add_parser(
            "export",
            help="write them in another format",
            example="movingout recordings export data/recordings --to parquet -o training",
        )
    )
    upload.configure(
        commands.add_parser(
            "upload",
            help="send what a bucket of an S3-compatible store does not have yet",
            example="movingout recordings upload s3://lab/study --data data",
        )
    )
    imports.configure(
        commands.add_parser(
            "import",
            help="read official trajectories, with a report",
            example="movingout recordings import trajectories -o data/official",
        )
    )


def run(args: argparse.Namespace) -> int:
    perform: Callable[[argparse.Namespace], int] = args.perform
    return perform(args)


# ---- list and info -----------------------------------------------------------------------------------------


def _list(args: argparse.Namespace) -> int:
    folder = args.folder or _data(args) / "recordings"
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
        print(f"movingout: {printable(_with_folder(entry))}", file=sys.stderr)
    return 0


def _data(args: argparse.Namespace) -> Path:
    """The data folder; only the usual one may be missing, before the first game. Raises RecordingError."""
    data: Path = args.data
    if data != USUAL_DATA and not data.exists():
        raise RecordingError(f"there is no folder {data}; --data names one")
    return data


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


_HOW_TO_RECORD = """Two ways to change that:
  movingout play                                                            people play in the browser
  movingout match --blue scripted --red scripted --record data/recordings   agents play"""
_HEADINGS = ("id", "started (UTC)", "map", "blue", "red", "time", "delivered", "TCR", "outcome")


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


def _info(args: argparse.Namespace) -> int:
    path = Path(args.recording)
    if not path.exists():
        path = path_of(args.data / "recordings", args.recording)
    episode = read_episode(path)
    if args.json:
        print_json(info_json(path, episode))
    else:
        print("\n".join(map(printable, info_page(path, episode).splitlines())))
    return 0


# ---- recover -----------------------------------------------------------------------------------------------


_RECOVER_FAILED = 2  # as for a file that is named and cannot be recovered


def _damaged(folder: Path) -> list[Recovery]:
    """A folder that cannot be listed is one more problem: what was recovered before is told all the same."""
    try:
        return damaged_below(folder)
    except RecordingError as error:
        return [Recovery(folder, None, 0, str(error), failed=True)]


def _recovered(path: Path, also_waiting: bool) -> list[Recovery]:
    """What became of a journal, a finished file, or a folder's journals and those below, and what is damaged there.

    Raises RecordingError for other files.
    """
    if path.is_dir():
        return recover(path, also_waiting) + _damaged(path)
    if path.name.endswith(JOURNAL_SUFFIX):
        return [recover_journal(path)]
    if path.exists() and not path.name.endswith(SUFFIX):
        raise RecordingError(f"{path.name} is neither a recording (*{SUFFIX}) nor a journal (*{JOURNAL_SUFFIX})")
    return [recover_recording(path)]


def _recover(args: argparse.Namespace) -> int:
    done: list[Recovery] = []
    usual = _data(args) / "recordings"
    for path in args.paths or ([usual] if usual.exists() else []):
        try:
            done += _recovered(path, args.all)
        except RecordingError as error:  # the other files that were named are tried all the same
            done.append(Recovery(path, None, 0, str(error), failed=True))
    if args.json:
        print_json(
            {
                "journals": [
                    {
                        "journal": str(entry.journal),
                        "recording": str(entry.recording) if entry.recording else None,
                        "ticks": entry.ticks,
                        "note": entry.note,
                        "failed": entry.failed,
                    }
                    for entry in done
                ]
            }
        )
        return _RECOVER_FAILED if any(entry.failed for entry in done) else 0
    for entry in done:
        if entry.failed:
            where = "" if entry.note.startswith(entry.journal.name) else f"{entry.journal.name}: "
            print(printable(f"movingout: {where}{entry.note}"), file=sys.stderr)
            continue
        made = f" -> {entry.recording.name}" if entry.recording not in (None, entry.journal) else ""
        print(printable(f"{entry.journal.name}{made}: {entry.ticks} ticks, {entry.note}"))
    if not done:
        print("nothing to recover")
    return _RECOVER_FAILED if any(entry.failed for entry in done) else 0
