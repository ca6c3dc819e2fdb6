"""Parquet: three tables and their data dictionary in a folder; one row group per episode, zstd."""

from functools import partial
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from movingout.recordings.episode import Episode
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.tables import (
    Column,
    Row,
    data_dictionary,
    episode_row,
    event_rows,
    observation_columns,
    tables_of,
    tick_rows,
)
from movingout.recordings.exports.target import new_target

_TYPES: dict[str, Any] = {
    "string": pa.string(),
    "int64": pa.int64(),
    "float64": pa.float64(),
    "bool": pa.bool_(),
    "list<float32>": pa.list_(pa.float32()),
}


def write(plan: ExportPlan) -> None:
    """episodes.parquet, ticks.parquet (with observations), events.parquet and DATA_DICTIONARY.md."""
    plan.check_seen()
    tables = tables_of(plan.split_by)
    tables["ticks"] = [*tables["ticks"], *observation_columns(plan.layout)]
    with new_target(plan.target) as folder:
        folder.mkdir()
        dictionary = data_dictionary("{}.parquet".format, tables)
        (folder / "DATA_DICTIONARY.md").write_text(dictionary, encoding="utf-8")
        _write_tables(plan, folder, {name: arrow_schema(columns) for name, columns in tables.items()})


def _write_tables(plan: ExportPlan, folder: Path, schemas: dict[str, Any]) -> None:
    writers = {
        name: pq.ParquetWriter(folder / f"{name}.parquet", schema, compression="zstd")
        for name, schema in schemas.items()
    }
    try:
        for rows in plan.converted(partial(_rows, layout=plan.layout), "exporting"):
            for name, values in rows.items():
                if values:
                    writers[name].write_table(pa.Table.from_pylist(values, schema=schemas[name]))
    finally:
        for writer in writers.values():
            writer.close()


def _rows(episode: Episode, part: str, layout: str) -> dict[str, list[Row]]:
    return {
        "episodes": [episode_row(episode, part)],
        "ticks": list(tick_rows(episode, layout)),
        "events": list(event_rows(episode)),
    }


def arrow_schema(columns: list[Column]) -> Any:
    """The columns with their meaning as field metadata, so that the file explains itself."""
    return pa.schema(
        [pa.field(c.name, _TYPES[c.type], metadata={"unit": c.unit, "meaning": c.meaning}) for c in columns]
    )
