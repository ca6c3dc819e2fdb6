"""A finished round as one small picture or animation to send to somebody: PNG or GIF bytes without any name."""

import io
from pathlib import Path
from typing import Literal, get_args

from PIL import Image

from movingout.recordings.errors import RecordingError
from movingout.recordings.exports import gif
from movingout.recordings.exports.video import EpisodeVideo
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.replay import replay_poses
from movingout.recordings.report.words import DEFAULT, Words
from movingout.world.constants import TICK_SECONDS

ShareKind = Literal["png", "gif"]
SHARE_KINDS: tuple[ShareKind, ...] = get_args(ShareKind)

PICTURE_SIDE = 720  # pixels
ANIMATION_SIDE = 320  # pixels
SPEED = 4.0  # at least so many times as fast as the game
LONGEST_S = 12.0  # of an animation; a longer round runs faster


def share_bytes(path: Path, kind: ShareKind, language: str = DEFAULT) -> bytes:
    """The end of a recorded round as PNG, or the whole round as GIF, with a caption in a language.

    Who played is not on it: whoever gets it need not know. Raises RecordingError for a file that cannot be read.
    """
    episode = read_episode(path)
    if not episode.ticks:
        raise RecordingError("nothing was played in this round")
    poses, _ = replay_poses(episode)
    speed = max(SPEED, len(episode.ticks) * TICK_SECONDS / LONGEST_S)
    side = PICTURE_SIDE if kind == "png" else ANIMATION_SIDE
    video = EpisodeVideo(episode, poses, side, speed, every_s=1.0, overlay=True, named=False, words=Words(language))
    out = io.BytesIO()
    if kind == "gif":
        gif.draw(out, video)
    else:
        video.at(video.seconds).quantize(gif.COLOURS, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()
