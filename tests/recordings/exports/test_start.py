"""What lies in a goal from the start is delivered from the start, in every export; there is no delivery in tick 1."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

from movingout.maps import MapSpec, Pose, load_map, map_to_json
from movingout.matches import play
from movingout.recordings import Episode, finalise, read_episode
from movingout.recordings.exports.tables import episode_row, tick_rows
from movingout.recordings.exports.video import EpisodeVideo
from movingout.recordings.file_format.derived_topics import result
from movingout.recordings.replay import replay_poses
from tests.recordings.support import begin, record


@pytest.fixture(scope="module")
def home() -> MapSpec:
    designed = load_map("HandOff")
    goal = designed.goals[0]
    pose = Pose((goal.x0 + goal.x1) / 2, (goal.y0 + goal.y1) / 2, 0.0)
    items = (replace(designed.items[0], scale=0.04, pose=pose), *designed.items[1:])
    return replace(designed, name="Mine", items=items)


@pytest.fixture
def episode(home: MapSpec, tmp_path: Path) -> Episode:
    return read_episode(finalise(record(tmp_path, ticks=2, map=home)[0]))


def test_the_first_row_says_so(episode: Episode) -> None:
    rows = list(tick_rows(episode))
    assert [(row["delivered"], row["item_0_delivered"], row["item_1_delivered"]) for row in rows] == [
        (1, True, False)
    ] * 3


def test_an_episode_without_ticks_says_so(home: MapSpec, tmp_path: Path) -> None:
    writer, _ = begin(tmp_path, map=home)
    episode = read_episode(writer.close("stopped"))
    assert episode_row(episode, "train")["delivered"] == result(episode)["delivered"] == 1


def test_the_first_picture_says_so(episode: Episode, monkeypatch: pytest.MonkeyPatch) -> None:
    counts: list[int] = []

    def captioned(video: EpisodeVideo, picture: Image.Image, time_s: float, delivered: int) -> Image.Image:
        counts.append(delivered)
        return picture

    monkeypatch.setattr(EpisodeVideo, "_captioned", captioned)
    video = EpisodeVideo(episode, replay_poses(episode)[0], 64, 1.0, 1.0, overlay=True)
    video.at(0.0)
    video.at(0.1)
    assert counts == [1, 1]


def test_a_match_records_no_delivery_that_never_happened(home: MapSpec, tmp_path: Path) -> None:
    path = tmp_path / "Mine.json"
    path.write_text(json.dumps(map_to_json(home)), encoding="utf-8")
    with pytest.warns(UserWarning, match=r"Mine\.json"):
        play("idle", "idle", map=str(path), ticks=2, workers=1, record=tmp_path / "recordings")
    (recording,) = (tmp_path / "recordings").iterdir()
    assert [event.kind for event in read_episode(recording).events] == ["start", "end"]
