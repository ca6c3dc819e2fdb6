"""Challenge 2: variants of a map with other poses, masses, sizes and shapes (paper, "Challenge Types" and "Dataset").

What is drawn, each uniformly:
- positions within 0.1 of the designed ones on both axes, all angles freely (as in the official code);
- mass and scale of each item within 10 % of the designed ones, and within what a map may have;
- the shape of each item among the split's (size, shape) pairs. The pairs are divided once for all maps and seeds, each
  shape being held out in exactly one size: whatever is evaluated, no training map of any seed has shown that pair,
  though it has shown that shape and that size (the paper's example: large stars are held out, small ones are not).
  The official code instead holds out each map's own designed pairs, so that one map trains on what another evaluates;
  the split `official` does so, for agents that are evaluated on the maps as designed;
- on maps 6, 7 and 8 also whether a middle or large item is middle or large (as in the official code). At least one
  stays middle there, because these maps ask whether to help or to drag alone.

Unlike the official generator, whose resets overlap in up to two of three cases, a variant is always free of
collisions and solvable: drawn again until nothing overlaps, robots get to every item (both to a large one), each item
as a disc passes some way to a goal, and the goals have a place for all. So very large shapes are rarer on narrow maps.
"""

import math
import zlib
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Literal, get_args

import numpy as np

from movingout.maps.check import seats_at
from movingout.maps.errors import MapError
from movingout.maps.json_format import MASSES, SCALES
from movingout.maps.packing import is_home, unplaced_items
from movingout.maps.passage import best_near, way_to_goal
from movingout.maps.shapes import circumradius, corner_radius
from movingout.maps.solid import Solid, beyond_arena, item_solid, robot_solid, wall_solid
from movingout.maps.spec import SHAPES, SIZES, ItemSpec, MapSpec, Pose, Shape, Size

Split = Literal["train", "evaluation", "official"]
Pair = tuple[Size, Shape]

SPLITS: tuple[Split, ...] = get_args(Split)
EVALUATION_PAIRS: frozenset[Pair] = frozenset(
    {
        ("small", "triangle"),
        ("small", "square"),
        ("small", "octagon"),
        ("middle", "pentagon"),
        ("middle", "circle"),
        ("middle", "rectangle"),
        ("large", "hexagon"),
        ("large", "star"),
    }
)
POSITION_NOISE = 0.1  # arena units, each axis
RELATIVE_NOISE = 0.1  # of mass and scale

_MAPS_WITH_REDRAWN_SIZES = (6, 7, 8)
_GAP = 0.01  # between any two things at the start
_SPARE = 0.01  # a way to the goal and a place in it are at least this much larger than the item, on each side
_TRIES = 40  # to place one thing before all is drawn again
_ATTEMPTS = 200


def pairs_of(split: Split, spec: MapSpec | None = None) -> frozenset[Pair]:
    """The (size, shape) pairs that items of a split can have; those of train and evaluation have nothing in common.

    `official` has all pairs but those of the items of the map as designed, `spec`.
    """
    if split == "evaluation":
        return EVALUATION_PAIRS
    everything = frozenset((size, shape) for size in SIZES for shape in SHAPES)
    if split == "official":
        return everything - (pairs_on(spec) if spec else frozenset())
    return everything - EVALUATION_PAIRS


def variant_pairs(spec: MapSpec, split: Split) -> frozenset[Pair]:
    """The pairs that items in variants of a map can have."""
    sizes = {item.size for item in spec.items}
    if spec.number in _MAPS_WITH_REDRAWN_SIZES and sizes != {"small"}:
        sizes |= {"middle", "large"}
    return frozenset(pair for pair in pairs_of(split, spec) if pair[0] in sizes)


def pairs_on(spec: MapSpec) -> frozenset[Pair]:
    """The pairs of the items that lie on a map, as designed or a variant."""
    return frozenset((item.size, item.shape) for item in spec.items)


def pair_text(pair: Pair) -> str:
    """As people say it: large star."""
    return " ".join(pair)


def randomize(spec: MapSpec, seed: int, split: Split = "train") -> MapSpec:
    """The variant of a map as designed for a seed from 0; the same arguments give the same variant.

    Raises MapError when the map is itself a variant, or so tight that no playable variant was found.
    """
    if spec.variant:
        raise MapError(f"{spec.name} is already the variant {spec.variant!r}; randomize the map as designed")
    if split not in SPLITS:
        raise MapError(f"unknown split {split!r}; known: {', '.join(SPLITS)}")
    if seed < 0:
        raise MapError(f"a seed is a whole number from 0, not {seed}")
    generator = np.random.default_rng([seed, zlib.crc32(spec.name.encode()), SPLITS.index(split)])
    for _ in range(_ATTEMPTS):
        others = _with_other_items(spec, pairs_of(split, spec), generator)
        variant = None if unplaced_items(others, _SPARE) else _placed(others, generator)
        if variant is not None and _has_ways(variant):
            return replace(variant, variant=f"challenge2-{split}-{seed}")
    raise MapError(
        f"no playable {split} variant of {spec.name} for seed {seed} in {_ATTEMPTS} attempts; give the map more room"
    )


