"""A Parquet file of a few bytes cannot fill the memory."""

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from movingout.recordings.errors import RecordingError
from movingout.recordings.imports import parquet_rows as module
from movingout.recordings.imports.sources import read

LONG = "0" * (1 << 20)


@pytest.fixture(autouse=True)
def _little(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ALWAYS_POSSIBLE", 4 << 20)


def written(folder: Path, table: dict[str, Any], **options: Any) -> Path:
    path = folder / "rows.parquet"
    pq.write_table(pa.table(table), path, compression="zstd", **options)
    assert path.stat().st_size < 20_000
    return path


@pytest.mark.parametrize("dictionary", [False, True], ids=["long values", "one value in many rows"])
def test_what_unpacks_to_more_than_a_file_can_mean_is_refused(dictionary: bool, tmp_path: Path) -> None:
    table = {"map_name": ["HandOff"] * 40, "steps_data": [LONG] * 40}
    with pytest.raises(
        RecordingError, match=r"rows.parquet would take more than 0.0 GiB of memory when it is unpacked"
    ):
        read(written(tmp_path, table, use_dictionary=dictionary))


def test_a_list_of_nothing_counts_by_its_length(tmp_path: Path) -> None:
    table = {"map_name": ["HandOff"], "steps_data": pa.array([[None] * 200_000])}
    with pytest.raises(RecordingError, match="of memory when it is unpacked"):
        read(written(tmp_path, table))


def test_rows_without_end_are_refused(tmp_path: Path) -> None:
    table = {"map_name": pa.nulls(100_000, pa.string()), "steps_data": pa.nulls(100_000, pa.string())}
    with pytest.raises(RecordingError, match="of memory when it is unpacked"):
        read(written(tmp_path, table))


def test_columns_that_nobody_asks_for_are_not_read(tmp_path: Path) -> None:
    table = {"map_name": ["HandOff"] * 2, "steps_data": ["[]", "[1]"], "video": [LONG * 8] * 2}
    assert [one.steps for one in read(written(tmp_path, table))] == ["[]", "[1]"]


def test_a_file_without_the_columns_is_told_what_is_needed(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="row 0: 'map_name' and 'steps_data' are needed"):
        read(written(tmp_path, {"map_name": ["HandOff"]}))
    with pytest.raises(RecordingError, match="row 0: 'map_name' and 'steps_data' are needed"):
        read(written(tmp_path, {"other": ["HandOff"]}))
