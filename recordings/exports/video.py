"""An episode as pictures at any time of play, drawn as the browser draws them."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw, ImageFont

from movingout.maps.picture import paint_scene
from movingout.maps.scene import LIGHT, SceneState
from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.recordings.exports.plan import ExportPlan
from movingout.recordings.exports.target import new_target
from movingout.recordings.file_format.reader import read_episode
from movingout.recordings.progress import map_in_processes
from movingout.recordings.replay import replay_poses
from movingout.recordings.report.words import Words
from movingout.world.constants import POSE_SECONDS, POSES_PER_TICK, TICK_SECONDS

_CAPTION = 0.075  # height of the caption, in sides of the picture
_LETTERS = 14  # of a name on the caption

Draw = Callable[[Path, "EpisodeVideo"], None]


@dataclass(frozen=True, slots=True)
class EpisodeVideo:
    """An episode that can be drawn at any time of play."""

    episode: Episode
    poses: Any  # (1 + 5 T, 2 + N, 3) at 20 ms
    side: int
    speed: float
    every_s: float
    overlay: bool
    named: bool = True  # the players' names on the overlay
    words: Words = field(default_factory=Words)

    @property
    def seconds(self) -> float:
        return len(self.episode.ticks) * TICK_SECONDS

    def frames(self, fps: int) -> Iterator[Image.Image]:
        """Pictures for a video of `fps` pictures per second that runs `speed` times as fast as the game.

        The end is the last one, though the one before may be nearer: it may be what delivers the last item.
        """
        step = self.speed / fps
        whole = int(self.seconds / step)
        for number in range(whole + 1):
            yield self.at(number * step)
        if self.seconds - whole * step > POSE_SECONDS / 2:
            yield self.at(self.seconds)

    def at(self, time_s: float) -> Image.Image:
        """The picture at a time of play; between two poses the earlier one."""
        pose = min(int(time_s / TICK_SECONDS * POSES_PER_TICK + 1e-6), len(self.poses) - 1)
        tick = -(-pose // POSES_PER_TICK)  # what is held and delivered after the tick that this pose belongs to
        spec = self.episode.header.map
        state = self.episode.states[tick]
        delivered = self.episode.delivered_after(tick)
        robots, items = self.poses[pose, :2].tolist(), self.poses[pose, 2:].tolist()
        drawn = SceneState(robots, items, state.held.tolist(), delivered)
        picture = paint_scene(spec, drawn, self.side)
        return self._captioned(picture, time_s, sum(delivered)) if self.overlay else picture

    def _captioned(self, picture: Image.Image, time_s: float, delivered: int) -> Image.Image:
        """Who plays, when it is, and how much is delivered, on a bar below the picture."""
        header = self.episode.header
        bar = 2 * round(self.side * _CAPTION / 2)  # video codecs want even sizes
        canvas = Image.new("RGB", (self.side, self.side + bar), LIGHT.surface)
        canvas.paste(picture)
        draw = ImageDraw.Draw(canvas)
        font = ImageFont.load_default(bar * 0.5)
        middle, gap = self.side + bar / 2, bar * 0.3
        time = self.words.decimal(f"{time_s:4.1f}")
        text = f"{self.words.map_title(header.map)}  {time} s  {delivered}/{len(header.map.items)}"
        draw.text((self.side / 2, middle), text, LIGHT.ink, font, anchor="mm")
        if self.named:
            draw.text((gap, middle), _short(header.seats[0].name), LIGHT.blue, font, anchor="lm")
            draw.text((self.side - gap, middle), _short(header.seats[1].name), LIGHT.red, font, anchor="rm")
        return canvas


def _short(name: str) -> str:
    return name if len(name) <= _LETTERS else f"{name[: _LETTERS - 1]}…"


@dataclass(frozen=True, slots=True)
class _Job:
    """One recording to be drawn, perhaps by another process."""

    recording: Path
    target: Path
    draw: Draw
    plan: ExportPlan

    def run(self) -> None:
        episode = read_episode(self.recording)
        plan = self.plan
        poses, _ = replay_poses(episode)
        self.draw(self.target, EpisodeVideo(episode, poses, plan.side // 2 * 2, plan.speed, plan.every_s, plan.overlay))


def write_videos(plan: ExportPlan, suffix: str, draw: Draw) -> None:
    """One recording into the file that was named; several, side by side on all cores, into a folder.

    Raises RecordingError.
    """
    if not (0.1 <= plan.speed <= 100 and 0.1 <= plan.every_s <= 3600 and 64 <= plan.side <= 2048):
        raise RecordingError(
            "--speed goes from 0.1 to 100, --every from 0.1 to 3600 s, the side of a picture from 64 to 2048 pixels"
        )
    single = plan.target.suffix != ""
    if single and (plan.target.suffix != suffix or len(plan.recordings) > 1):
        raise RecordingError(f"{plan.target.name}: one recording becomes NAME{suffix}, several a folder without ending")
    with new_target(plan.target) as part:
        if not single:
            part.mkdir()
        jobs = [
            _Job(path, part if single else part / f"{players.episode_id}{suffix}", draw, plan)
            for path, players in zip(plan.recordings, plan.players, strict=True)
        ]
        for _ in map_in_processes(_Job.run, jobs, os.cpu_count() or 1, "drawing"):
            pass
