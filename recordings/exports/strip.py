"""PNG: a strip of pictures side by side, for a paper."""

from pathlib import Path

from PIL import Image

from movingout.maps.scene import LIGHT
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.video import EpisodeVideo, write_videos
from movingout.world.constants import TICK_SECONDS


def write(plan: ExportPlan) -> None:
    """One .png, or a folder of them."""
    write_videos(plan, ".png", draw)


def draw(path: Path, video: EpisodeVideo) -> None:
    """Pictures `every_s` seconds apart, the start and the end included."""
    times = [number * video.every_s for number in range(int(video.seconds / video.every_s) + 1)]
    if video.seconds - times[-1] > TICK_SECONDS / 2:
        times.append(video.seconds)
    pictures = [video.at(time_s) for time_s in times]
    width, height = pictures[0].size
    step = width + gap(width)
    strip = Image.new("RGB", (step * len(pictures) - gap(width), height), LIGHT.small)
    for place, picture in enumerate(pictures):
        strip.paste(picture, (place * step, 0))
    strip.save(path, "PNG", optimize=True)


def gap(width: int) -> int:
    """Pixels between two pictures."""
    return max(width // 64, 2)
