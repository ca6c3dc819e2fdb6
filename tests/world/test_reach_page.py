"""What a page outlines as in reach is what a grab takes: web/view/reach.js against the world, on many states."""

import json
import random
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from movingout.maps import ItemSpec, MapSpec, Pose, load_map, map_to_json
from movingout.maps.spec import SHAPES, SIZES
from movingout.world import World
from movingout.world.constants import REACH

WEB = Path(__file__).parents[2] / "web"
STATES = 600
BLUE, RED = 0, 1  # blue grabs at the very start of a tick, before anything moves
ASK = """
import { itemInReach } from "./view/reach.js";
import { readFileSync } from "node:fs";
const states = JSON.parse(readFileSync(0, "utf-8"));
console.log(JSON.stringify(states.map(({ map, view, seat }) => itemInReach(map, view, seat))));
"""


@pytest.mark.slow
def test_the_page_outlines_what_a_grab_takes() -> None:
    draw = random.Random(7)
    states, taken = [], []
    for _ in range(STATES):
        world = _world(draw)
        if draw.random() < 0.3:  # the partner may hold something already
            world.step(_grasp(world, RED))
        states.append({"map": map_to_json(world.map), "view": _view(world), "seat": BLUE})
        world.step(_grasp(world, BLUE))
        taken.append(int(world.state().held[BLUE]))
    assert _asked(states) == taken
    assert taken.count(-1) > STATES / 10 and len(set(taken)) == 3, "nothing, and each item near blue"


def _world(draw: random.Random) -> World:
    """Two robots, each before an item, with a gap around the limit of what is in reach; a third item anywhere near."""
    robots = (Pose(-0.5, 0.0, draw.uniform(-4, 4)), Pose(0.5, 0.0, draw.uniform(-4, 4)))
    before = [*robots, draw.choice(robots)]
    items = tuple(_item(draw, index, robot) for index, robot in enumerate(before))
    the_map: MapSpec = replace(load_map("Simple"), robots=robots, items=items)
    return World(the_map)


def _item(draw: random.Random, index: int, robot: Pose) -> ItemSpec:
    scale = draw.uniform(0.05, 0.18)
    heading = robot.angle + draw.uniform(-0.6, 0.6)
    away = REACH + draw.uniform(0.4, 1.6) * scale + draw.uniform(0.0, 0.05)
    x, y = robot.x - away * float(np.sin(heading)), robot.y + away * float(np.cos(heading))
    pose = Pose(x, y, draw.uniform(-4, 4))
    return ItemSpec(index, draw.choice(SHAPES), draw.choice(SIZES), scale, 0.1, pose)


def _grasp(world: World, seat: int) -> list[list[float]]:
    angles = world.state().robot_poses[:, 2].tolist()
    return [[0.0, angle, float(index == seat)] for index, angle in enumerate(angles)]


def _view(world: World) -> dict[str, Any]:
    state = world.state()
    poses = [*state.robot_poses.tolist(), *state.item_poses.tolist()]
    return {"poses": poses, "held": state.held.tolist(), "delivered": world.delivered().tolist()}


def _asked(states: list[dict[str, Any]]) -> list[int]:
    """What the page says."""
    command = ["node", "--input-type=module", "--eval", ASK]
    answer = subprocess.run(
        command, input=json.dumps(states), capture_output=True, text=True, check=True, cwd=WEB, timeout=200
    )
    found: list[int] = json.loads(answer.stdout)
    return found
