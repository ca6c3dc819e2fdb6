"""Windows over recordings: what they hold, and that nobody is in two splits."""

from dataclasses import replace
from itertools import compress
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.data.dataset import (
    data_hash,
    held_out_episodes,
    learned_seats,
    read_trajectories,
    recording_files,
    split_rows,
    trajectory_samples,
    windows_of,
)
from movingout.agents.errors import DataError
from movingout.recordings.episode import SeatKind
from movingout.recordings.errors import UnreadableError
from tests.agents.learning import recorded, trajectory_windows, walked


def test_a_window_repeats_the_first_observation_and_the_last_action_and_never_leaves_its_episode() -> None:
    trajectories = [walked(ticks=20, seed=1, people=("a", "b")), walked(ticks=30, seed=2, people=("c", "a"))]
    windows = trajectory_windows(trajectories, "official-v1", "hold")
    assert len(windows) == 2 * (20 + 30)
    first_of_second_seat = np.array([20])
    seen = windows.observations(first_of_second_seat, 3)[0]
    assert np.array_equal(seen, np.repeat(windows.features[20:21], 3, axis=0))
    chunk = windows.chunks(np.array([18]), 4)[0]
    assert np.array_equal(chunk, windows.targets[[18, 19, 19, 19]])


def test_targets_are_the_actions_and_the_level_of_the_hand_after_each_tick() -> None:
    trajectory = walked(ticks=60, seed=5)
    targets = trajectory.targets(1, "hold")
    assert np.allclose(targets[:, 0], trajectory.actions[:, 1, 0], atol=1e-6)
    assert np.allclose(
        np.arctan2(targets[:, 2], targets[:, 1]), np.angle(np.exp(1j * trajectory.actions[:, 1, 1])), atol=1e-5
    )
    assert np.array_equal(targets[:, 4] > 0, trajectory.held[1:, 1] >= 0)
    assert np.array_equal(targets[:, 3], -targets[:, 4])


def test_no_participant_is_in_training_and_validation() -> None:
    trajectories = [walked(ticks=5, seed=n, people=(f"p{n}", f"q{n}")) for n in range(6)]
    windows = trajectory_windows(trajectories, "official-v1", "hold")
    train, held_out = windows.split(0.25, seed=1)
    assert len(train) + len(held_out) == len(windows)
    assert len(set(windows.people[held_out])) == 3
    assert not set(windows.people[train]) & set(windows.people[held_out])


def test_nobody_is_simulated_in_training_and_in_validation_whatever_they_are_called() -> None:
    seats = [("A01", "A02"), ("dp@all", "person:name=A01"), ("expert:B01", "B01"), ("A03", "person:name=B02,yields=1")]
    people = [walked(ticks=1, people=people).people for people in seats]
    assert people == [{"A01", "A02"}, {"A01"}, {"B01"}, {"A03", "B02"}]
    for seed in range(9):
        out = held_out_episodes(people, 0.25, seed)
        trained, validated = (set().union(*compress(people, side)) for side in (~out, out))
        assert out.any() and not out.all()
        held = {name for name in trained | validated if name not in trained}
        assert all(group & held for group in compress(people, out)), "somebody new is in each episode of validation"


def test_a_program_beside_a_person_is_no_participant() -> None:
    """Where it was one, holding it out held out every episode that it played in."""
    kinds: list[tuple[SeatKind, SeatKind]] = [("human", "agent"), ("agent", "ghost"), ("human", "human")]
    played = [replace(walked(ticks=3, people=("Q1", "Q2")), kinds=both) for both in kinds]
    assert [one.people for one in played] == [{"Q1"}, {"Q2"}, {"Q1", "Q2"}]
    rounds = [replace(walked(ticks=3, people=(f"Q{n}", "scripted")), kinds=("human", "agent")) for n in range(10)]
    windows = trajectory_windows(rounds, "official-v1", "hold")
    assert windows.names == tuple(f"Q{n}" for n in range(10))
    for seed in range(9):
        assert held_out_episodes([one.people for one in rounds], 0.1, seed).sum() == 1
        assert len(windows.split(0.1, seed)[1]) == 2 * 3, "both seats of one person's episode"


def test_who_is_replayed_without_a_persons_name_is_no_participant() -> None:
    """Each replay was one, and the agent beside it somebody new in each."""
    ghosts, bass = ("ghost:e1#red", "ghost:e2#red", "dp@all"), "bass@all"
    rounds = [replace(walked(ticks=3, people=(bass, ghost)), kinds=("agent", "ghost")) for ghost in ghosts]
    assert {one.whose(0) for one in rounds} == {bass} and not any(one.people for one in rounds)
    assert trajectory_windows(rounds, "official-v1", "hold").names == (bass,)
    scripted = [replace(one, participants=("scripted", one.participants[1])) for one in rounds]
    assert {one.people for one in scripted} == {frozenset({"scripted"})}
    beside = replace(rounds[0], participants=("P@1", ghosts[0]), kinds=("human", "ghost"))
    assert beside.people == {"P@1"} == {beside.whose(1)}


