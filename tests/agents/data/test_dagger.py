"""Labels of an expert where a learner went."""

import zipfile
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.agents.data.corrections import LONGEST_REST, correction_samples, load_correction, save_correction
from movingout.agents.data.dagger import LabellingJob, label_episode, labelling_jobs, shuffled_partners
from movingout.agents.data.dataset import windows_of
from movingout.agents.data.demonstrations import label_all
from movingout.agents.errors import DataError
from movingout.maps import load_map
from movingout.recordings import RecordingError
from tests.agents.support import HERE, Forward

STILL = f"{HERE}:Forward:distance=0.0"
AHEAD = f"{HERE}:Forward:distance=1.0"


def _job(expert: str = AHEAD) -> LabellingJob:
    return LabellingJob(load_map("HandOff"), expert, expert, ("ann", "idle"), 1, seed=3, ticks=12)


def _long(learner: str, expert: str) -> LabellingJob:
    return LabellingJob(load_map("HandOff"), learner, expert, ("ann", "idle"), 0, seed=3, ticks=300)


def test_learner_and_expert_take_turns_and_only_the_experts_are_taught() -> None:
    correction = label_episode(_long(STILL, AHEAD), slips=False)
    assert correction.trajectory.participants == ("expert:ann", "ann")
    assert 0.3 < correction.taught.mean() < 0.9 and not correction.taught[0]
    assert np.array_equal(correction.trajectory.actions[:, 0, 0], correction.taught.astype(float))
    assert np.allclose(correction.labels[correction.taught], [1.0, 1.0, 0.0, 1.0, -1.0])


class Remembering(Forward):
    """Drives while it has seen every tick, and plays decisions of some ticks, of which only the first row is fast."""

    def reset(self, episode: EpisodeInfo) -> None:
        super().reset(episode)
        self.seen: list[int] = []

    def act(self, observation: Observation) -> ActionChunk:
        self.seen.append(observation.tick)
        chunk = super().act(observation)
        chunk[1:, 0] = 0.5
        return chunk if self.rows > 1 or self.seen == list(range(observation.tick + 1)) else chunk * [0, 1, 1, 1]


def test_the_learner_remembers_what_happened_in_the_experts_turns() -> None:
    correction = label_episode(_long(f"{__name__}:Remembering", STILL), slips=False)
    assert np.array_equal(correction.trajectory.actions[:, 0, 0], (~correction.taught).astype(float))


def test_the_learner_plays_no_decision_of_before_its_turn() -> None:
    correction = label_episode(_long(f"{__name__}:Remembering:rows=7,execute=7", STILL), slips=False)
    turns = np.flatnonzero(np.diff(correction.taught.astype(int)) == -1) + 1
    assert len(turns) > 2
    assert (correction.trajectory.actions[turns, 0, 0] == 1.0).all()


def test_the_expert_alone_is_taught_in_every_tick() -> None:
    assert label_episode(_job(expert=STILL), slips=False).taught.all()


def test_a_slip_changes_what_is_done_and_is_not_taught() -> None:
    correction = label_episode(_long(STILL, STILL))
    slipped = correction.trajectory.actions[:, 0, 0] > 0
    assert 0 < slipped.sum() < 150
    assert np.array_equal(correction.taught, ~slipped)
    assert np.array_equal(correction.trajectory.actions[:, 1], np.zeros((300, 3)))


def test_who_rests_faces_where_it_faces() -> None:
    label = label_episode(_long(STILL, STILL), slips=False).labels[0]
    angle = load_map("HandOff").robots[0].angle
    assert np.allclose(label, [0.0, np.cos(angle), np.sin(angle), 1.0, -1.0], atol=1e-6)


def test_of_a_long_rest_only_the_beginning_is_learned_and_that_it_ends() -> None:
    rest = label_episode(_long(STILL, STILL), slips=False)
    windows = windows_of(correction_samples([rest], "aware-v1"))
    assert len(windows) == LONGEST_REST
    rest.labels[100:, 4] = 1.0
    windows = windows_of(correction_samples([rest], "aware-v1"))
    assert len(windows) == 2 * LONGEST_REST + 1
    assert windows.targets[LONGEST_REST, 4] == 1.0


