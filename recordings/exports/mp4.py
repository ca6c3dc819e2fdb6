"""MP4: H.264 by PyAV, at real time or faster."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.video import EpisodeVideo, write_videos

FPS = 25


def write(plan: ExportPlan) -> None:
    """One .mp4, or a folder of them."""
    write_videos(plan, ".mp4", draw)


def draw(path: Path, video: EpisodeVideo) -> None:
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=Fraction(FPS), options={"crf": "23", "preset": "fast"})
        stream.pix_fmt = "yuv420p"
        for number, picture in enumerate(video.frames(FPS)):
            if number == 0:
                stream.width, stream.height = picture.size
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.asarray(picture), format="rgb24")))
        container.mux(stream.encode(None))
