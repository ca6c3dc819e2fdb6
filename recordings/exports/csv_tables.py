"""CSV: three tables and their data dictionary in a folder, for spreadsheets and R; standard library only."""

import csv
from contextlib import ExitStack
from pathlib import Path

from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.tables import TABLES, Row, data_dictionary, episode_row, event_rows, tick_rows
from movingout.recordings.exports.target import new_target
from movingout.recordings.spreadsheet import safe_cells


def write(plan: ExportPlan) -> None:
    """episodes.csv, ticks.csv, events.csv and DATA_DICTIONARY.md; floats with all their digits."""
    with new_target(plan.target) as folder:
        folder.mkdir()
        dictionary = data_dictionary("{}.csv".format, TABLES)
        (folder / "DATA_DICTIONARY.md").write_text(dictionary, encoding="utf-8")
        with ExitStack() as open_files:
            writers = {name: _writer(open_files, folder, name) for name in TABLES}
            for episode, part in plan.episodes("exporting"):
                writers["episodes"].writerow(_cells(episode_row(episode, part)))
                writers["ticks"].writerows(map(_cells, tick_rows(episode)))
                writers["events"].writerows(map(_cells, event_rows(episode)))


def _writer(open_files: ExitStack, folder: Path, name: str) -> "csv.DictWriter[str]":
    stream = open_files.enter_context((folder / f"{name}.csv").open("w", newline="", encoding="utf-8"))
    writer = csv.DictWriter(stream, [column.name for column in TABLES[name]], restval="")
    writer.writeheader()
    return writer


def _cells(row: Row) -> Row:
    """Booleans as 0 and 1, and no formulas."""
    return safe_cells({name: int(value) if isinstance(value, bool) else value for name, value in row.items()})
