"""GIF: an endless animation by Pillow, small enough for a README."""

from pathlib import Path
from typing import BinaryIO

from PIL import Image

from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.video import EpisodeVideo, write_videos

FPS = 10
COLOURS = 64  # few and undithered: flat areas stay flat and compress well


def write(plan: ExportPlan) -> None:
    """One .gif, or a folder of them."""
    write_videos(plan, ".gif", draw)


def draw(target: Path | BinaryIO, video: EpisodeVideo) -> None:
    first, *rest = video.frames(FPS)
    palette = first.quantize(COLOURS)
    pictures = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in (first, *rest)]
    pictures[0].save(target, "GIF", save_all=True, append_images=pictures[1:], duration=1000 // FPS, loop=0)
