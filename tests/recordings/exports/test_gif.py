"""The animation as a viewer reads it."""

import io
import tracemalloc
from unittest import mock

from PIL import Image, ImageChops, ImageSequence

from movingout.recordings.exports import gif


def test_a_gif_shows_what_was_drawn_and_keeps_no_pictures_in_memory() -> None:
    """The largest rise of memory is that of some pictures, not of all of them."""
    drawn = [Image.new("RGB", (300, 300), (250, 250, 250)) for _ in range(3)]
    for number, picture in enumerate(drawn):
        picture.paste((200, 30, 40), (20 * number, 10, 60 + 20 * number, 90))
    order = [0, 1, 1, 2, 0] * 80
    out = io.BytesIO()
    tracemalloc.start()
    gif.draw(out, mock.Mock(frames=lambda fps: (drawn[number].copy() for number in order)))
    written = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert written < 40 * 300 * 300
    with Image.open(out) as animation:
        assert animation.info["loop"] == 0
        seen, lasted = [], []
        for frame in ImageSequence.Iterator(animation):
            seen.append(frame.convert("RGB"))
            lasted.append(frame.info["duration"])
    assert lasted[:4] == [100, 200, 100, 200]  # from 0 at the end to 0 at the beginning nothing changes
    for number, frame in zip([0, 1, 2, 0, 1, 2], seen, strict=False):
        assert ImageChops.difference(frame, drawn[number]).getextrema() == ((0, 0),) * 3
