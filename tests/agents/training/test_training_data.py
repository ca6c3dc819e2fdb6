"""Who is left out of the training data, whatever they are called there."""

import hashlib
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.data.corrections import save_correction
from movingout.agents.data.dagger import LabellingJob, label_episode
from movingout.agents.data.dataset import learned_seats, read_trajectories
from movingout.agents.data.demonstrations import EpisodeJob, label_all, write_all
from movingout.agents.errors import DataError
from movingout.agents.partners.families import group
from movingout.agents.training.training_data import read_training_data
from movingout.maps import load_map, map_from_json, map_to_json
from movingout.recordings.episode import SeatKind
from tests.agents.learning import recorded
from tests.agents.support import HERE

MINE = f"{HERE}:Forward:distance=0.5"
GREEDY = "greedy:seed=0,order=near,patience=40"  # a member of the family
LATE = "late:agent=person:name=A03;stick=8,seed=1"
CLONE = "clone:policy=dp@all,seed=7"
HANDOFF = load_map("HandOff")


@pytest.fixture
def labels(tmp_path: Path) -> Path:
    """An episode beside each partner of a list, as `demos label` writes it, and one beside somebody else."""
    (tmp_path / "partners.txt").write_text("\n".join((MINE, GREEDY, LATE)))
    partners = [(one.name, one.agent_id) for one in group(f"@{tmp_path / 'partners.txt'}")] + [("ann", "idle")]
    jobs = [LabellingJob(HANDOFF, "idle", "idle", one, 0, seed, 4) for seed, one in enumerate(partners)]
    assert len(list(label_all(jobs, tmp_path / "labels", 1))) == 4
    return tmp_path / "labels"


@pytest.mark.parametrize("name", [MINE, GREEDY, "family:greedy", "@LIST", LATE, "person:name=A03", "people:A"])
def test_partners_of_a_list_are_left_out_by_their_id_and_by_their_family(name: str, labels: Path) -> None:
    data = read_training_data([labels], [name.replace("@LIST", f"@{labels.parent / 'partners.txt'}")])
    assert len(data.files) == (1 if name == "@LIST" else 3)


def test_partners_whose_labels_say_no_id_are_left_out_by_the_name_of_a_list(tmp_path: Path) -> None:
    """As files written before ids were kept."""
    (tmp_path / "partners.txt").write_text(f"{MINE}\n{GREEDY}\nidle\n")
    for seed, one in enumerate(group(f"@{tmp_path / 'partners.txt'}")):
        job = LabellingJob(HANDOFF, "idle", "idle", (one.name, one.agent_id), 0, seed, 4)
        save_correction(tmp_path / f"{seed}.corrections.npz", label_episode(job))
    for name in (MINE, "family:greedy"):
        assert len(read_training_data([tmp_path], [name]).files) == 2


def test_recordings_of_maps_that_a_layout_does_not_see_are_named(tmp_path: Path) -> None:
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    five = map_from_json(map_to_json(load_map("Simple")) | {"name": "Five", "goals": goals})
    for name, the_map in (("a", HANDOFF), ("c", five)):
        label = label_episode(LabellingJob(the_map, "idle", "idle", ("ann", "idle"), 0, 0, 4))
        save_correction(tmp_path / f"{name}.corrections.npz", label)
    idle = group("idle")[0]
    assert len(list(write_all([EpisodeJob("b", five, (idle, idle), 0, 4)], tmp_path, 1))) == 1
    recorded(tmp_path, "0", ticks=4, source="tutorial")  # from which nothing is learned
    data = read_training_data([tmp_path])
    data.check_seen("image-v1")
    why = "b.mcap: the layout aware-v1 has 4 slots for goals; Five has 5; leave it out, and 1 other with such maps"
    with pytest.raises(DataError, match=re.escape(why)):
        data.check_seen("aware-v1")


