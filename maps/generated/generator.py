"""Maps without end: a map for every seed and mode, the same on every machine.

A template of walls is drawn, then items, goal regions and robots, until the map passes `maps.check`; a symmetry of the
square turns it. That it can be played to the end in time is another matter: `maps.generated.proved` lists the maps on
which a scripted pair delivered everything.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

from movingout.maps.check import check_map
from movingout.maps.errors import MapError
from movingout.maps.generated.names import (
    DIFFICULTIES,
    MODE_WORDS,
    MOST_SEED,
    Difficulty,
    generated_name,
    usual_difficulty,
)
from movingout.maps.generated.placement import draw_goals, draw_items, place_items, place_robots
from movingout.maps.generated.skeletons import TEMPLATES, Draw
from movingout.maps.packing import unplaced_items
from movingout.maps.spec import MapSpec, Mode
from movingout.maps.symmetry import ALL_SYMMETRIES, Symmetry

_ATTEMPTS = 400  # of which a handful is needed
_VERSION = 1  # of everything that a seed decides; another one gives other maps
_SPARE = 0.02  # around each item in the goals


def generate(seed: int, mode: Mode, difficulty: Difficulty | None = None) -> MapSpec:
    """The map of a seed. Without a difficulty, seeds are easy, medium and hard in turn.

    A map with another difficulty than that has it in its name: `generated:awareness:3:hard`. Raises MapError for a mode
    without generated maps or a seed out of range.
    """
    if mode not in MODE_WORDS:
        raise MapError(f"no maps are generated for the mode {mode!r}; there are: {', '.join(MODE_WORDS)}")
    if not 0 <= seed <= MOST_SEED:
        raise MapError(f"a seed is a whole number from 0 to {MOST_SEED}, not {seed}")
    return _generated(seed, mode, DIFFICULTIES.index(difficulty or usual_difficulty(seed)))


@lru_cache(maxsize=256)
def _generated(seed: int, mode: Mode, level: int) -> MapSpec:
    draw = Draw(np.random.default_rng([_VERSION, list(MODE_WORDS).index(mode), level, seed]))
    for spec in _drawn(draw, mode, level):
        if not unplaced_items(spec, _SPARE) and not check_map(spec):
            name = generated_name(mode, seed, DIFFICULTIES[level])
            return replace(_turned(spec, draw.one_of(ALL_SYMMETRIES)), name=name, title=_title(seed, level))
    raise MapError(f"no playable map was found for the seed {seed} ({mode}) in {_ATTEMPTS} attempts; take another seed")


def _drawn(draw: Draw, mode: Mode, level: int) -> Iterator[MapSpec]:
    """Maps in which nothing overlaps, one per attempt that got that far."""
    for _ in range(_ATTEMPTS):
        skeleton = draw.one_of(TEMPLATES[mode])(draw, level)
        wanted = draw_items(draw, mode, level, small_only=skeleton.small_only)
        goals = draw_goals(draw, skeleton, wanted)
        items = None if goals is None else place_items(draw, skeleton, goals, wanted)
        robots = None if items is None else place_robots(draw, skeleton, items)
        if goals is not None and items is not None and robots is not None:
            yield MapSpec(
                name="Generated",
                title="",
                number=0,
                mode=mode,
                description="Walls, goals and items drawn at random.",
                robots=robots,
                walls=skeleton.walls,
                goals=goals,
                items=tuple(items),
            )


def _title(seed: int, level: int) -> str:
    difficulty = DIFFICULTIES[level]
    return f"Surprise map {seed}" + ("" if difficulty == usual_difficulty(seed) else f", {difficulty}")


def _turned(spec: MapSpec, symmetry: Symmetry) -> MapSpec:
    """The map moved by a symmetry without saying so in its name; angles to ten thousandths."""

    def rounded(spec_part: MapSpec) -> MapSpec:
        blue, red = (replace(pose, angle=round(pose.angle, 4) + 0.0) for pose in spec_part.robots)
        items = tuple(
            replace(item, pose=replace(item.pose, angle=round(item.pose.angle, 4) + 0.0)) for item in spec_part.items
        )
        return replace(spec_part, robots=(blue, red), items=items)

    return rounded(
        replace(
            spec,
            robots=(symmetry.pose(spec.robots[0]), symmetry.pose(spec.robots[1])),
            walls=tuple(symmetry.rect(wall) for wall in spec.walls),
            goals=tuple(symmetry.rect(goal) for goal in spec.goals),
            items=tuple(replace(item, pose=symmetry.pose(item.pose)) for item in spec.items),
        )
    )
