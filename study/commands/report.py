"""`movingout study report`: the results of a study as one offline page, and its tables as CSV."""

import argparse
import csv
import json
from contextlib import closing
from pathlib import Path

from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.target import new_target
from movingout.recordings.spreadsheet import safe_text
from movingout.study.analysis.page import all_tables, page
from movingout.study.analysis.results import DELETED, Results, collect
from movingout.study.analysis.tables import Namer, ReportTable
from movingout.study.commands.data import as_frozen
from movingout.study.data.study_folder import StudyFolder
from movingout.study.design.allocation import letters
from movingout.study.design.definition import Study
from movingout.study.errors import StudyError
from movingout.study.store.store import Frozen

FLOW_FIELDS = {DELETED: "forgotten at their wish or after the time of keeping"}
"""Fields of --json whose name is not the text of the report."""


def report(folder: StudyFolder, args: argparse.Namespace) -> int:
    """Write a folder with report.html and a CSV file per table."""
    with closing(folder.open_existing()) as store:
        folder = as_frozen(folder, store, args.file)
        frozen, results = store.frozen(), collect(folder.study, store, folder.recordings)
    target: Path = args.out or folder.output("report", frozen.simulated)
    name = _namer(folder.study, blinded=args.blinded)
    try:
        with new_target(target) as part:
            part.mkdir()
            text = page(results, name, _about(folder.study, frozen), frozen.simulated)
            (part / "report.html").write_text(text, encoding="utf-8")
            for table in all_tables(results, name):
                _write(part / f"{table.name}.csv", table)
    except RecordingError as error:
        raise StudyError(str(error)) from error
    _say(target, results, as_json=args.json)
    return 0


def _namer(study: Study, *, blinded: bool) -> Namer:
    shown = letters(study) if blinded else {one.id: f"{one.id} ({one.agent})" for one in study.partners}
    return lambda partner: shown.get(partner, "another participant")


def _about(study: Study, frozen: Frozen) -> str:
    protocol = f", protocol {study.protocol}" if study.protocol else ""
    version = frozen.code.get("movingout", "unknown")
    return f"Study {frozen.id}{protocol}; study file {frozen.file_sha256[:12]}, software {version}."


def _write(path: Path, table: ReportTable) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(table.heads)
        for row in table.rows:
            writer.writerow([*map(safe_text, row[: table.words]), *row[table.words :]])


def _say(target: Path, results: Results, *, as_json: bool) -> None:
    if as_json:
        flow = {FLOW_FIELDS.get(text, text): number for text, number in results.flow}
        print(json.dumps({"report": str(target), "rounds": len(results.rounds), "flow": flow}, indent=2))
    else:
        print(f"wrote {target}/report.html: {len(results.rounds)} rounds, {len(results.flags)} quality flags")
