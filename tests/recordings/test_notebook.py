"""Episodes in a notebook: the figure, the table, and the tutorial itself, run by a real kernel."""

import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import nbclient
import nbformat
import pytest

from movingout.maps.extras import MissingExtraError
from movingout.maps.render import SvgPicture
from movingout.maps.scene import LIGHT
from movingout.recordings import Episode, SeatInfo, finalise, read_episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.tables import TICKS
from movingout.world.errors import WorldError
from movingout.world.metrics import METRICS
from tests.recordings.support import record
from tests.support import ROOT

LENGTH = 12
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def episode(tmp_path: Path) -> Episode:
    seats = (SeatInfo("human", "<P&1>", device="keyboard"), SeatInfo("agent", "scripted"))
    journal, _ = record(tmp_path, ticks=LENGTH, seats=seats)
    return read_episode(str(finalise(journal)))


def test_the_figure_has_the_ways_of_both_robots_and_a_chart_per_metric(episode: Episode) -> None:
    figure = episode.plot()
    root = ElementTree.fromstring(figure._repr_svg_())
    strokes = [line.get("stroke") for line in root.iter(f"{SVG}polyline")]
    assert LIGHT.blue in strokes
    assert LIGHT.red in strokes
    texts = [element.text or "" for element in root.iter(f"{SVG}text")]
    assert any("<P&1> (blue) and scripted (red)" in text for text in texts)
    for metric in METRICS:
        value = episode.to_frame()[metric.key].iloc[-1]
        assert any(text.startswith(f"{metric.title}: ") for text in texts) == (value == value)


def test_a_figure_is_kept_as_a_file(tmp_path: Path) -> None:
    SvgPicture("<svg/>").save(tmp_path / "figure.svg")
    assert (tmp_path / "figure.svg").read_text() == "<svg/>"


def test_an_episode_that_was_never_played_has_a_figure_and_a_table(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, ticks=0)
    empty = read_episode(finalise(journal))
    ElementTree.fromstring(empty.plot().svg)
    assert len(empty.to_frame()) == 1


def test_the_table_is_the_exported_one_with_a_row_per_state(episode: Episode) -> None:
    frame = episode.to_frame()
    assert list(frame.columns) == [column.name for column in TICKS]
    assert frame.tick.tolist() == list(range(LENGTH + 1))
    assert frame.blue_x.tolist() == [float(state.robot_poses[0, 0]) for state in episode.states]
    seen = episode.to_frame(layout="official-v1").red_observation
    assert {len(row) for row in seen} == {121}
    with pytest.raises(WorldError, match="unknown layout 'v9'; known: official-v1"):
        episode.to_frame(layout="v9")


def test_the_types_of_columns_are_the_same_for_every_map_and_length(tmp_path: Path, episode: Episode) -> None:
    other, _ = record(tmp_path / "other", ticks=0, map_name="FourCorners")
    kinds = {"bool": "boolean", "float64": "float64", "int64": "int64"}
    expected = {column.name: kinds[column.type] for column in TICKS if column.type in kinds}
    expected |= {"blue_input_seq": "Int64", "red_input_seq": "Int64"}  # none before the first tick
    for frame in (episode.to_frame(), read_episode(finalise(other)).to_frame()):
        assert {name: str(kind) for name, kind in frame.dtypes.items() if name in expected} == expected


def test_the_axis_of_what_stays_0_goes_to_1(episode: Episode) -> None:
    assert episode.to_frame().wt_s.max() == 0
    assert "e-" not in "".join(
        text.text or "" for text in ElementTree.fromstring(episode.plot().svg).iter(f"{SVG}text")
    )


def test_a_cell_shows_an_episode_in_one_line(episode: Episode) -> None:
    assert repr(episode) == f"<Episode {episode.header.episode_id}: <P&1> and scripted, {LENGTH} ticks, time>"


@pytest.mark.parametrize(
    ("path", "sentence"), [(None, "by the path of its file, not by None"), (ROOT, "it is a folder; name a file")]
)
def test_what_is_no_file_is_no_episode(path: Any, sentence: str) -> None:
    with pytest.raises(RecordingError, match=sentence):
        read_episode(path)


def test_without_pandas_the_extra_is_named(episode: Episode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match="extra `notebook`"):
        episode.to_frame()


@pytest.mark.slow
def test_the_tutorial_notebook_runs_from_beginning_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))
    notebook = nbformat.read(ROOT / "examples" / "tutorial.ipynb", as_version=4)  # type: ignore[no-untyped-call]
    assert [cell for cell in notebook.cells if cell.get("outputs")] == []
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    kinds = [set(output.data) for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    assert sum("image/svg+xml" in kind for kind in kinds) == 2
    assert sum("image/png" in kind for kind in kinds) == 1
    assert sum("text/html" in kind for kind in kinds) == 1
