"""CSV: three tables and their data dictionary in a folder, for spreadsheets and R; standard library only."""

import csv
from contextlib import ExitStack
from pathlib import Path

from movingout.recordings.episode import Episode
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.tables import (
    TABLES,
    Row,
    data_dictionary,
    episode_row,
    event_rows,
    tables_of,
    tick_rows,
)
from movingout.recordings.exports.target import new_target
from movingout.recordings.spreadsheet import safe_cells


def write(plan: ExportPlan) -> None:
    """episodes.csv, ticks.csv, events.csv and DATA_DICTIONARY.md; floats with all their digits."""
    with new_target(plan.target) as folder:
        folder.mkdir()
        dictionary = data_dictionary("{}.csv".format, tables_of(plan.split_by))
        (folder / "DATA_DICTIONARY.md").write_text(dictionary, encoding="utf-8")
        with ExitStack() as open_files:
            writers = {name: _writer(open_files, folder, name) for name in TABLES}
            for rows in plan.converted(_rows, "exporting"):
                for name, values in rows.items():
                    writers[name].writerows(values)


def _rows(episode: Episode, part: str) -> dict[str, list[Row]]:
    return {
        "episodes": [_cells(episode_row(episode, part))],
        "ticks": [_cells(row) for row in tick_rows(episode)],
        "events": [_cells(row) for row in event_rows(episode)],
    }


def _writer(open_files: ExitStack, folder: Path, name: str) -> "csv.DictWriter[str]":
    stream = open_files.enter_context((folder / f"{name}.csv").open("w", newline="", encoding="utf-8"))
    writer = csv.DictWriter(stream, [column.name for column in TABLES[name]], restval="")
    writer.writeheader()
    return writer


def _cells(row: Row) -> Row:
    """Booleans as 0 and 1, and no formulas."""
    return safe_cells({name: int(value) if isinstance(value, bool) else value for name, value in row.items()})
