from pathlib import Path

import pytest
import yaml

from movingout.recordings import SeatInfo, finalise
from movingout.recordings.exports import export
from movingout.recordings.exports.dataset_card import FILES
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.split import SplitBy
from movingout.recordings.imports.convert import pseudonym
from tests.recordings.support import record


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("recordings")
    person = SeatInfo("human", "P-1", device="touch")
    first, _ = record(folder, ticks=4, episode_id="first", seats=(person, SeatInfo("agent", "scripted")))
    second, _ = record(folder, ticks=4, episode_id="second", seed=1)
    return [finalise(first), finalise(second)]


@pytest.mark.parametrize("name", FILES)
def test_the_card_counts_what_was_exported_and_names_files_that_exist(
    name: str, recordings: list[Path], tmp_path: Path
) -> None:
    target = tmp_path / "data"
    export(name, ExportPlan(recordings, target, test_share=0.5, split_by="episode"))
    text = (target / "README.md").read_text(encoding="utf-8")
    head = yaml.safe_load(text.split("---")[1])
    for config in head["configs"]:
        assert list(target.glob(config["data_files"]))
    assert "license" not in head
    counted = "recordings" if name == "lerobot" else "episodes"
    assert f"| {counted} | 2: 1 for training, 1 for testing |" in text
    assert ("| episodes | 4, one per seat |" in text) == (name == "lerobot")
    assert "| maps | HandOff (2) |" in text
    assert "| seats | agents (2), people (2) |" in text
    assert ("layout `official-v1`" in text) == (name in ("parquet", "lerobot"))
    assert "P-1" not in text


@pytest.mark.parametrize(
    ("name", "by", "cautions"),
    [("person-tyncpf", "participant", 1), ("person-tyncpf", "map", 0), ("P-1", "participant", 0)],
)
def test_the_card_says_that_names_of_one_room_may_be_in_both_parts(
    name: str, by: SplitBy, cautions: int, recordings: list[Path], tmp_path: Path
) -> None:
    """Of a study, whose names keep people apart, it is not true."""
    seats = SeatInfo("human", pseudonym(name, "salt")), SeatInfo("agent", "scripted")  # as imports call them
    live = finalise(record(tmp_path, ticks=4, episode_id="live", seed=2, seats=seats)[0])
    export("csv", ExportPlan([*recordings, live], tmp_path / "data", test_share=0.5, split_by=by))
    assert (tmp_path / "data" / "README.md").read_text(encoding="utf-8").count("may be in both parts") == cautions


@pytest.mark.parametrize(("name", "sentences"), [("person-tyncpf", 1), ("person-1", 0), ("P7KXM2Q", 0)])
def test_the_card_says_without_a_split_that_names_are_of_one_room(name: str, sentences: int, tmp_path: Path) -> None:
    """Whoever splits the data by `participant` themselves needs to know."""
    seats = SeatInfo("human", pseudonym(name, "salt")), SeatInfo("agent", "scripted")
    export("csv", ExportPlan([finalise(record(tmp_path, ticks=4, seats=seats)[0])], tmp_path / "data"))
    card = (tmp_path / "data" / "README.md").read_text(encoding="utf-8")
    assert card.count("A name `person-…` is of one room: one person may have several.") == sentences


def test_the_card_of_a_joint_view_counts_its_episodes(recordings: list[Path], tmp_path: Path) -> None:
    export("lerobot", ExportPlan(recordings, tmp_path / "data", view="joint"))
    text = (tmp_path / "data" / "README.md").read_text(encoding="utf-8")
    assert "| recordings | 2: 2 for training, 0 for testing |\n| episodes | 2, one with both actions |" in text


def test_the_participants_of_a_rehearsal_are_called_simulated(tmp_path: Path) -> None:
    seats = SeatInfo("human", "P-1"), SeatInfo("agent", "scripted")
    journal, _ = record(tmp_path, ticks=4, episode_id="one", seats=seats, study={"simulated": "yes"})
    export("csv", ExportPlan([finalise(journal)], tmp_path / "data"))
    assert "| seats | agents (1), simulated people (1) |" in (tmp_path / "data/README.md").read_text(encoding="utf-8")
