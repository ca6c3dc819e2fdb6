"""One episode as a 3D scene: bodies where they were at a tick, and optional layers over them.

Draws into any viser scene: one client's, or a server's for an offline page. It shows the tick it is told to; time and
controls are in `playback` and `panel`.
"""

import math
from dataclasses import dataclass

import numpy as np
import viser

from movingout.maps.scene import LIGHT
from movingout.maps.spec import ARENA_HALF, SEAT_COLOURS, ItemSpec
from movingout.recordings import meshes
from movingout.recordings.episode import Episode
from movingout.recordings.meshes import Mesh, Pixel
from movingout.recordings.occupancy import heat_picture, occupancy, smoothed
from movingout.recordings.viewer.candidates import HEIGHT as CANDIDATE_HEIGHT
from movingout.recordings.viewer.candidates import Candidate, Decisions, candidate_lines
from movingout.recordings.viewer.trails import segments, trail
from movingout.world.state import Floats

FLOOR_RGB: Pixel = (255, 255, 255)
HEAT_CHOICES: dict[str, tuple[int, ...]] = {"none": (), "blue": (0,), "red": (1,), "both": (0, 1)}
_HEAT_HEIGHT = 0.007  # just above the goals
_HEAT_PIXELS = 8  # per cell, so that the viewer's filter does not blur one cell into the next
_TRAIL_WIDTH, _CANDIDATE_WIDTH = 0.016, 0.012  # arena units
_LETTER_RGB: tuple[Pixel, Pixel] = ((255, 255, 255), (24, 33, 44))
_LETTER_SIZE, _LETTER_STROKE = 0.09, 0.014
_BOWL = [(0.0, 0.0), (0.0, 1.0), (0.55, 1.0), (0.7, 0.87), (0.7, 0.63), (0.55, 0.5), (0.0, 0.5)]
_STROKES = {
    "B": [_BOWL, [(0.55, 0.5), (0.7, 0.37), (0.7, 0.13), (0.55, 0.0), (0.0, 0.0)]],
    "R": [_BOWL, [(0.35, 0.5), (0.7, 0.0)]],
}


@dataclass(frozen=True, slots=True)
class Layers:
    """What is drawn over the bodies."""

    trail_ticks: int = 50  # how far back trails reach, 0 for none
    heat: str = "none"  # a key of HEAT_CHOICES
    candidates: bool = True


