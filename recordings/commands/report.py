"""`movingout recordings report`: a folder of recordings as one offline page."""

import argparse
import json
import os
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from movingout.maps.commands.parser import add_out
from movingout.maps.files.map_versions import one_name_sentence
from movingout.maps.files.terminal import printable
from movingout.maps.spec import SEAT_COLOURS, MapSpec
from movingout.maps.suggestion import counted
from movingout.recordings.commands.arguments import positive
from movingout.recordings.commands.selection import left_out_words, selected
from movingout.recordings.errors import RecordingError
from movingout.recordings.html_page import SERVER, check_name, write_html
from movingout.recordings.progress import map_in_processes
from movingout.recordings.report.facts import GROUPINGS, facts_of
from movingout.recordings.report.measures import MEASURES
from movingout.recordings.report.page import ReportPage
from movingout.recordings.report.tally import FailureFinding, Group, ReportTally
from movingout.recordings.report.words import DEFAULT, LANGUAGES, Words
from movingout.recordings.storage.listing import recordings_below
from movingout.world.estimates import Estimate

OUT = Path("report.html")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder with recordings in or below it")
    add_out(parser, "FILE", f"default: {OUT}", default=OUT)
    parser.add_argument(
        "--by", choices=tuple(GROUPINGS), default="agent", help="what makes a population (default: agent)"
    )
    parser.add_argument("--server", default=SERVER, metavar="URL", help=f"where replays open (default: {SERVER})")
    parser.add_argument("--language", choices=LANGUAGES, default=DEFAULT, help=f"language of the page ({DEFAULT})")
    parser.add_argument("--workers", type=positive, default=os.cpu_count() or 1, help="processes (default: all cores)")
    parser.add_argument("--json", action="store_true", help="also print the figures as one JSON document")
    parser.set_defaults(perform=report)


def report(args: argparse.Namespace) -> int:
    """Raises RecordingError."""
    if urlsplit(args.server).scheme not in ("http", "https"):
        raise RecordingError(f"{args.server!r} is not the address of a server; it should look like {SERVER}")
    check_name(args.out)
    paths = recordings_below(args.folder)
    if not paths:
        raise RecordingError(f"there are no recordings in {args.folder}; name a folder with .mcap files")
    chosen = selected(paths)
    workers = max(min(args.workers, len(chosen.paths)), 1)
    facts = map_in_processes(partial(facts_of, grouping=args.by), chosen.paths, workers, "reading")
    tally = ReportTally.of(facts, chosen.uncounted, chosen.copies)
    write_html(ReportPage(args.folder.resolve().name, args.server, tally, Words(args.language)).html(), args.out)
    if args.json:
        print(json.dumps(_document(args.out, tally), indent=2))
    else:
        print(_sentence(args.out, tally))
        for name, firsts in tally.maps_of_one_name.items():
            print(printable(one_name_sentence(name, firsts)))
    return 0


def _sentence(out: Path, tally: ReportTally) -> str:
    left_out = [f"{tally.unfinished} unfinished"] if tally.unfinished else []
    left_out += [f"{len(tally.unreadable)} unreadable"] if tally.unreadable else []
    rest = f" ({', '.join(left_out)}: listed there)" if left_out else ""
    others = left_out_words(tally.uncounted, tally.copies)
    rest += f"; left out: {', '.join(others)}" if others else ""
    return f"wrote {out}: {counted(tally.episodes, 'episode')}, {counted(len(tally.found), 'failure case')}{rest}"


def _document(out: Path, tally: ReportTally) -> dict[str, Any]:
    return {
        "report": str(out),
        "episodes": tally.episodes,
        "broken_off": tally.unfinished,
        "uncounted": tally.uncounted,
        "copies": tally.copies,
        "pooled": tally.pooled,
        "maps_of_one_name": tally.maps_of_one_name,
        "unreadable": [{"path": str(one.path), "problem": one.problem} for one in tally.unreadable],
        "groups": [_group(spec, group) for spec, groups in tally.by_map() for group in groups],
        "failures": [_found(one) for one in tally.found],
    }


def _group(spec: MapSpec, group: Group) -> dict[str, Any]:
    measures = {name: _estimate(group.estimate(name)) for name in MEASURES}
    blue, red = group.population
    return {
        "map": spec.name,
        "challenge": group.challenge,
        "blue": blue,
        "red": red,
        "episodes": group.n,
        "distinct": group.distinct,
        **measures,
    }


def _estimate(found: Estimate | None) -> dict[str, float | int | None] | None:
    return None if found is None else found._asdict()


def _found(one: FailureFinding) -> dict[str, Any]:
    facts, failure = one
    return {
        "case": failure.case,
        "id": facts.id,
        "map": facts.map.name,
        "seat": SEAT_COLOURS[failure.seat],
        "who": one.who,
        "item": failure.item,
        "start": failure.start,
        "end": failure.end,
        "detail": Words().phrase(failure.detail),
    }
