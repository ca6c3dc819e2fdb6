"""Labels of an expert where a learner went."""

from pathlib import Path

import numpy as np
import pytest

from agents.corrections import Lesson, correction_pieces, lessons, load_correction, save_correction, teach
from agents.dataset import windows_of
from agents.errors import DataError
from maps import load_map
from tests.agents.support import HERE

STILL = f"{HERE}:Forward:distance=0.0"
AHEAD = f"{HERE}:Forward:distance=1.0"


def _lesson(seat: int = 1) -> Lesson:
    return Lesson(load_map("HandOff"), STILL, AHEAD, ("ann", "idle"), seat, seed=3, ticks=12)


def test_the_learner_acts_and_the_expert_labels() -> None:
    correction = teach(_lesson(), slips=False)
    assert correction.trajectory.participants == ("ann", "expert:ann")
    assert np.array_equal(correction.trajectory.actions[:, 1, 0], np.zeros(12))
    assert np.allclose(correction.labels, [[1.0, 1.0, 0.0, 1.0, -1.0]] * 12)


def test_a_slip_changes_what_is_done_and_not_what_is_taught() -> None:
    long = Lesson(load_map("HandOff"), STILL, AHEAD, ("ann", "idle"), 0, seed=3, ticks=300)
    correction = teach(long)
    assert 0 < np.count_nonzero(correction.trajectory.actions[:, 0, 0]) < 150
    assert np.array_equal(correction.trajectory.actions[:, 1], np.zeros((300, 3)))
    assert np.allclose(correction.labels[:, 0], 1.0)


def test_corrections_are_read_back_and_become_windows_of_the_learners_seat(tmp_path: Path) -> None:
    correction = teach(_lesson())
    path = tmp_path / "one.corrections.npz"
    save_correction(path, correction)
    read = load_correction(path)
    assert read.trajectory.map == correction.trajectory.map
    assert np.array_equal(read.labels, correction.labels)
    windows = windows_of(correction_pieces([read], "aware-v1"))
    assert len(windows) == 12 and windows.names == ("expert:ann",)
    assert np.array_equal(windows.features, correction.trajectory.features(1, "aware-v1"))


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.corrections.npz"
    np.savez(path, about=np.array("{}"))
    with pytest.raises(DataError, match="is not a file of corrections"):
        load_correction(path)


def test_lessons_change_seats_and_partners() -> None:
    maps = [load_map("HandOff"), load_map("LeftRight")]
    made = lessons(maps, [("a", "idle"), ("b", "idle")], "scripted", "scripted", 4, 100, seed=0)
    assert len(made) == 8
    assert {(one.seat, one.partner[0]) for one in made} == {(0, "a"), (0, "b"), (1, "a"), (1, "b")}
    assert len({one.seed for one in made}) == 8