def test_people_without_a_name_are_somebody_of_their_own_in_each_episode(tmp_path: Path) -> None:
    """As one participant they were all held out together, by chance, or never."""
    files = [recorded(tmp_path, f"open{n}", 3, people=("", ""), kinds=("human", "human")) for n in range(8)]
    files += [recorded(tmp_path, "named", 3, people=("Q1", ""), kinds=("human", "human"))]
    files += [recorded(tmp_path, "beside", 3, people=("", "dp@all"), kinds=("human", "agent"))]
    played = read_trajectories(files)
    nobody = [f"nameless:{file.stem}" for file in files]
    assert [one.people for one in played] == [*({name} for name in nobody[:8]), {"Q1", nobody[8]}, {nobody[9]}]
    windows = trajectory_windows(played, "official-v1", "hold")
    assert windows.names == tuple(sorted(("Q1", *nobody)))
    for seed in range(9):
        assert 1 <= held_out_episodes([one.people for one in played], 0.2, seed).sum() <= 2
        assert 3 <= len(windows.split(0.2, seed)[1]) <= 2 * 2 * 3


def test_where_people_cannot_be_held_out_every_tenth_episode_is() -> None:
    for group in ({"ann", "bob"}, set()):  # two people who always play together; trained agents alone
        assert np.flatnonzero(held_out_episodes([group] * 25, 0.5, 0)).tolist() == [9, 19]
    assert not held_out_episodes([{"ann"}, {"bob"}], 0.0, 0).any()


def test_a_person_of_demonstrations_is_the_same_in_matches() -> None:
    trajectories = [walked(ticks=3, people=("A01", "dp@all")), walked(ticks=3, people=("A02", "person:name=A01"))]
    assert trajectory_windows(trajectories, "official-v1", "hold").names == ("A01", "A02", "dp@all")


def test_a_policy_learns_from_those_who_act() -> None:
    trajectory = walked(ticks=5, people=("ann", "bob"))
    kinds: tuple[SeatKind, ...] = ("human", "agent", "remote", "ghost", "idle")
    for choice, learned in (("acting", kinds[:3]), ("human", kinds[:1]), ("all", kinds)):
        found = [kind for kind in kinds if 0 in learned_seats(replace(trajectory, kinds=(kind, "agent")), choice)]  # type: ignore[arg-type]
        assert tuple(found) == learned
    in_match = replace(trajectory, participants=("idle:lag=1", "bass@all"))  # an agent of that name
    assert learned_seats(in_match, "acting") == (1,)
    assert len(trajectory_windows([in_match], "official-v1", "hold")) == 5
    with pytest.raises(DataError, match="--seats all"):
        windows_of(trajectory_samples([in_match], "official-v1", "hold", "human"))


def test_a_file_that_is_no_recording_is_named_with_its_folder(tmp_path: Path) -> None:
    for folder in ("monday", "tuesday"):
        recorded(tmp_path / folder, "one", ticks=5)
    (tmp_path / "tuesday" / "one.mcap").write_text("no recording")
    with pytest.raises(UnreadableError) as raised:
        read_trajectories(recording_files([tmp_path]))
    assert str(raised.value) == f"{tmp_path / 'tuesday' / 'one.mcap'}: one.mcap is not an MCAP file"


def test_recordings_are_read_back_as_they_were_played(tmp_path: Path) -> None:
    file = recorded(tmp_path, "one", ticks=25, seed=4, people=("ann", "bob"))
    (read,) = read_trajectories(recording_files([tmp_path]))
    trajectory = walked(ticks=25, seed=4)
    assert read.participants == ("ann", "bob")
    for name in ("robot_poses", "robot_velocities", "held", "item_poses", "actions"):
        assert np.array_equal(getattr(read, name), getattr(trajectory, name)), name
    assert data_hash([file]) == data_hash([file]) != data_hash([recorded(tmp_path, "two", ticks=25, seed=5)])


def test_a_folder_without_recordings_is_answered_with_the_command_that_makes_some(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="movingout demos generate"):
        recording_files([tmp_path])
    with pytest.raises(DataError, match="no recording at"):
        recording_files([tmp_path / "gone.mcap"])


def test_rows_are_of_one_side_or_the_other_unless_only_one_side_has_any() -> None:
    people = [{"ann"}, {"bob"}]
    out = held_out_episodes(people, 0.5, 0)
    mine, theirs = int(np.flatnonzero(~out)[0]), int(np.flatnonzero(out)[0])
    train, held_out = split_rows(np.array([mine, theirs, mine]), people, 0.5, 0)
    assert (train.tolist(), held_out.tolist()) == ([0, 2], [1])
    for alone in (mine, theirs):  # the other episode was too short to have rows
        assert [side.tolist() for side in split_rows(np.full(3, alone), people, 0.5, 0)] == [[0, 1, 2]] * 2