def test_a_recording_that_is_there_twice_is_learned_from_once(tmp_path: Path) -> None:
    """A backup counted as a second play."""
    original = recorded(tmp_path / "a", "one", ticks=4)
    (tmp_path / "b").mkdir()
    shutil.copy(original, tmp_path / "b" / "renamed.mcap")
    recorded(tmp_path / "b", "two", ticks=4)
    data = read_training_data([tmp_path / "a", tmp_path / "b"])
    assert ([file.name for file in data.files], data.copies) == (
        ["one.mcap", "two.mcap"],
        [tmp_path / "b" / "renamed.mcap"],
    )


def test_a_recording_in_which_nothing_was_played_is_left_out(tmp_path: Path) -> None:
    """One match whose agent failed at once blocked a training."""
    empty = recorded(tmp_path, "empty", ticks=0, outcome="error")
    one = recorded(tmp_path, "one", ticks=4)
    data = read_training_data([tmp_path])
    assert (data.files, data.empty, len(data.trajectories)) == ([one], [empty], 1)
    assert len(read_trajectories([empty, one])) == 1


def test_partners_of_a_list_are_left_out_of_demonstrations(tmp_path: Path) -> None:
    (tmp_path / "partners.txt").write_text(f"{MINE}\n{GREEDY}\n")
    pair = group(f"@{tmp_path / 'partners.txt'}")
    list(write_all([EpisodeJob("one", HANDOFF, (pair[0], pair[1]), 0, 4)], tmp_path / "demos", 1))
    recorded(tmp_path / "demos", "two", ticks=4)
    for name in (MINE, GREEDY, "family:greedy"):
        assert len(read_training_data([tmp_path / "demos"], [name]).files) == 1


def test_clones_of_a_policy_are_left_out_with_it(tmp_path: Path) -> None:
    recorded(tmp_path, "one", ticks=4, people=("a", CLONE), source="match")
    recorded(tmp_path, "two", ticks=4)
    assert len(read_training_data([tmp_path], ["dp@all"]).files) == 1


def test_each_name_that_leaves_nothing_out_is_refused(labels: Path) -> None:
    with pytest.raises(DataError) as refused:
        read_training_data([labels], ["family:greedy", "family:porter", "people:B"])
    assert str(refused.value) == (
        "nobody named by --without family:porter or --without people:B plays in any of these 4 episodes; correct the "
        "name or leave it out"
    )


@pytest.mark.parametrize("name", ["person:name=C03", "person:name=C03,stick=8", "late:agent=person:name=C04,seed=1"])
def test_people_for_tests_are_found_in_matches_and_in_labels(name: str, tmp_path: Path) -> None:
    recorded(tmp_path / "match", "one", ticks=4, people=("dp@all", name), source="match")
    assert read_training_data([tmp_path / "match"]).learns_from_tests
    (tmp_path / "partners.txt").write_text(name)
    (partner,) = group(f"@{tmp_path / 'partners.txt'}")
    job = LabellingJob(HANDOFF, "idle", "idle", (partner.name, partner.agent_id), 0, 1, 4)
    list(label_all([job], tmp_path / "labels", 1))
    assert read_training_data([tmp_path / "labels"]).learns_from_tests


def test_others_and_somebody_who_has_the_name_of_one_are_not_taken_for_people_for_tests(tmp_path: Path) -> None:
    recorded(tmp_path, "one", ticks=4, people=("person:name=B03", "late:agent=person:name=A04"), source="match")
    recorded(tmp_path, "two", ticks=4, people=("C03", "C04"), kinds=("human", "human"), source="live")
    assert not read_training_data([tmp_path]).learns_from_tests