class EpisodeScene:
    """The scene nodes of one episode under `/name`, its arena centred on (`shift`, 0)."""

    def __init__(self, scene: viser.SceneApi, name: str, episode: Episode, shift: float = 0.0) -> None:
        self.episode = episode
        self.shift = shift
        self._scene, self._name, self._map = scene, name, episode.header.map
        self._root = scene.add_frame(f"/{name}", show_axes=False, position=(shift, 0.0, 0.0))
        self._add_arena()
        self.robots = [self._add_robot(seat) for seat in range(len(SEAT_COLOURS))]
        self.items = [self._add_item(item) for item in self._map.items]
        self.trails = [self._add_trail(seat) for seat in range(len(SEAT_COLOURS))]
        self._decisions = [Decisions(episode.decisions, seat, episode.states) for seat in range(len(SEAT_COLOURS))]
        self.labels: list[viser.LabelHandle] = []
        self._considered: list[Candidate] = []
        self._grids = [smoothed(occupancy(episode.states, seat)) for seat in range(len(SEAT_COLOURS))]
        self.heat: viser.ImageHandle | None = None
        self._heat_shown = "none"

    @property
    def last(self) -> int:
        """The last tick."""
        return len(self.episode.ticks)

    def show(self, tick: int, layers: Layers) -> None:
        """Put everything where it was after `tick` ticks; past the end the episode stands still."""
        tick = min(tick, self.last)
        state = self.episode.states[tick]
        for robot, (x, y, angle) in zip(self.robots, state.robot_poses.tolist(), strict=True):
            robot.position, robot.wxyz = (x, y, 0.0), _turned(angle)
        for mesh, (x, y, angle) in zip(self.items, state.item_poses.tolist(), strict=True):
            mesh.position, mesh.wxyz = (x, y, 0.0), _turned(angle)
        self._colour_items(tick)
        self._show_trails(tick, layers.trail_ticks)
        self._show_heat(layers.heat)
        self._show_candidates(self.considered(tick) if layers.candidates else [])

    def considered(self, tick: int) -> list[Candidate]:
        """What the agents' newest decisions up to `tick` considered."""
        return [one for decisions in self._decisions for one in decisions.at(tick)]

    def remove(self) -> None:
        """Take the whole episode out of the scene."""
        self._root.remove()

    # ---- building ------------------------------------------------------------------------------------------

    def _add_arena(self) -> None:
        side = 2 * ARENA_HALF
        self._scene.add_box(
            f"/{self._name}/floor", color=FLOOR_RGB, dimensions=(side, side, 0.02), position=(0.0, 0.0, -0.011)
        )
        for name, mesh, colour in meshes.map_meshes(self._map):
            self._add(f"map/{name}", mesh, meshes.pixel(colour))

    def _add_robot(self, seat: int) -> viser.FrameHandle:
        name, colour = SEAT_COLOURS[seat], meshes.pixel(meshes.SEAT_RGB[seat])
        frame = self._scene.add_frame(f"/{self._name}/{name}", show_axes=False)
        self._add(f"{name}/body", meshes.robot_mesh(), colour)
        self._add(f"{name}/nose", meshes.nose_mesh(), (250, 250, 250))
        self._scene.add_line_segments(
            f"/{self._name}/{name}/letter",
            letter_lines(name[0].upper()),
            _LETTER_RGB[seat],
            thickness=_LETTER_STROKE,
            position=(0.0, 0.0, meshes.ROBOT_HEIGHT + 0.004),
        )
        return frame

    def _add_item(self, item: ItemSpec) -> viser.MeshHandle:
        return self._add(f"item/{item.id}", meshes.item_mesh(item), _item_colour(item))

    def _add(self, name: str, mesh: Mesh, colour: Pixel) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            f"/{self._name}/{name}", mesh.vertices, mesh.triangles, color=colour, flat_shading=True
        )

    def _add_trail(self, seat: int) -> viser.LineSegmentsHandle:
        points = trail(self.episode.states, seat, 0, 0)
        colour = meshes.pixel(meshes.SEAT_RGB[seat])
        name = f"/{self._name}/trail/{SEAT_COLOURS[seat]}"
        return self._scene.add_line_segments(name, points, colour, thickness=_TRAIL_WIDTH)

    # ---- showing -------------------------------------------------------------------------------------------

    def _colour_items(self, tick: int) -> None:
        delivered = self.episode.delivered_after(tick)
        for mesh, item, done in zip(self.items, self._map.items, delivered, strict=True):
            colour = meshes.pixel(meshes.DELIVERED_RGB) if done else _item_colour(item)
            if mesh.color != colour:
                mesh.color = colour

    def _show_trails(self, tick: int, ticks: int) -> None:
        for seat, line in enumerate(self.trails):
            line.visible = ticks > 0
            if ticks > 0:
                line.points = trail(self.episode.states, seat, tick, ticks).astype(np.float32)

    def _show_heat(self, choice: str) -> None:
        if choice == self._heat_shown:
            return
        if self.heat is not None:
            self.heat.remove()
        self.heat, self._heat_shown = None, choice
        if seats := HEAT_CHOICES[choice]:
            self.heat = self._scene.add_image(
                f"/{self._name}/heat",
                heat_picture(self._grids, seats, _HEAT_PIXELS),
                2 * ARENA_HALF,
                2 * ARENA_HALF,
                format="png",
                cast_shadow=False,
                receive_shadow=False,
                wxyz=(0.0, 1.0, 0.0, 0.0),  # pictures look down with y downwards: turn it over, about x
                position=(0.0, 0.0, _HEAT_HEIGHT),
            )

    def _show_candidates(self, considered: list[Candidate]) -> None:
        if _same(considered, self._considered):
            return
        self._considered = considered
        points, colours = candidate_lines(considered)
        self._scene.add_line_segments(  # a node of the same name takes the old one's place
            f"/{self._name}/candidates",
            points,
            np.rint(255 * colours).astype(np.uint8),
            thickness=_CANDIDATE_WIDTH,
            visible=bool(considered),
        )
        self._label(considered)

    def _label(self, considered: list[Candidate]) -> None:
        """The score at the end of each path; labels are reused."""
        while len(self.labels) < len(considered):
            name = f"/{self._name}/score/{len(self.labels)}"
            self.labels.append(
                self._scene.add_label(name, "", visible=False, font_screen_scale=0.7, anchor="center-center")
            )
        for index, label in enumerate(self.labels):
            label.visible = index < len(considered)
            if index < len(considered):
                one = considered[index]
                x, y = one.path[-1].tolist()
                label.position = (x, y, CANDIDATE_HEIGHT + 0.02)
                label.text = f"{one.score:.2f}" + (" chosen" if one.chosen else "")


def score_table(considered: list[Candidate]) -> str:
    """The candidates by score, as Markdown; empty when there are none."""
    if not considered:
        return ""
    ranked = sorted(considered, key=lambda one: -one.score)
    rows = [f"| {rank} | {one.score:.3f} | {'chosen' if one.chosen else ''} |" for rank, one in enumerate(ranked, 1)]
    return "\n".join(["| rank | score | |", "|---:|---:|---|", *rows])


def letter_lines(letter: str) -> Floats:
    """A letter as lines (S, 2, 3) flat on a robot, behind its nose; unlike viser's labels they never lag behind it."""
    strokes = [
        np.array(stroke) * _LETTER_SIZE - (0.35 * _LETTER_SIZE, 0.75 * _LETTER_SIZE) for stroke in _STROKES[letter]
    ]
    return np.concatenate([segments(stroke, 0.0) for stroke in strokes])


def _same(one: list[Candidate], other: list[Candidate]) -> bool:
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))


def _turned(angle: float) -> tuple[float, float, float, float]:
    """The quaternion of a turn about the vertical."""
    return math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)


def _item_colour(item: ItemSpec) -> Pixel:
    shade = {"small": LIGHT.small, "middle": LIGHT.middle, "large": LIGHT.large}[item.size]
    return int(shade[1:3], 16), int(shade[3:5], 16), int(shade[5:7], 16)
