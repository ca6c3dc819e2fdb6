"""The table of results that other programs read."""

from dataclasses import replace
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet

from movingout.matches.experiment.grid import Grid
from movingout.matches.experiment.plan import matches_of, planned_matches
from movingout.matches.grid_run import GridRun
from movingout.matches.match import MatchResult, failed_result
from movingout.matches.report.parquet import write_parquet

GRID = Grid.model_validate({"name": "x", "agents": ["idle"], "maps": ["HandOff"], "seeds": 2})


def _written(folder: Path, *results: MatchResult) -> pa.Table:
    run = GridRun(folder, GRID, planned_matches(GRID), {result.match: result for result in results})
    assert write_parquet(run) == ""
    return parquet.read_table(folder / "results.parquet")


def test_columns_have_their_types_where_no_match_has_a_value(tmp_path: Path) -> None:
    """Metrics without any value were columns of nulls, which do not go together with those of another grid."""
    first, _ = matches_of(planned_matches(GRID))
    table = _written(tmp_path, failed_result(first, "it raised"))
    for name in ("tcr", "wt_s", "ac", "interdependence", "waiting_share", "official_ac"):
        assert table.schema.field(name).type == pa.float64(), name


def test_a_metric_that_the_first_match_lacks_is_a_column_all_the_same(tmp_path: Path) -> None:
    first, second = matches_of(planned_matches(GRID))
    played = replace(failed_result(second, ""), own_metrics={"walked": 3.5})
    table = _written(tmp_path, failed_result(first, "it raised"), played)
    assert table.column("walked").to_pylist() == [None, 3.5]


def test_what_agents_counted_is_a_column_each(tmp_path: Path) -> None:
    first, second = matches_of(planned_matches(GRID))
    table = _written(tmp_path, failed_result(first, ""), replace(failed_result(second, ""), counts={"red_useful": 3}))
    assert table.column("red_useful").to_pylist() == [None, 3] and "counts" not in table.column_names


def test_a_metric_of_a_package_gives_way_to_the_field_of_its_key(tmp_path: Path) -> None:
    """Results of before the field may have such a metric; its values were in the column of ours."""
    first, second = matches_of(planned_matches(GRID))
    before = replace(failed_result(first, ""), own_metrics={"official_ac": 3.5})
    table = _written(tmp_path, before, replace(failed_result(second, ""), official_ac=0.5))
    assert table.column("official_ac").to_pylist() == [None, 0.5]
