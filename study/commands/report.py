"""`movingout study report`: the results of a study as one offline page, and its tables as CSV."""

import argparse
import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from typing import Any

from movingout.maps.files.terminal import printable_lines
from movingout.maps.suggestion import counted
from movingout.recordings.annotation.findings_table import finding_rows
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.target import new_target
from movingout.recordings.report.words import Words
from movingout.recordings.spreadsheet import ENCODING, safe_cells, safe_text
from movingout.study.analysis.design_flags import design_flags
from movingout.study.analysis.page import all_tables, page
from movingout.study.analysis.results import Results, collect
from movingout.study.analysis.tables import ENGLISH, LANGUAGE_FILES, Namer, ReportTable
from movingout.study.commands.data import as_frozen, seats_told
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import letters
from movingout.study.design.definition import SUBSTITUTE, Study
from movingout.study.errors import StudyError
from movingout.study.store.frozen_study import FrozenStudy, code_by_time, frozen_study


def report(folder: StudyFolder, args: argparse.Namespace) -> int:
    """Write a folder with report.html and a CSV file per table. Raises StudyError."""
    with closing(folder.open_existing()) as store:
        folder = as_frozen(folder, store, args.file)
        frozen, codes = frozen_study(store), code_by_time(store)
        results = collect(folder.study, store, folder.recordings, args.annotations)
    flags = (*design_flags(folder.study, blinded=args.blinded), *results.flags)
    results = replace(results, flags=flags, blinded=args.blinded)
    target: Path = args.out or folder.output("report", frozen.simulated)
    words = Words(args.language or folder.study.languages[0], (LANGUAGE_FILES,))
    name, english = (_namer(folder.study, spoken, blinded=args.blinded) for spoken in (words, ENGLISH))
    try:
        with new_target(target) as part:
            part.mkdir()
            about = _about(folder.study, frozen, codes, words)
            text = page(results, name, about, words, frozen.simulated)
            (part / "report.html").write_text(text, encoding="utf-8")
            for table in all_tables(results, english):  # for programs: the same in every language
                _write(part / f"{table.name}.csv", table)
            _write_findings(part / "findings.csv", results)
    except RecordingError as error:
        raise StudyError(str(error)) from error
    _say(target, results, seats_told(folder.study, blinded=args.blinded), as_json=args.json)
    return 0


def _namer(study: Study, words: Words, *, blinded: bool) -> Namer:
    shown = letters(study) if blinded else {one.id: _named(one.id, one.agent) for one in study.partners}
    shown.setdefault(SUBSTITUTE, words.say("study.substitute"))
    return lambda partner: shown.get(partner, words.say("study.another_participant"))


def _named(partner: str, agent: str) -> str:
    return partner if partner == agent else f"{partner} ({agent})"


def _about(study: Study, frozen: FrozenStudy, codes: Sequence[Mapping[str, Any]], words: Words) -> str:
    key = "study.about.protocol" if study.protocol else "study.about"
    software = ", ".join(_software(codes, words))
    return words.say(key, id=frozen.id, protocol=study.protocol, file=frozen.file_sha256[:12], version=software)


def _software(codes: Sequence[Mapping[str, Any]], words: Words) -> Iterator[str]:
    """What `code_by_time` says of this project: its versions in order, with the days from which newer ones were there.

    Where there are several, each has the begin of the hash of its sources: they may have one number.
    """
    noted = [(one["from_ms"], one["code"] or {}) for one in codes]
    versions = [(from_ms, code.get("movingout", ""), code.get("source_sha256", "")[:8]) for from_ms, code in noted]
    apart = [next(group) for _, group in groupby(versions, key=lambda one: one[1:])]
    for number, (from_ms, version, source) in enumerate(apart):
        name = version or words.say("study.about.unknown")
        name += f" ({source})" if source and len(apart) > 1 else ""
        day = datetime.fromtimestamp(from_ms / 1000, UTC).date().isoformat()
        yield words.say("study.about.later", version=name, day=day) if number else name


def _write(path: Path, table: ReportTable) -> None:
    with path.open("w", encoding=ENCODING, newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(table.heads)
        for row in table.rows:
            writer.writerow([*map(safe_text, row[: table.words]), *row[table.words :]])


def _write_findings(path: Path, results: Results) -> None:
    """Every finding of the rounds that count, with the verdict of each annotator."""
    columns, rows = finding_rows(results.sessions.recordings, results.sessions.verdicts)
    with path.open("w", encoding=ENCODING, newline="") as stream:
        writer = csv.DictWriter(stream, columns)
        writer.writeheader()
        writer.writerows(map(safe_cells, rows))


def _say(target: Path, results: Results, warnings: list[str], *, as_json: bool) -> None:
    if as_json:
        document = {"report": str(target), "rounds": len(results.rounds), "flow": dict(results.flow)}
        print(json.dumps({**document, "warnings": warnings}, indent=2))
    else:
        flags = counted(len(results.flags), "quality flag")
        print(f"wrote {target}/report.html: {counted(len(results.rounds), 'round')}, {flags}")
        for sentence in warnings:
            print(printable_lines(f"warning: {sentence}"))
