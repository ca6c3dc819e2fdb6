"""`movingout match report DIR...`: compares results folders with the paper's tables."""

import argparse
import json
from pathlib import Path

from movingout.maps.commands.parser import add_out
from movingout.maps.files.terminal import printable_lines
from movingout.matches.grid_run import open_run
from movingout.matches.report.comparison import json_report, markdown_report
from movingout.matches.results.results_folder import write_whole
from movingout.recordings.report.words import DEFAULT, LANGUAGES


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="results folders written by `match grid`")
    add_out(parser, "FILE.md", "write the report to a file instead of printing it")
    parser.add_argument("--language", choices=LANGUAGES, default=DEFAULT, help=f"language of the report ({DEFAULT})")
    parser.add_argument("--json", action="store_true", help="one JSON document on standard output")
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    runs = [open_run(folder) for folder in args.folders]
    if args.json:
        print(json.dumps(json_report(runs), indent=2))
    elif args.out is not None:
        write_whole(args.out, markdown_report(runs, args.language))
        print(f"written to {args.out}")
    else:
        print(printable_lines(markdown_report(runs, args.language)))
    return 0
