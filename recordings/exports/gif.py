"""GIF: an endless animation by Pillow, small enough for a README; written picture by picture."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from PIL import GifImagePlugin, Image, ImageChops

from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.video import EpisodeVideo, write_videos

FPS = 10
_PICTURE_MS = 1000 // FPS
COLOURS = 64  # few and undithered: flat areas stay flat and compress well
_UNCHANGED = COLOURS - 1  # the transparent one


def write(plan: ExportPlan) -> None:
    """One .gif, or a folder of them."""
    write_videos(plan, ".gif", draw)


def draw(target: Path | BinaryIO, video: EpisodeVideo) -> None:
    with target.open("wb") if isinstance(target, Path) else contextlib.nullcontext(target) as file:
        for block in _blocks(video.frames(FPS)):
            file.write(block)


def _blocks(pictures: Iterator[Image.Image]) -> Iterator[bytes]:
    """The bytes of the file. Pillow's `save` would keep all pictures in memory; here it is two.

    Equal pictures in a row are one that stays longer; of others only the part that changed is written.
    """
    first = next(pictures)
    palette = first.quantize(COLOURS - 1)
    shown = first.quantize(palette=palette, dither=Image.Dither.NONE)
    header, _ = GifImagePlugin.getheader(shown, info={"loop": 0})
    yield from header
    changed, corner, duration = shown, (0, 0), _PICTURE_MS
    for picture in pictures:
        now = picture.quantize(palette=palette, dither=Image.Dither.NONE)
        differs = Image.fromarray(np.asarray(now) != np.asarray(shown))
        box = differs.getbbox()
        if box is None:
            duration += _PICTURE_MS
            continue
        yield from GifImagePlugin.getdata(changed, corner, duration=duration, transparency=_UNCHANGED)
        shown, changed, corner, duration = now, now.crop(box), box[:2], _PICTURE_MS
        changed.paste(_UNCHANGED, None, ImageChops.invert(differs.crop(box).convert("L")))
    yield from GifImagePlugin.getdata(changed, corner, duration=duration, transparency=_UNCHANGED)
    yield b";"