def test_corrections_are_read_back_and_become_windows_of_the_learners_seat(tmp_path: Path) -> None:
    correction = label_episode(_job(), slips=False)
    path = tmp_path / "one.corrections.npz"
    save_correction(path, correction)
    read = load_correction(path)
    assert read.trajectory.map == correction.trajectory.map
    assert np.array_equal(read.labels, correction.labels)
    assert np.array_equal(read.taught, correction.taught)
    windows = windows_of(correction_samples([read], "aware-v1"))
    assert len(windows) == 12 and windows.names == ("expert:ann",)
    assert np.array_equal(windows.features, correction.trajectory.features(1, "aware-v1"))


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    """A full disk was told as a fault of the agents."""
    path = tmp_path / "lost" / "lesson.corrections.npz"
    with pytest.raises(RecordingError, match=r"cannot write .*lesson.corrections.npz: there is no such file or folder"):
        save_correction(path, label_episode(_job(), slips=False))


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.corrections.npz"
    np.savez(path, about=np.array("{}"))
    with pytest.raises(DataError, match="is not a file of corrections"):
        load_correction(path)
    for junk in (b"", b"PK", path.read_bytes()[:-40]):
        path.write_bytes(junk)
        with pytest.raises(DataError, match="is not a file of corrections"):
            load_correction(path)


def test_a_small_file_that_would_fill_the_memory_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.corrections.npz"
    save_correction(path, label_episode(_job(), slips=False))
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("more.npy", bytes(160 << 20))
    assert path.stat().st_size < 300_000
    with pytest.raises(DataError, match="its arrays would take more memory than any episode"):
        load_correction(path)


def test_lessons_change_seats_and_partners() -> None:
    maps = [load_map("HandOff"), load_map("LeftRight")]
    made = labelling_jobs(maps, [("a", "idle"), ("b", "idle")], "scripted", "scripted", 4, 100, seed=0)
    assert len(made) == 8
    assert {(one.seat, one.partner[0]) for one in made} == {(0, "a"), (0, "b"), (1, "a"), (1, "b")}
    assert len({one.seed for one in made}) == 8


def test_with_an_odd_number_of_episodes_seeds_change_seats() -> None:
    maps = [load_map("HandOff"), load_map("LeftRight")]

    def seats(count: int, seed: int) -> list[int]:
        return [job.seat for job in labelling_jobs(maps, [("a", "idle")], "scripted", "scripted", count, 100, seed)]

    assert [seats(1, seed) for seed in range(4)] == [[0, 1], [1, 0], [1, 0], [0, 1]]
    assert [seats(3, seed)[::2] for seed in range(2)] == [[0, 1, 0], [1, 0, 1]]
    assert seats(4, 0) == seats(4, 1) == [0, 1, 1, 0, 0, 1, 1, 0]
    pair = [("a", "idle"), ("b", "idle")]
    made = [job for seed in range(4) for job in labelling_jobs(maps, pair, "scripted", "scripted", 1, 100, seed)]
    assert set(Counter((job.partner[0], job.map.name, job.seat) for job in made).values()) == {1}


def test_a_folder_begun_before_seeds_changed_seats_keeps_what_is_there(tmp_path: Path) -> None:
    (job,) = labelling_jobs([load_map("HandOff")], [("a", "idle")], "idle", "idle", 1, 4, seed=1)
    (made,) = label_all([replace(job, seat=1 - job.seat)], tmp_path, 1)
    written = made.path.read_bytes()
    assert list(label_all([job], tmp_path, 1)) == []
    assert made.path.read_bytes() == written and load_correction(made.path).seat == 1 - job.seat


def test_every_family_meets_maps_of_every_mode() -> None:
    names = [f"generated:{mode}:{seed}" for seed in range(20) for mode in ("coordination", "awareness", "consistency")]
    partners = [(f"{family}{number}", "idle") for number in range(5) for family in ("walker", "porter", "novice")]
    maps = [replace(load_map("HandOff"), name=name) for name in names]
    order = shuffled_partners(partners, len(maps) * 2, seed=0)
    assert Counter(order) == dict.fromkeys(partners, 8)
    made = labelling_jobs(maps, order, "scripted", "scripted", 2, 100, seed=0)
    met = Counter((job.partner[0][:6], job.map.name.split(":")[1]) for job in made)
    assert len(met) == 9
    assert min(met.values()) > 5
    assert shuffled_partners(partners, 30, seed=1) != shuffled_partners(partners, 30, seed=0)
