"""Episodes of another recipe that have the name of one that is asked for are not kept silently."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from movingout.agents.checkpoint.checkpoint import fingerprint
from movingout.agents.data import demonstrations, recipes
from movingout.agents.data.corrections import load_correction, save_correction
from movingout.agents.data.dagger import EXPERT, LabellingJob
from movingout.agents.data.demonstrations import EpisodeJob, label_all, of_other_code, write_all, write_episode
from movingout.agents.data.recipes import check_labels, weights_of
from movingout.agents.errors import DataError
from movingout.maps import MapSpec, load_map, map_from_json, map_to_json
from movingout.recordings import read_episode


class Somebody(NamedTuple):
    name: str
    agent_id: str
    sha256: str = ""


HANDOFF = load_map("HandOff")
LABELS = LabellingJob(HANDOFF, learner="idle", expert="idle", partner=("ann", "idle"), seat=0, seed=3, ticks=4)
EPISODE = EpisodeJob("one", HANDOFF, (Somebody("A", "idle"), Somebody("B", "greedy")), seed=3, ticks=4)


def _changed(the_map: MapSpec) -> MapSpec:
    document: dict[str, Any] = map_to_json(the_map)
    document["robots"]["blue"]["x"] += 0.1
    return map_from_json(document)


def _label(job: LabellingJob, folder: Path) -> list[Path]:
    return [made.path for made in label_all([job], folder, 1)]


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        ({"expert": EXPERT}, f"with the expert idle, not {EXPERT}"),
        ({"partner": ("ann", "greedy")}, "with the partner idle, not greedy"),
        ({"ticks": 5}, "with the ticks 4, not 5"),
        ({"map": _changed(HANDOFF)}, "with another version of the map HandOff"),
    ],
)
def test_labels_of_another_recipe_are_refused(other: Mapping[str, Any], sentence: str, tmp_path: Path) -> None:
    (path,) = _label(LABELS, tmp_path)
    assert _label(LABELS, tmp_path) == []
    with pytest.raises(DataError) as refused:
        _label(replace(LABELS, **other), tmp_path)
    assert str(refused.value) == f"{path} is there already, {sentence}; choose another --out"


def test_labels_of_another_learner_whose_file_has_the_same_name_are_refused(tmp_path: Path) -> None:
    (path,) = _label(replace(LABELS, learner="late:agent=idle,delay=1"), tmp_path)
    with pytest.raises(DataError, match="with the learner late:agent=idle,delay=1, not late:agent=idle;delay=1;"):
        _label(replace(LABELS, learner="late:agent=idle;delay=1"), tmp_path)
    assert path.exists()


def test_labels_of_earlier_weights_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for sha in ("old", "new"):
        monkeypatch.setattr(recipes, "fingerprint", lambda agent_id, now=sha: now if agent_id == "idle" else "")
        if sha == "old":
            _label(LABELS, tmp_path)
    with pytest.raises(DataError, match="is there already, with other weights of idle; choose another --out"):
        _label(LABELS, tmp_path)


def test_files_of_before_there_were_recipes_are_of_the_default_expert(tmp_path: Path) -> None:
    usual = replace(LABELS, expert=EXPERT)
    (path,) = _label(usual, tmp_path)
    save_correction(path, load_correction(path))  # as earlier versions did
    assert _label(usual, tmp_path) == []
    with pytest.raises(DataError, match=f"with the expert {EXPERT}, not idle"):
        _label(LABELS, tmp_path)
    with pytest.raises(DataError, match="with the ticks 4, not 5"):
        _label(replace(usual, ticks=5), tmp_path)
    check_labels(path, usual)


@pytest.mark.parametrize(
    ("other", "sentence"),
    [
        (
            {"seats": (Somebody("A", "idle"), Somebody("B", "novice"))},
            "with the agents greedy and idle, not idle and novice",
        ),
        ({"ticks": 5}, "with the ticks 4, not 5"),
        ({"map": _changed(HANDOFF)}, "with another version of the map HandOff"),
    ],
)
def test_recordings_of_another_recipe_are_refused(other: Mapping[str, Any], sentence: str, tmp_path: Path) -> None:
    (made,) = write_all([EPISODE], tmp_path, 1)
    with pytest.raises(DataError) as refused:
        list(write_all([replace(EPISODE, **other)], tmp_path, 1))
    assert str(refused.value) == f"{made.path} is there already, {sentence}; choose another --out"
    swapped = replace(EPISODE, seats=EPISODE.seats[::-1], seed=4)  # as with more episodes per pair
    assert list(write_all([EPISODE], tmp_path, 1)) == list(write_all([swapped], tmp_path, 1)) == []


def test_recordings_of_earlier_weights_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for sha in ("old", "new"):
        monkeypatch.setattr(recipes, "fingerprint", lambda agent_id, now=sha: now if agent_id == "greedy" else "")
        if sha == "old":
            (made,) = write_all([EPISODE], tmp_path, 1)
    assert read_episode(made.path).header.seats[1].checkpoint_sha256 == "old"
    with pytest.raises(DataError, match="is there already, with other weights of greedy; choose another --out"):
        list(write_all([EPISODE], tmp_path, 1))


def test_recordings_of_before_an_agent_had_a_hash_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (made,) = write_all([EPISODE], tmp_path, 1)
    assert read_episode(made.path).header.seats[1].checkpoint_sha256 == ""
    monkeypatch.setattr(recipes, "fingerprint", lambda agent_id: "new")
    assert list(write_all([EPISODE], tmp_path, 1)) == []


def test_the_usual_agent_inside_another_has_its_weights() -> None:
    assert weights_of(["clone:seed=3"]) == {"clone:seed=3": fingerprint("dp@all")}


def test_a_file_that_is_no_episode_is_not_kept(tmp_path: Path) -> None:
    (path,) = _label(LABELS, tmp_path)
    path.write_bytes(b"x")
    with pytest.raises(DataError, match="is not a file of corrections"):
        _label(LABELS, tmp_path)


def test_episodes_of_other_code_are_kept_and_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    of_before = replace(EPISODE, episode_id="two")
    write_episode(of_before, tmp_path)  # without a hash of the code
    todo: list[EpisodeJob | LabellingJob] = [EPISODE, of_before, LABELS]
    assert len([*write_all([EPISODE], tmp_path, 1), *_label(LABELS, tmp_path)]) == 2
    assert of_other_code(todo, tmp_path) == 1, "that of before"
    monkeypatch.setattr(demonstrations, "code_sha256", lambda: "other")
    assert of_other_code(todo, tmp_path) == 3
    assert [*write_all([EPISODE, of_before], tmp_path, 1), *_label(LABELS, tmp_path)] == []
