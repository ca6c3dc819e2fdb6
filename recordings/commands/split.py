"""`movingout recordings split`: divides recordings into groups that share no participant."""

import argparse

from movingout.maps.commands.parser import add_json, add_out
from movingout.maps.files.terminal import printable
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import (
    add_challenge,
    add_paths,
    add_styles,
    expanded,
    print_json,
)
from movingout.recordings.commands.selection import left_out_words
from movingout.recordings.errors import RecordingError
from movingout.recordings.groups import (
    GroupedRecording,
    group_sentences,
    grouped,
    grouped_by_style,
    of_challenge,
    write_groups,
)
from movingout.recordings.spreadsheet import check_name
from movingout.recordings.storage.copies import without_copies
from movingout.recordings.styles import given_styles


def configure(parser: argparse.ArgumentParser) -> None:
    add_paths(parser)
    parser.add_argument("--groups", type=int, default=2, metavar="N", help="how many groups (%(default)s)")
    parser.add_argument(
        "--by",
        choices=("participant", "style"),
        default="participant",
        help="participant (default): drawn at random; style: a group for each style, whatever --groups says",
    )
    add_styles(parser)
    parser.add_argument("--seed", type=int, default=0, help="seed of the division (%(default)s)")
    parser.add_argument(
        "--min-tcr", type=float, default=0.0, metavar="TCR", help="leave out episodes in which less was delivered"
    )
    add_challenge(parser)
    add_out(parser, "FILE.csv", "the list, for `movingout train --manifest FILE.csv --group 1`", required=True)
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Write the list and say what is in it. Raises RecordingError."""
    if args.groups < 1 or args.seed < 0 or not 0.0 <= args.min_tcr <= 1.0:
        raise RecordingError("--groups is at least 1, --seed at least 0, and --min-tcr from 0 to 1")
    check_name(args.out)
    found = expanded(args.paths)
    once = without_copies(found)  # of all: a recording and an import of it may be of different challenges
    chosen = of_challenge(once, args.challenge) if args.challenge else once
    styles = given_styles(args.styles, args.by)
    if args.by == "style":
        rows, names = grouped_by_style(found, styles, args.min_tcr, chosen)
    else:
        rows, names = grouped(found, args.groups, args.seed, args.min_tcr, chosen), []
    write_groups(args.out, rows)
    if args.json:
        print_json({"file": str(args.out), "styles": names, "recordings": [_document(row) for row in rows]})
        return 0
    left_out = f"; {len(found) - len(rows)} left out" if len(found) > len(rows) else ""
    left_out += f", {words[0]} among them" if (words := left_out_words(0, len(found) - len(once))) else ""
    print(f"{counted(len(rows), 'recording')} in {args.out}{left_out}")
    print("\n".join(printable(sentence) for sentence in group_sentences(rows, names)))
    return 0


def _document(row: GroupedRecording) -> dict[str, object]:
    return row._asdict() | {"path": str(row.path)}
