"""Results as a Parquet file with a row per match (needs the extra `export`)."""

from typing import Any

from movingout.maps.extras import MissingExtraError
from movingout.maps.files.output_file import draft_of
from movingout.matches.errors import MatchError
from movingout.matches.grid_run import GridRun
from movingout.matches.match import MatchResult
from movingout.world.metrics import METRICS


def write_parquet(run: GridRun) -> str:
    """Write results.parquet. Returns "", or a sentence when pyarrow is missing.

    Raises MatchError where it cannot be written.
    """
    try:
        from pyarrow import parquet
    except ImportError:
        return f"results.parquet was not written: {MissingExtraError('export', 'Parquet')}"
    if not run.results:
        return ""
    path = run.folder / "results.parquet"
    try:
        with draft_of(path) as draft:
            parquet.write_table(_table(run), draft)
    except OSError as error:
        raise MatchError(f"cannot write {path}: {error.strerror or error}") from error
    return ""


def _table(run: GridRun) -> Any:
    """Every column is there with its type whatever the first matches have: failed ones lack values."""
    import pyarrow as pa

    rows = [_row(result) for result in run.results.values()]
    numbers = {metric.key for metric in METRICS} | {"waiting_share", "official_ac"}
    numbers |= {key for result in run.results.values() for key in result.own_metrics}
    columns = {name: [row.get(name) for row in rows] for name in dict.fromkeys(key for row in rows for key in row)}
    return pa.table(
        {name: pa.array(values, pa.float64() if name in numbers else None) for name, values in columns.items()}
    )


def _row(result: MatchResult) -> dict[str, Any]:
    """A result with a column for each metric; one of a package whose key has become a field gives way to the field."""
    document = result.to_json()
    others = document.pop("own_metrics") | document.pop("counts")
    return {**document, **{key: value for key, value in others.items() if key not in document}}
