"""The paper's figures that show no numbers, painted from our episodes and agents."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from movingout.agents.bass.agent import BassAgent
from movingout.agents.bass.progress import LearnedProgress
from movingout.agents.bass.recombination import LENGTH, RecombinedPiece, draw_pieces, recombined
from movingout.agents.bass.state_vector import moving_arrays
from movingout.agents.catalogue import load_agent
from movingout.agents.data.dataset import Trajectory, read_trajectories
from movingout.agents.data.diversity import path_of
from movingout.agents.data.rollout import rollout
from movingout.maps import MapSpec, load_map
from movingout.maps.picture import paint_scene
from movingout.maps.randomize import randomize
from movingout.maps.scene import LIGHT, start_of
from movingout.maps.spec import ARENA_HALF
from movingout.matches.paper.rows.diversity import learned_parts
from movingout.matches.paper.workspace import Workspace
from movingout.recordings.diversity.augmented import evenly_chosen
from movingout.recordings.diversity.position_plot import position_plot
from movingout.recordings.groups import GroupedRecording, read_groups
from movingout.world import World
from movingout.world.raster import picture
from movingout.world.state import Floats, WorldState

SIDE, GAP, CAPTION = 220, 10, 26
FEWEST = 3  # pictures in the width of a sheet: captions need room
RANDOMIZED = "HandOff", "SingleRotation"  # two maps, as in the paper
ROLLED_OUT = "SingleRotation"  # the paper's map of this figure
MOMENTS = 8
PAIRS = 4  # of participants, as in the paper
BEFORE = 20  # ticks shown before a recombined stretch
TRIED = 400
CURVES = 5  # episodes per panel, as in the paper
WIDE, HIGH = 420, 260
BLUE, RED = (37, 99, 235), (220, 38, 38)


def sheet(rows: Sequence[tuple[str, Sequence[Image.Image]]]) -> Image.Image:
    """Rows of square pictures, a caption above each row."""
    width = max(FEWEST, *(len(pictures) for _, pictures in rows)) * (SIDE + GAP) + GAP
    whole = Image.new("RGB", (width, len(rows) * (SIDE + CAPTION + GAP) + GAP), LIGHT.surface)
    pen, font = ImageDraw.Draw(whole), ImageFont.load_default(15)
    for row, (caption, pictures) in enumerate(rows):
        top = GAP + row * (SIDE + CAPTION + GAP)
        pen.text((GAP, top), caption, fill=LIGHT.ink, font=font)
        for column, one in enumerate(pictures):
            corner = GAP + column * (SIDE + GAP), top + CAPTION
            whole.paste(one, corner)
            pen.rectangle((corner[0] - 1, corner[1] - 1, corner[0] + SIDE, corner[1] + SIDE), outline=LIGHT.ink)
    return whole


def positions(space: Workspace) -> Image.Image:
    """Where robots were on every map: of up to four pairs of participants, and of everybody together."""
    rows = read_groups(space.listing("c1"))
    pairs = evenly_chosen(sorted({_pair(row) for row in rows}), PAIRS)
    groups = {
        f"pair {number}": read_trajectories([row.path for row in rows if _pair(row) == pair])
        for number, pair in enumerate(pairs, start=1)
    }
    groups["all"] = read_trajectories([row.path for row in rows])
    maps = {one.map.name: one.map for one in groups["all"]}.values()
    plots = [
        position_plot(the_map, {name: _paths_on(the_map, group) for name, group in groups.items()}, "dots")
        for the_map in maps
    ]
    whole = Image.new("RGB", (plots[0].width, sum(plot.height for plot in plots)), LIGHT.surface)
    for row, plot in enumerate(plots):
        whole.paste(plot, (0, row * plots[0].height))
    return whole


def _pair(row: GroupedRecording) -> tuple[str, ...]:
    """Who played, whoever was blue."""
    return tuple(sorted(row.people))


def _paths_on(the_map: MapSpec, trajectories: Sequence[Trajectory]) -> list[Floats]:
    return [path_of(one) for one in trajectories if one.map.name == the_map.name]


def randomized(space: Workspace) -> Image.Image:
    """Two maps as designed, and four variants of each."""
    rows = []
    for name in RANDOMIZED:
        designed = load_map(name)
        maps = [designed, *(randomize(designed, space.seed + number, "official") for number in range(4))]
        rows.append((f"{name}: as designed, and four variants", [_at_start(one) for one in maps]))
    return sheet(rows)


def _at_start(the_map: MapSpec) -> Image.Image:
    return paint_scene(the_map, start_of(the_map), SIDE)


def rollouts(space: Workspace) -> Image.Image:
    """The same map played by BASS, MLP and DP of Challenge 2, each with itself."""
    the_map = load_map(ROLLED_OUT)
    rows = []
    for name, agent_id in (("DP/BASS", "bass@c2"), ("MLP", "mlp@c2"), ("DP", "dp@c2")):
        states = [World(the_map).state()]
        pair = load_agent(agent_id), load_agent(agent_id)
        states += [step.after for step in rollout(the_map, pair, space.seed, space.budget.ticks)]
        shown = np.linspace(0, len(states) - 1, MOMENTS).round().astype(int).tolist()
        rows.append((f"{name}: ticks {', '.join(map(str, shown))}", [_painted(the_map, states[at]) for at in shown]))
    return sheet(rows)


def _painted(the_map: MapSpec, state: WorldState) -> Image.Image:
    return picture(the_map, state, side=SIDE)


def recombination_example(space: Workspace) -> Image.Image:
    """A piece that the engine confirms, beside the two episodes that it is made of; words where there is none."""
    trajectories = read_trajectories(space.episodes("c1"))
    for number, piece in enumerate(draw_pieces(learned_parts(trajectories, space), space.seed)):
        played = recombined(piece) if _differs(piece) else None
        if played is not None:
            return _example(piece, played)
        if number >= TRIED:
            break
    return sheet([("No stretch of an episode fits another one, among those tried; record more.", ())])


def _differs(piece: RecombinedPiece) -> bool:
    """Whether the partner moves, and not as in the own episode."""
    seat, own = 1 - piece.own.seat, piece.own.trajectory
    theirs = piece.other.robot_poses[piece.other_start : piece.other_start + LENGTH + 1, seat, :2]
    mine = own.robot_poses[piece.start : piece.start + LENGTH + 1, seat, :2]
    moved = float(np.linalg.norm(theirs[-1] - theirs[0]))
    return moved > 0.1 and float(np.linalg.norm(theirs - mine, axis=1).max()) > 0.1


def _example(piece: RecombinedPiece, played: Trajectory) -> Image.Image:
    own = piece.own.trajectory
    first = _with_trails(own, piece.start, piece.start + LENGTH)
    second = _with_trails(piece.other, piece.other_start, piece.other_start + LENGTH)
    names = ("blue", "red")
    caption = (
        f"{own.map.name}: {names[piece.own.seat]} of the first, {names[1 - piece.own.seat]} of the second, together"
    )
    return sheet([(caption, [first, second, _with_trails(played, 0, LENGTH)])])


def tcl_distances(space: Workspace) -> Image.Image:
    """The embedding's distance from the first moment over time, in episodes learned from and in others."""
    agent = load_agent("bass-tcl@a")
    assert isinstance(agent, BassAgent) and isinstance(agent.value, LearnedProgress)
    whole = Image.new("RGB", (2 * (WIDE + GAP) + GAP, HIGH + CAPTION + 2 * GAP), LIGHT.surface)
    for column, (name, data) in enumerate((("group a, learned from", "a"), ("group b, not learned from", "b"))):
        episodes = read_trajectories(space.episodes(data)[:: max(len(space.episodes(data)) // CURVES, 1)][:CURVES])
        curves = [agent.value.distances(one.map, moving_arrays(*one.state_arrays)) for one in episodes]
        whole.paste(_curves(name, curves), (GAP + column * (WIDE + GAP), GAP))
    return whole


def _curves(title: str, curves: Sequence[Floats]) -> Image.Image:
    """Lines over time, both axes from 0 to the largest value."""
    panel = Image.new("RGB", (WIDE, HIGH + CAPTION), LIGHT.surface)
    pen, font = ImageDraw.Draw(panel), ImageFont.load_default(13)
    top, last = max(float(one.max()) for one in curves) or 1.0, max(len(one) - 1 for one in curves)
    pen.text((0, 0), f"{title}: distance 0 to {top:.1f}, ticks 0 to {last}", fill=LIGHT.ink, font=font)
    pen.rectangle((0, CAPTION, WIDE - 1, HIGH + CAPTION - 1), outline=LIGHT.ink)
    for number, curve in enumerate(curves):
        points = [
            (tick * WIDE / last, CAPTION + HIGH * (1.0 - value / top)) for tick, value in enumerate(curve.tolist())
        ]
        shade = 40 + 35 * number
        pen.line(points, (shade, shade, 200), 2)
    return panel


def _with_trails(trajectory: Trajectory, begin: int, end: int) -> Image.Image:
    """The state at the end, and the ways of both robots until then, before the stretch thin."""
    state = WorldState(
        end, trajectory.robot_poses[end], trajectory.robot_velocities[end], trajectory.held[end],
        trajectory.item_poses[end],
    )  # fmt: skip
    image = picture(trajectory.map, state, side=SIDE)
    pen, unit = ImageDraw.Draw(image), SIDE / (2 * ARENA_HALF)
    for seat, colour in enumerate((BLUE, RED)):
        places = trajectory.robot_poses[max(begin - BEFORE, 0) : end + 1, seat, :2]
        points = [((x + ARENA_HALF) * unit, (ARENA_HALF - y) * unit) for x, y in places.tolist()]
        for number, line in enumerate(pairwise(points)):
            pen.line(line, colour, 4 if number >= begin - max(begin - BEFORE, 0) else 1)
    return image
