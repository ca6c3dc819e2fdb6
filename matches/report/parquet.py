"""Results in other forms: one Parquet row per match (needs the extra `export`)."""

import os

from movingout.matches.errors import MatchError
from movingout.matches.run import GridRun


def write_parquet(run: GridRun) -> str:
    """Write results.parquet; returns a sentence instead where pyarrow is missing."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        return "no results.parquet: it needs pyarrow (pip install 'moving-out-live[export]'); the JSON lines have all"
    if not run.results:
        return ""
    path = run.folder / "results.parquet"
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        parquet.write_table(pa.Table.from_pylist([result.to_json() for result in run.results.values()]), draft)
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise MatchError(f"cannot write {path}: {error.strerror or error}") from error
    return ""
