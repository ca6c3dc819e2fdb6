"""`movingout recordings failures`: how often failure cases occur, by rules and as annotators confirm them."""

import argparse
import csv
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, NamedTuple

from movingout.maps.commands.parser import add_json, add_out
from movingout.maps.files.output_file import draft_of
from movingout.maps.files.terminal import printable
from movingout.maps.suggestion import counted
from movingout.recordings.annotation.agreement import agreements, by_case, settled
from movingout.recordings.annotation.finding import Finding, SearchedRecording
from movingout.recordings.annotation.findings_table import finding_rows
from movingout.recordings.annotation.search import FailureSearch, search_failures
from movingout.recordings.annotation.verdicts import Verdicts, annotations
from movingout.recordings.commands.arguments import places_below, print_json
from movingout.recordings.commands.selection import left_out_words
from movingout.recordings.errors import RecordingError, cannot
from movingout.recordings.report.failures import CASES, Case
from movingout.recordings.report.words import Words
from movingout.recordings.spreadsheet import check_name, safe_cells
from movingout.recordings.storage.study_rounds import uncounted_in
from movingout.world.estimates import Estimate, estimate_of_copies, estimate_text


class PlayerRate(NamedTuple):
    """How often a player has a failure."""

    who: str
    case: Case
    found: Estimate | None  # by the rules
    confirmed: Estimate | None  # by annotators
    open: int  # findings on which nobody decided, or as many did either way


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder", type=Path, metavar="DIR", help="folder of recordings, without those in folders below it"
    )
    parser.add_argument(
        "--annotations",
        nargs="+",
        type=Path,
        default=(),
        metavar="FILE",
        help="verdicts from elsewhere, besides DIR/annotations.jsonl, which the page /annotate writes",
    )
    add_out(parser, "FILE.csv", "also write every finding with the verdict of each annotator")
    add_json(parser)
    parser.set_defaults(perform=perform)


def perform(args: argparse.Namespace) -> int:
    """Raises RecordingError."""
    if args.out is not None:
        check_name(args.out)
    search = search_failures(args.folder)
    if not search.recordings:
        raise RecordingError(_nothing_in(args.folder))
    verdicts = annotations(args.folder, args.annotations, search.recordings)
    leaves_out = uncounted_in(args.folder)
    recordings = [one for one in search.recordings if one.id not in leaves_out]
    uncounted = len(search.recordings) - len(recordings)
    if args.out is not None:
        _write(args.out, recordings, verdicts)
    found = [finding for recording in recordings for finding in recording.findings]
    rates = rates_by_player(recordings, verdicts)
    if args.json:
        cases = [asdict(one) | {"precision": one.precision} for one in by_case(found, verdicts)]
        pairs = [asdict(one) for one in agreements(found, verdicts)]
        players = [_rate(one) for one in rates]
        left_out = {"uncounted": uncounted, "copies": search.copies}
        print_json({"recordings": len(recordings), **left_out, "rates": players, "cases": cases, "agreement": pairs})
    else:
        counts = replace(search, recordings=recordings)
        print("\n".join(map(printable, _page(counts, uncounted, found, rates, verdicts))))
        if args.out is not None:
            print(f"wrote {args.out}: {counted(len(found), 'finding')}")
    return 0


def _nothing_in(folder: Path) -> str:
    """Why none is searched: folders below have verdicts of their own."""
    if below := places_below(folder, finished=True):
        return f"there are no finished recordings in {folder} itself, but {below}; name one of these folders"
    return f"there are no finished recordings in {folder}; name a folder with .mcap files"


def rates_by_player(recordings: Sequence[SearchedRecording], verdicts: Verdicts) -> list[PlayerRate]:
    """Per player and case the share of appearances (a recording and a seat) with a finding, and a confirmed one."""
    appearances: dict[str, list[tuple[SearchedRecording, int]]] = {}
    for recording in recordings:
        for seat in (0, 1):
            appearances.setdefault(recording.who(seat), []).append((recording, seat))
    rows = []
    for who in sorted(appearances):
        for case in CASES:
            said = [
                (f"{recording.played or recording.id} {seat}", _outcomes(recording, seat, case, verdicts))
                for recording, seat in appearances[who]
            ]
            found = estimate_of_copies([(played, float(bool(outcomes))) for played, outcomes in said])
            confirmed = estimate_of_copies([(played, float(True in outcomes)) for played, outcomes in said])
            rows.append(PlayerRate(who, case, found, confirmed, sum(one.count(None) for _, one in said)))
    return rows


def _outcomes(recording: SearchedRecording, seat: int, case: Case, verdicts: Verdicts) -> list[bool | None]:
    """Of each finding of a case in a seat, whether it is confirmed; None where that is open."""
    mine = [one for one in recording.findings if (one.seat, one.case) == (seat, case)]
    return [settled(verdicts.get(one.id, {}).values()) for one in mine]


def _page(
    search: FailureSearch, uncounted: int, found: list[Finding], rates: Sequence[PlayerRate], verdicts: Verdicts
) -> Iterator[str]:
    left_out = [f"{search.left_out} unfinished, tutorial or unreadable"] if search.left_out else []
    left_out += left_out_words(uncounted, search.copies)
    rest = f" (left out: {'; '.join(left_out)})" if left_out else ""
    yield f"{counted(len(search.recordings), 'recording')}{rest}: {counted(len(found), 'finding')} by rules"
    if simulated := sum(recording.simulated for recording in search.recordings):
        yield f"{counted(simulated, 'recording')} of a rehearsal: the people in it were simulated"
    yield ""
    yield "share of appearances (a recording and a seat) in which a player has the failure:"
    for rate in rates:
        n = rate.found.n if rate.found else 0
        annotated = f"confirmed {estimate_text(rate.confirmed)}, {rate.open} findings open" if verdicts else ""
        words = f"by rules {estimate_text(rate.found)}"
        yield f"  {rate.who}: {_title(rate.case)}: n = {n}, {', '.join(filter(None, (words, annotated)))}"
    if not verdicts:
        yield ""
        yield "nobody has annotated them yet: open /annotate on the server that has these recordings"
        return
    yield ""
    yield "annotated:"
    for case in by_case(found, verdicts):
        precision = "–" if case.precision is None else f"{case.precision:.2f}"
        yield (
            f"  {_title(case.case)}: {case.judged} of {case.findings} judged, {case.confirmed} confirmed, "
            f"{case.rejected} rejected, {case.disputed} disputed; precision of the rule {precision}"
        )
    for pair in agreements(found, verdicts):
        kappa = "–" if pair.kappa is None else f"{pair.kappa:.2f}"
        yield f"  {pair.one} and {pair.other}: {pair.same} of {pair.both} the same, Cohen's kappa {kappa}"


def _title(case: Case) -> str:
    return Words().say(f"case.{case}").lower()


def _write(path: Path, recordings: Sequence[SearchedRecording], verdicts: Verdicts) -> None:
    columns, rows = finding_rows(recordings, verdicts)
    try:
        with draft_of(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, columns)
            writer.writeheader()
            writer.writerows(map(safe_cells, rows))
    except OSError as error:
        raise cannot("write", path, error) from error


def _rate(rate: PlayerRate) -> dict[str, Any]:
    found, confirmed = (None if one is None else one._asdict() for one in (rate.found, rate.confirmed))
    return {"who": rate.who, "case": rate.case, "found": found, "confirmed": confirmed, "open": rate.open}
