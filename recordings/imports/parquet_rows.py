"""The rows of a data set in a Parquet file, one after the other: a small file may claim to hold any number of bytes."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from movingout.maps.extras import needs_extra
from movingout.recordings.errors import RecordingError
from movingout.recordings.file_format.records import MOST_PER_BYTE

COLUMNS = (
    *("map_name", "steps_data", "blue", "red", "trajectory_id"),
    *("blue_kind", "red_kind", "simulated", "outcome", "limit_ticks", "masses"),
)
"""What `sources` takes of a row; others are not read."""
ALWAYS_POSSIBLE = 1 << 30  # decompressed bytes; more has to have a file of some size
_BYTES_PER_VALUE = 64  # of Python, for a number in a list and its share of what holds it


def parquet_rows(file: Path) -> Iterator[dict[str, Any]]:
    """The rows. Raises RecordingError for another file, and for more than `ALWAYS_POSSIBLE` of a small one.

    Neither number in the file alone is enough: what the index says of a column leaves out that one value may be
    repeated in a million rows, and a list of nothing takes no bytes before it is Python's.
    """
    with needs_extra("export", "Parquet"):
        import pyarrow as pa
        import pyarrow.parquet as pq
    try:
        most = ALWAYS_POSSIBLE + MOST_PER_BYTE * file.stat().st_size
        with pq.ParquetFile(file) as source:
            wanted = [name for name in source.schema_arrow.names if name in COLUMNS]
            if _claimed(source.metadata) > most:
                raise _too_large(file, most)
            taken = 0
            for batch in source.iter_batches(batch_size=1, columns=wanted):
                taken += batch.nbytes
                if taken > most:
                    raise _too_large(file, most)
                yield from batch.to_pylist()
    except (pa.ArrowException, OSError, ValueError) as error:
        raise RecordingError(f"{file} is not a readable Parquet file: {error}") from error


def _claimed(metadata: Any) -> int:
    """Bytes that the columns which are read take, as the index says."""
    groups = (metadata.row_group(index) for index in range(metadata.num_row_groups))
    columns = (group.column(index) for group in groups for index in range(group.num_columns))
    return sum(
        column.total_uncompressed_size + _BYTES_PER_VALUE * column.num_values
        for column in columns
        if column.path_in_schema.partition(".")[0] in COLUMNS
    )


def _too_large(file: Path, most: int) -> RecordingError:
    return RecordingError(
        f"{file} would take more than {most / 2**30:,.1f} GiB of memory when it is unpacked; split the file"
    )
