"""Tracks made by hand: robots and items stand where a test puts them, tick by tick."""

import html
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from movingout.maps import MapSpec, load_map
from movingout.maps.spec import ItemSpec, Pose, Rect
from movingout.recordings.report.track import Track

GOAL = Rect(-1.2, -0.3, -0.8, 0.3)  # at the left edge
SMALL = ItemSpec(0, "circle", "small", 0.06, 0.5, Pose(0.5, 0.0, 0.0))
LARGE = ItemSpec(1, "square", "large", 0.15, 5.0, Pose(0.5, 0.8, 0.0))


def arena(*items: ItemSpec, walls: tuple[Rect, ...] = ()) -> MapSpec:
    """An open arena with a goal at its left edge."""
    return replace(load_map("HandOff"), name="Open", goals=(GOAL,), walls=walls, items=items or (SMALL, LARGE))


def still(ticks: int, spec: MapSpec | None = None) -> Track:
    """A track in which nothing happens: blue at the right, red at the left, items at their places."""
    spec = spec or arena()
    robots = np.array([[1.0, -0.9, 0.0], [-0.5, -0.9, 0.0]])
    items = np.array([(item.pose.x, item.pose.y, item.pose.angle) for item in spec.items])
    return Track(
        map=spec,
        robots=np.tile(robots, (ticks + 1, 1, 1)),
        items=np.tile(items, (ticks + 1, 1, 1)),
        held=np.full((ticks + 1, 2), -1),
        delivered=np.zeros((ticks + 1, len(spec.items)), dtype=np.bool_),
        grasp=np.zeros((ticks, 2), dtype=np.bool_),
    )


def english_left(page: str, *folders: Path) -> list[str]:
    """English sentences of the catalogues among what a page shows or reads out, which should be German."""
    visible = re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)
    shown = "\n".join([*re.findall(r">([^<]+)<", visible), *re.findall(r'(?:aria-label|title)="([^"]*)"', visible)])
    found = []
    for folder in folders:
        english, german = (json.loads((folder / f"{name}.json").read_text(encoding="utf-8")) for name in ("en", "de"))
        for key, text in english.items():
            longest = max(re.split(r"{\w*}", text), key=len).strip()
            told = re.search(rf"(?<!\w){re.escape(html.escape(longest))}(?!\w)", shown)
            if told and len(longest) > 11 and longest not in german[key]:  # shorter ones may stand in questions
                found.append(f"{key}: {longest}")
    return found
