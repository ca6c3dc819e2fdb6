"""Results as a Parquet file with a row per match (needs the extra `export`)."""

import os
from typing import Any

from movingout.maps.extras import MissingExtraError
from movingout.matches.errors import MatchError
from movingout.matches.match import MatchResult
from movingout.matches.run import GridRun


def write_parquet(run: GridRun) -> str:
    """Write results.parquet. Returns "", or a sentence when pyarrow is missing."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        return f"results.parquet was not written: {MissingExtraError('export', 'Parquet')}"
    if not run.results:
        return ""
    path = run.folder / "results.parquet"
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        parquet.write_table(pa.Table.from_pylist([_row(result) for result in run.results.values()]), draft)
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise MatchError(f"cannot write {path}: {error.strerror or error}") from error
    return ""


def _row(result: MatchResult) -> dict[str, Any]:
    """A result with a column for each metric."""
    document = result.to_json()
    own = document.pop("own_metrics")
    return {**document, **own}
