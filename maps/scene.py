"""What a picture of a map shows, as a list of plain shapes in arena units; it knows no file format and no pixels.

`maps.picture` paints the list with Pillow, `maps.render` writes it as SVG. The proportions and colours are those of
the browser (`web/view/render.js`, `web/styles/tokens.css`), so that all pictures of the project look alike.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from movingout.maps.shapes import outline
from movingout.maps.spec import ARENA_HALF, ROBOT_RADIUS, WALL_MARGIN, ItemSpec, MapSpec, Pose, Rect

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Theme:
    """The colours of a picture, "#rrggbb"."""

    surface: str
    ink: str
    blue: str
    red: str
    small: str
    middle: str
    large: str
    item_edge: str
    wall: str
    goal: str
    goal_hatch: str
    goal_edge: str


LIGHT = Theme(
    surface="#ffffff",
    ink="#18212c",
    blue="#0072b2",
    red="#d55e00",
    small="#7c8897",
    middle="#5f6c7c",
    large="#465262",
    item_edge="#2a333f",
    wall="#2a333f",
    goal="#e3f2ea",
    goal_hatch="#d3e9de",
    goal_edge="#3c8f6d",
)
DARK = Theme(
    surface="#1b222b",
    ink="#e8ecf1",
    blue="#3aa0dc",
    red="#f08a3c",
    small="#c0c9d4",
    middle="#a1adbb",
    large="#8593a3",
    item_edge="#e8ecf1",
    wall="#c9d1db",
    goal="#17352a",
    goal_hatch="#1f4637",
    goal_edge="#59b38c",
)


@dataclass(frozen=True, slots=True)
class Box:
    """A filled rectangle with rounded corners."""

    rect: Rect
    radius: float
    fill: str


@dataclass(frozen=True, slots=True)
class Polygon:
    points: tuple[Point, ...]
    fill: str
    stroke: str = ""  # empty for none
    width: float = 0.0


@dataclass(frozen=True, slots=True)
class Disc:
    centre: Point
    radius: float
    fill: str = ""  # empty for a ring
    stroke: str = ""
    width: float = 0.0


@dataclass(frozen=True, slots=True)
class Line:
    points: tuple[Point, ...]
    colour: str
    width: float
    round: bool = False  # round ends


@dataclass(frozen=True, slots=True)
class Label:
    """A bold text centred on a point; `size` is the height of its letters' box."""

    centre: Point
    text: str
    size: float
    colour: str


Shape = Box | Polygon | Disc | Line | Label


@dataclass(frozen=True, slots=True)
class SceneState:
    """Where everything is, in the map's order; the first robot is drawn blue, the second red."""

    robots: Sequence[Sequence[float]]  # (2, 3) x, y, angle
    items: Sequence[Sequence[float]]  # (N, 3)
    held: Sequence[int] = (-1, -1)  # index of the item in each robot's hand
    delivered: Sequence[bool] = ()  # per item; empty for none


_HAIR = 2 * ARENA_HALF / 640  # the thinnest line
_HATCH_STEP, _HATCH_WIDTH = 0.06, 0.011
_GOAL_DASH = (0.026, 0.015)
_HELD_DASH = (0.03, 0.03)
_RING_DASH = (0.028, 0.028)
_MARKS = {"small": "", "middle": "1–2", "large": "2"}


def start_of(spec: MapSpec) -> SceneState:
    """The state before anything moved."""
    return SceneState([_row(pose) for pose in spec.robots], [_row(item.pose) for item in spec.items])


def backdrop(spec: MapSpec, theme: Theme = LIGHT) -> list[Shape]:
    """What never moves: the floor, the goals and the walls."""
    arena = Rect(-ARENA_HALF, -ARENA_HALF, ARENA_HALF, ARENA_HALF)
    shapes: list[Shape] = [Box(arena, 0.0, theme.surface)]
    for goal in spec.goals:
        shapes += _goal(goal, theme)
    shapes += [Box(wall.grown(WALL_MARGIN), WALL_MARGIN, theme.wall) for wall in spec.walls]
    return shapes


def movers(spec: MapSpec, state: SceneState, theme: Theme = LIGHT, *, label_scale: float = 1.0) -> list[Shape]:
    """What moves: items, grips and robots; held items are above the others."""
    shapes: list[Shape] = []
    for index in sorted(range(len(spec.items)), key=lambda index: index in state.held):
        shapes += _item(spec.items[index], index, state, theme, label_scale)
    for seat, held in enumerate(state.held):
        if held >= 0:
            shapes.append(_grip(state.robots[seat], state.items[held], _robot_colour(seat, theme)))
    for seat, pose in enumerate(state.robots):
        shapes += _robot(seat, pose, theme, label_scale)
    return shapes


