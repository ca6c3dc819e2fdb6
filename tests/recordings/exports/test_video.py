"""The pictures of a video: in even steps, and the end among them."""

from pathlib import Path

import pytest

from movingout.recordings import finalise, read_episode
from movingout.recordings.exports import gif
from movingout.recordings.exports.video import EpisodeVideo
from movingout.recordings.replay import replay_poses
from tests.recordings.support import record


@pytest.mark.parametrize(("ticks", "speed", "count"), [(23, 4.0, 7), (20, 4.0, 6), (3, 1.0, 4), (3, 100.0, 2)])
def test_a_video_ends_with_the_end(ticks: int, speed: float, count: int, tmp_path: Path) -> None:
    """At four times the speed of the game the last delivery was on none of the pictures."""
    episode = read_episode(finalise(record(tmp_path, ticks=ticks)[0]))
    poses, _ = replay_poses(episode)
    video = EpisodeVideo(episode, poses, 64, speed, 1.0, overlay=True)
    pictures = list(video.frames(gif.FPS))
    assert len(pictures) == count
    assert pictures[-1].tobytes() == video.at(video.seconds).tobytes()