def _with_other_items(spec: MapSpec, pairs: frozenset[Pair], generator: np.random.Generator) -> MapSpec:
    """The map with other sizes, shapes, scales and masses, its poses untouched."""
    sizes = _sizes(spec, generator)
    items = []
    for item, size in zip(spec.items, sizes, strict=True):
        shapes = sorted(shape for pair_size, shape in pairs if pair_size == size)
        shape = shapes[generator.integers(len(shapes))]
        scale = item.scale * _usual_scale(size, shape) / _usual_scale(item.size, item.shape)
        scale_factor, mass_factor = generator.uniform(1 - RELATIVE_NOISE, 1 + RELATIVE_NOISE, 2).tolist()
        scale, mass = _within(scale * scale_factor, SCALES), _within(item.mass * mass_factor, MASSES)
        items.append(replace(item, size=size, shape=shape, scale=scale, mass=mass))
    return replace(spec, items=tuple(items))


def _within(number: float, limits: tuple[float, float]) -> float:
    """The nearest number that a map may have: what no map file could say would be in no recording either."""
    return min(max(number, limits[0]), limits[1])


def _sizes(spec: MapSpec, generator: np.random.Generator) -> list[Size]:
    designed: list[Size] = [item.size for item in spec.items]
    big = [index for index, size in enumerate(designed) if size != "small"]
    if spec.number not in _MAPS_WITH_REDRAWN_SIZES or not big:
        return designed
    drawn = ["middle" if coin else "large" for coin in generator.integers(2, size=len(big))]
    drawn[generator.integers(len(big))] = "middle"
    for index, size in zip(big, drawn, strict=True):
        designed[index] = "middle" if size == "middle" else "large"
    return designed


def _usual_scale(size: Size, shape: Shape) -> float:
    """The scale that the designed maps give to a size; their one rectangle is larger."""
    if size == "large":
        return 0.20 if shape == "rectangle" else 0.17
    return {"small": 0.06, "middle": 0.11}[size]


def _placed(spec: MapSpec, generator: np.random.Generator) -> MapSpec | None:
    """The map with its robots and items moved and turned, or None when something found no free place."""
    taken = [wall_solid(wall) for wall in spec.walls]
    items: dict[int, ItemSpec] = {}
    for index in sorted(range(len(spec.items)), key=lambda index: -spec.items[index].scale):
        item = spec.items[index]
        pose = _free_pose(item.pose, partial(_item_at, spec, item), taken, generator)
        if pose is None:
            return None
        items[index] = replace(item, pose=pose)
        taken.append(item_solid(items[index]))
    robots = []
    for robot in spec.robots:
        pose = _free_pose(robot, robot_solid, taken, generator)
        if pose is None:
            return None
        robots.append(pose)
        taken.append(robot_solid(pose))
    return replace(spec, robots=(robots[0], robots[1]), items=tuple(items[index] for index in range(len(items))))


def _free_pose(
    designed: Pose, solid_at: Callable[[Pose], Solid | None], taken: list[Solid], generator: np.random.Generator
) -> Pose | None:
    for _ in range(_TRIES):
        dx, dy = generator.uniform(-POSITION_NOISE, POSITION_NOISE, 2).tolist()
        pose = Pose(designed.x + dx, designed.y + dy, float(generator.uniform(-math.pi, math.pi)))
        solid = solid_at(pose)
        if solid is None or beyond_arena(solid) > -_GAP:
            continue
        if all(solid.gap(other) >= _GAP for other in taken):
            return pose
    return None


def _item_at(spec: MapSpec, item: ItemSpec, pose: Pose) -> Solid | None:
    """The item as a solid, or None where it would be delivered from the start."""
    solid = item_solid(replace(item, pose=pose))
    return None if is_home(solid.box, spec.goals) else solid


def _has_ways(spec: MapSpec) -> bool:
    """Whether each item can be reached by who is needed, and then be brought to a goal."""
    ways = way_to_goal(spec.walls, spec.goals)
    for item in spec.items:
        radius = circumradius(item.shape, item.scale) + corner_radius(item.shape, item.scale)
        if best_near(ways, item.pose.x, item.pose.y) < radius + _SPARE:
            return False
        seats = seats_at(spec, item)
        if not (all(seats) if item.size == "large" else any(seats)):
            return False
    return True
