"""An arena without walls in which two robots hold one heavy item, and whoever holds it with the expert does as told."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from movingout.agents.action_chunk import world_action
from movingout.agents.base import EpisodeInfo
from movingout.agents.observation.seat_observation import observe
from movingout.agents.scripted.agent import ScriptedAgent
from movingout.agents.scripted.navigation.grasp_stance import stances
from movingout.maps import MapSpec, load_map
from movingout.world import World
from movingout.world.state import WorldState

BLUE, RED = 0, 1
Action = tuple[float, float, float]  # distance, heading, press
Told = Callable[[WorldState], Action]
LEFT_RIGHT = (8, 24)  # stances at the right and at the left of an item that lies at angle 0


def shared_item_map(x: float = 0.0, y: float = 0.0, stance_numbers: tuple[int, int] = LEFT_RIGHT) -> MapSpec:
    """FourCorners without walls, its first item at a place, and both robots at stances beside it."""
    the_map = load_map("FourCorners")
    item = replace(the_map.items[0], pose=replace(the_map.items[0].pose, x=x, y=y, angle=0.0))
    poses, _ = stances(item, np.array([x, y, 0.0]))
    robots = [
        replace(robot, x=float(x), y=float(y), angle=float(angle))
        for robot, (x, y, angle) in zip(the_map.robots, poses[list(stance_numbers)].tolist(), strict=True)
    ]
    return replace(the_map, walls=(), items=(item,), robots=(robots[0], robots[1]))


def heading_to(x: float, y: float, place: tuple[float, float]) -> float:
    """The heading of the straight line between two points."""
    return math.atan2(-(place[0] - x), place[1] - y)


def goal_middle(the_map: MapSpec, goal: int) -> tuple[float, float]:
    """The middle of a goal."""
    area = the_map.goals[goal]
    return (area.left + area.right) / 2, (area.bottom + area.top) / 2


def pulls_to(place: tuple[float, float]) -> Told:
    """Takes the item in the first tick, then pulls it straight to a place, and lets go there."""

    def told(state: WorldState) -> Action:
        x, y, _ = state.item_poses[0].tolist()
        heading = heading_to(x, y, place)
        if state.tick == 0:
            return 0.0, float(state.robot_poses[BLUE, 2]), 1.0
        return 1.0, heading, 0.0

    return told


def play_with(
    agent: ScriptedAgent, the_map: MapSpec, blue: Told, ticks: int, grabs_at_once: bool = True
) -> list[WorldState]:
    """The states of an episode with the agent in red; with `grabs_at_once` its first action is a press."""
    world = World(the_map)
    agent.reset(EpisodeInfo(the_map, RED, 0, 500))
    states = [world.state()]
    for tick in range(ticks):
        state = states[-1]
        row = agent.act(observe(the_map, state, RED))[0]
        red = (0.0, float(state.robot_poses[RED, 2]), 1.0) if tick == 0 and grabs_at_once else world_action(row)
        world.step(np.array([blue(state), red]))
        states.append(world.state())
        if world.delivered().all():
            break
    return states
