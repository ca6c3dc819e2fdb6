"""MP4: H.264 by PyAV, at real time or faster."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from movingout.recordings.exports.film import Film, write_films
from movingout.recordings.exports.plan import Plan

FPS = 25


def write(plan: Plan) -> None:
    """One .mp4, or a folder of them."""
    write_films(plan, ".mp4", draw)


def draw(path: Path, film: Film) -> None:
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=Fraction(FPS), options={"crf": "23", "preset": "fast"})
        stream.pix_fmt = "yuv420p"
        for number, picture in enumerate(film.frames(FPS)):
            if number == 0:
                stream.width, stream.height = picture.size
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.asarray(picture), format="rgb24")))
        container.mux(stream.encode(None))
