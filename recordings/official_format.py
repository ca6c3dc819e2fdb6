"""The official project's three JSON shapes of a trajectory; our episodes are written in the first two.

| shape | who writes it | one step |
|---|---|---|
| recorder | its data collector: `[[step, ...], ...]`, a list of episodes | `states` BEFORE the action |
| dataset | its published data set: rows with `steps_data`, a JSON text | `[step, states, actions]`, BEFORE |
| evaluator | its evaluation loop: like the recorder's | `states` AFTER the action |

`robot_1` is our blue, `robot_2` our red. Spellings such as `holded_item_id` are the official ones. None of the shapes
holds the state after the last action (recorder, dataset) or before the first (evaluator).
`recordings.imports` reads all three.
"""

import json
from datetime import UTC, datetime
from itertools import pairwise
from typing import Any

from movingout.maps.spec import MapSpec, Rect
from movingout.recordings.episode import Episode
from movingout.world.official_reward import OfficialDenseReward
from movingout.world.state import Floats, WorldState

ROBOTS = ("robot_1", "robot_2")
ITEM_COLOUR, TARGET_COLOUR = "grey", "blue"  # colours mean nothing to the world; ours has none

Json = dict[str, Any]


def official_state(spec: MapSpec, state: WorldState) -> Json:
    """A state as the official `get_all_states` gives it."""
    return {
        **{name: _robot(spec, state, seat) for seat, name in enumerate(ROBOTS)},
        "items": [
            {
                "pos": pose[:2],
                "angle": pose[2],
                "shape": item.shape,
                "size": item.size,
                "shape_scale": item.scale,
                "color": ITEM_COLOUR,
                "id": item.id,
                "hold": [held == index for held in state.held.tolist()],
            }
            for index, (item, pose) in enumerate(zip(spec.items, state.item_poses.tolist(), strict=True))
        ],
        "target_area": [_corners(goal) for goal in spec.goals],
        "target_color": TARGET_COLOUR,
        "walls": [_corners(wall) for wall in spec.walls],
    }


def official_actions(actions: Floats) -> list[list[float | bool]]:
    """World actions (2, 3) as `[[magnitude, angle, grasp], ...]`."""
    return [[distance, heading, grasp > 0] for distance, heading, grasp in actions.tolist()]


def recorder_steps(episode: Episode) -> list[Json]:
    """The steps as the official data collector saves them; `rew` and `done` are of the step before."""
    header = episode.header
    reward = OfficialDenseReward(header.map)
    paid = [0, *(reward(before, after).tolist() for before, after in pairwise(episode.states))]
    started = datetime.fromtimestamp(header.started_ns / 1e9, UTC).strftime("%Y-%m-%d_%H:%M:%S")
    return [
        {
            "red_name": header.seats[1].name,
            "blue_name": header.seats[0].name,
            "time": started,
            "id": header.map.name,
            "step": number,
            "states": official_state(header.map, before),
            "rew": paid[number - 1],
            "done": False,
            "action": official_actions(tick.actions),
            "test_mode": False,
        }
        for number, (before, tick) in enumerate(zip(episode.states, episode.ticks, strict=False), start=1)
    ]


def dataset_row(episode: Episode, trajectory_id: int) -> Json:
    """A row of the published data set."""
    spec = episode.header.map
    steps = [
        [number, official_state(spec, before), official_actions(tick.actions)]
        for number, (before, tick) in enumerate(zip(episode.states, episode.ticks, strict=False))
    ]
    return {"map_name": spec.name, "trajectory_id": trajectory_id, "steps_data": json.dumps(steps)}


def _robot(spec: MapSpec, state: WorldState, seat: int) -> Json:
    x, y, angle = state.robot_poses[seat].tolist()
    vx, vy, angular_velocity = state.robot_velocities[seat].tolist()
    held = int(state.held[seat])
    holds = held >= 0
    return {
        "pos": [x, y],
        "angle": angle,
        "hold": holds,
        "velocity": [vx, vy],
        "angular_velocity": angular_velocity,
        "holded_item_id": spec.items[held].id if holds else None,
        "holded_item_pos": state.item_poses[held, :2].tolist() if holds else None,
        "holded_item_category": spec.items[held].size if holds else None,
    }


def _corners(rect: Rect) -> list[list[float]]:
    return [[rect.x0, rect.y0], [rect.x1, rect.y1]]