def _row(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.angle


def _goal(goal: Rect, theme: Theme) -> list[Shape]:
    """Hatched from lower left to upper right, with a dashed edge."""
    shapes: list[Shape] = [Box(goal, 0.025, theme.goal)]
    height = goal.top - goal.bottom
    start = goal.left - height
    while start < goal.right:
        low, high = max(start, goal.left), min(start + height, goal.right)
        points = (low, goal.bottom + low - start), (high, goal.bottom + high - start)
        shapes.append(Line(points, theme.goal_hatch, _HATCH_WIDTH))
        start += _HATCH_STEP
    inner = goal.grown(-_HAIR)
    corners = [
        (inner.left, inner.top),
        (inner.right, inner.top),
        (inner.right, inner.bottom),
        (inner.left, inner.bottom),
    ]
    return [*shapes, *_dashes([*corners, corners[0]], _GOAL_DASH, theme.goal_edge, 2 * _HAIR)]


def _item(spec: ItemSpec, index: int, state: SceneState, theme: Theme, label_scale: float) -> list[Shape]:
    x, y, angle = state.items[index]
    fill = {"small": theme.small, "middle": theme.middle, "large": theme.large}[spec.size]
    holders = [seat for seat in (0, 1) if state.held[seat] == index]
    edge = theme.item_edge if not holders else ""
    shapes: list[Shape]
    if spec.shape == "circle":
        shapes = [Disc((x, y), spec.scale, fill, edge, 1.5 * _HAIR)]
        ring = _circle((x, y), spec.scale)
    else:
        points = _turned(outline(spec.shape, spec.scale), (x, y), angle)
        shapes = [Polygon(points, fill, edge, 1.5 * _HAIR)]
        ring = [*points, points[0]]
    for seat in holders:  # the outline says who holds it: blue solid, red dashed
        colour = _robot_colour(seat, theme)
        if seat == 0:
            shapes.append(Line(tuple(ring), colour, 4 * _HAIR, round=True))
        else:
            shapes += _dashes(ring, _HELD_DASH, colour, 4 * _HAIR)
    ink = _readable(fill)
    if state.delivered and state.delivered[index]:
        tick = [(x + dx, y + dy) for dx, dy in ((-0.022, -0.001), (-0.006, -0.017), (0.024, 0.016))]
        shapes.append(Line(tuple(tick), ink, 2.2 * _HAIR * label_scale, round=True))
    elif _MARKS[spec.size]:
        shapes.append(Label((x, y), _MARKS[spec.size], 0.056 * label_scale, ink))
    return shapes


def _grip(robot: Sequence[float], item: Sequence[float], colour: str) -> Line:
    """A short bar from a robot towards what it holds."""
    tip = (robot[0] + 0.7 * (item[0] - robot[0]), robot[1] + 0.7 * (item[1] - robot[1]))
    return Line(((robot[0], robot[1]), tip), colour, 0.035, round=True)


def _robot(seat: int, pose: Sequence[float], theme: Theme, label_scale: float) -> list[Shape]:
    """A disc with a letter, a solid or a dashed ring, and a notch where it faces."""
    x, y, angle = pose
    colour = _robot_colour(seat, theme)
    ink = _readable(colour)
    ring_radius = ROBOT_RADIUS - 0.013
    ring_colour = _mixed(colour, ink, 0.75)
    shapes: list[Shape] = [Disc((x, y), ROBOT_RADIUS, colour)]
    if seat == 0:
        shapes.append(Disc((x, y), ring_radius, stroke=ring_colour, width=0.009))
    else:
        shapes += _dashes(_circle((x, y), ring_radius, angle), _RING_DASH, ring_colour, 0.009)
    notch = ((0.0, 0.116), (-0.034, 0.068), (0.034, 0.068))
    shapes.append(Polygon(_turned(notch, (x, y), angle), ink))
    shapes.append(Label((x, y), "BR"[seat], 0.064 * label_scale, ink))
    return shapes


def _robot_colour(seat: int, theme: Theme) -> str:
    return theme.blue if seat == 0 else theme.red


def _turned(points: Sequence[Point], centre: Point, angle: float) -> tuple[Point, ...]:
    cos, sin = math.cos(angle), math.sin(angle)
    return tuple((centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y) for x, y in points)


def _circle(centre: Point, radius: float, angle: float = 0.0, corners: int = 48) -> list[Point]:
    """A closed ring of points."""
    turns = [angle + 2 * math.pi * k / corners for k in range(corners + 1)]
    return [(centre[0] - radius * math.sin(turn), centre[1] + radius * math.cos(turn)) for turn in turns]


def _dashes(path: Sequence[Point], dash: Point, colour: str, width: float) -> Iterator[Line]:
    """A path of straight pieces as dashes; `dash` is the length of a dash and of a gap."""
    period, travelled = sum(dash), 0.0
    for (x0, y0), (x1, y1) in pairwise(path):
        length = math.hypot(x1 - x0, y1 - y0)
        position = -(travelled % period)
        while position < length:
            low, high = max(position, 0.0), min(position + dash[0], length)
            if high > low:
                ends = ((x0 + (x1 - x0) * t / length, y0 + (y1 - y0) * t / length) for t in (low, high))
                yield Line(tuple(ends), colour, width)
            position += period
        travelled += length


def _mixed(under: str, over: str, amount: float) -> str:
    """Two colours laid over each other, `amount` of the upper one."""
    mixed = (round((1 - amount) * a + amount * b) for a, b in zip(_channels(under), _channels(over), strict=True))
    return "#" + "".join(f"{channel:02x}" for channel in mixed)


def _readable(background: str) -> str:
    """White or dark ink, whichever contrasts more (WCAG relative luminance)."""
    linear = [(c / 255 / 12.92) if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in _channels(background)]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return "#ffffff" if 1.05 / (luminance + 0.05) > (luminance + 0.05) / 0.063 else LIGHT.ink


def _channels(colour: str) -> tuple[int, int, int]:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
