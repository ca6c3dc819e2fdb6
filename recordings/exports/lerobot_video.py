"""What a seat sees as video files of a LeRobot data set: H.264 by PyAV, in which any frame is found quickly."""

import contextlib
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from movingout.maps.extras import needs_extra
from movingout.recordings.episode import Episode
from movingout.recordings.exports.feature_statistics import QUANTILES
from movingout.world.constants import TICKS_PER_SECOND
from movingout.world.raster import Pixels, pixels

with needs_extra("video", "a LeRobot data set with images (av)"):
    import av

VIDEO_BYTES = 200_000_000  # after an episode that reaches it, another file begins
_OPTIONS = {"g": "2", "bf": "0", "crf": "20", "preset": "fast"}  # a key frame in two, as LeRobot's own


def described(side: int) -> dict[str, Any]:
    """The feature as info.json describes it."""
    info = {
        **{"video.height": side, "video.width": side, "video.codec": "h264", "video.pix_fmt": "yuv420p"},
        **{"video.is_depth_map": False, "video.fps": TICKS_PER_SECOND, "video.channels": 3, "has_audio": False},
    }
    return {"dtype": "video", "shape": [side, side, 3], "names": ["height", "width", "channels"], "info": info}


def views(episode: Episode, seat: int, side: int) -> Iterator[Pixels]:
    """The pictures (side, side, 3) before each tick as `seat` sees them; -1, both, as blue does."""
    for state in episode.states[: len(episode.ticks)]:
        yield pixels(episode.header.map, state, max(seat, 0), side)


class VideoFiles(contextlib.ExitStack):
    """The video files of a data set while they are written, one after the other."""

    def __init__(self, folder: Path, side: int, files_per_chunk: int) -> None:
        super().__init__()
        self.colours = Colours()  # of all frames
        self._folder, self._side, self._files_per_chunk = folder, side, files_per_chunk
        self._files = self._frames = 0
        self._path = folder
        self._container: Any = None
        self._stream: Any = None
        self.callback(self._finish)

    def add(self, key: str, pictures: Iterator[Pixels]) -> dict[str, Any]:
        """Append an episode; the columns of its row that say where it is and what it looks like."""
        if self._container is None or self._path.stat().st_size >= VIDEO_BYTES:
            self._finish()
            self._begin()
        first, colours = self._frames, Colours()
        for picture in pictures:
            colours.add(picture)
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = self._frames, Fraction(1, TICKS_PER_SECOND)
            self._container.mux(self._stream.encode(frame))
            self._frames += 1
        self.colours.merge(colours)
        chunk, file = divmod(self._files - 1, self._files_per_chunk)
        return {
            f"videos/{key}/chunk_index": chunk,
            f"videos/{key}/file_index": file,
            f"videos/{key}/from_timestamp": first / TICKS_PER_SECOND,
            f"videos/{key}/to_timestamp": self._frames / TICKS_PER_SECOND,
            **{f"stats/{key}/{name}": value for name, value in colours.told().items()},
        }

    def _begin(self) -> None:
        chunk, file = divmod(self._files, self._files_per_chunk)
        self._path = self._folder / f"chunk-{chunk:03d}" / f"file-{file:03d}.mp4"
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._container = av.open(str(self._path), "w", format="mp4")
        self._stream = self._container.add_stream("libx264", rate=TICKS_PER_SECOND, options=dict(_OPTIONS))
        self._stream.pix_fmt, self._stream.width, self._stream.height = "yuv420p", self._side, self._side
        self._files, self._frames = self._files + 1, 0

    def _finish(self) -> None:
        if self._container is not None:
            self._container.mux(self._stream.encode(None))
            self._container.close()
            self._container = None


class Colours:
    """How often each value of each colour channel occurs, from which statistics are exact."""

    def __init__(self) -> None:
        self._counts = np.zeros((3, 256), dtype=np.int64)
        self._frames = 0

    def add(self, picture: Pixels) -> None:
        for channel in range(3):
            self._counts[channel] += np.bincount(picture[..., channel].ravel(), minlength=256)
        self._frames += 1

    def merge(self, other: "Colours") -> None:
        self._counts += other._counts
        self._frames += other._frames

    def told(self) -> dict[str, Any]:
        """As LeRobot has it: per channel (3, 1, 1), colours from 0 to 1; `count` is of frames."""
        values, total = np.arange(256) / 255, self._counts.sum(axis=1)
        mean = self._counts @ values / total
        deviation = np.sqrt((self._counts * (values - mean[:, None]) ** 2).sum(axis=1) / total)
        upto = self._counts.cumsum(axis=1)
        quantiles = {
            f"q{round(share * 100):02d}": _shaped(values[(upto <= share * (total[:, None] - 1)).sum(axis=1)])
            for share in QUANTILES
        }
        seen = self._counts > 0
        return {
            "min": _shaped(values[seen.argmax(axis=1)]),
            "max": _shaped(values[255 - seen[:, ::-1].argmax(axis=1)]),
            "mean": _shaped(mean),
            "std": _shaped(deviation),
            "count": [self._frames],
            **quantiles,
        }


def _shaped(channels: npt.NDArray[np.float64]) -> list[list[list[float]]]:
    return [[[value]] for value in channels.tolist()]