@pytest.mark.parametrize("before", [True, False])
def test_labels_without_a_tick_keep_nobody_from_training(before: bool, tmp_path: Path) -> None:
    document = map_to_json(HANDOFF) | {"name": "Done", "goals": [{"x0": -1.2, "y0": 1.2, "x1": 1.2, "y1": -1.2}]}
    empty = label_episode(LabellingJob(map_from_json(document), "idle", "idle", ("ann", "idle"), 0, 1, 4))
    assert (empty.trajectory.ticks, empty.labels.shape) == (0, (0, 5))
    if before:  # as files were written
        empty = replace(
            empty, labels=np.zeros(0, dtype=np.float32), trajectory=replace(empty.trajectory, actions=np.zeros(0))
        )
    save_correction(tmp_path / "empty.corrections.npz", empty)
    with pytest.raises(DataError, match=r"^no episode has a tick; name other recordings$"):
        read_training_data([tmp_path])
    recorded(tmp_path, "one", ticks=4)
    assert [file.name for file in read_training_data([tmp_path]).files] == ["one.mcap"]


@pytest.mark.parametrize(
    ("people", "kinds", "acting", "human", "whole"),
    [
        (("", ""), ("human", "human"), True, True, True),
        (("P1", "P2"), ("human", "human"), False, False, False),
        (("P1", "dp"), ("human", "agent"), True, False, True),
        (("P1", "dp@all"), ("human", "agent"), True, False, False),
        (("P1", ""), ("human", "idle"), False, False, True),
        (("A01", "dp@all"), ("agent", "agent"), False, False, False),
    ],
)
def test_who_counts_as_somebody_else_than_for_earlier_versions(
    tmp_path: Path, people: tuple[str, str], kinds: tuple[SeatKind, SeatKind], acting: bool, human: bool, whole: bool
) -> None:
    """In the seats that are learned from, or in whole episodes, of which trained agents were no people before."""
    recorded(tmp_path, "one", ticks=4, people=people, kinds=kinds)
    data = read_training_data([tmp_path])
    assert [data.counts_otherwise(seats) for seats in ("acting", "human", None)] == [acting, human, whole]


@pytest.mark.parametrize(
    ("people", "kinds", "population"),
    [
        (("", ""), ("agent", "agent"), "agents without a name (2 episodes)"),
        (("", ""), ("human", "agent"), "people without a name (2 episodes)"),
        (("bass@all", "ghost:e#red"), ("agent", "ghost"), "1 agent"),
        (("P@1", "dp@all"), ("human", "agent"), "1 participant"),
        (("A01", "dp@all"), ("agent", "agent"), "1 participant and 1 agent"),
        (("late:agent=person:name=A04", "greedy:patience=3"), ("agent", "agent"), "1 participant and 1 agent"),
        (("person:delay=3", "late:agent=person:delay=4"), ("agent", "agent"), "2 participants"),
        (("lab:Driver", "late:agent=dp@all"), ("agent", "agent"), "2 agents"),
        (("greedy", "dp@all"), ("human", "agent"), "1 participant"),
    ],
)
def test_agents_do_not_pass_for_people_in_a_card(
    tmp_path: Path, people: tuple[str, str], kinds: tuple[SeatKind, SeatKind], population: str
) -> None:
    for name in ("one", "two"):
        recorded(tmp_path, name, ticks=4, people=people, kinds=kinds)
    data = read_training_data([tmp_path])
    names = {one.whose(seat) for one in data.trajectories for seat in learned_seats(one, "acting")}
    assert data.population(names) == population


def test_replays_that_are_learned_from_are_no_participants(tmp_path: Path) -> None:
    recorded(tmp_path, "one", ticks=4, people=("bass@all", "ghost:e#red"), kinds=("agent", "ghost"))
    assert read_training_data([tmp_path]).population({"bass@all", "ghost:e#red"}) == "1 agent and 1 replay"


def test_a_run_goes_on_that_was_begun_when_agents_without_a_name_were_called_as_people(tmp_path: Path) -> None:
    """What they are called is in the hash that begun runs keep."""
    recorded(tmp_path, "one", ticks=4, people=("", ""), kinds=("agent", "agent"))
    pairs = b'[["nameless:one", "nameless:one"]]'
    assert read_training_data([tmp_path]).people_sha256 == hashlib.sha256(pairs).hexdigest()
