"""Recordings in which a large item is held alone: the rules find that the partner does not come."""

from pathlib import Path

import numpy as np

from movingout.maps import load_map
from movingout.recordings import EpisodeHeader, EpisodeWriter, SeatInfo, TickRecord, finalise
from movingout.world import World
from tests.recordings.support import STARTED_NS, clock

TICKS = 110
PEOPLE = (SeatInfo("agent", "bass@all"), SeatInfo("human", "P2222222"))


def waiting_alone(folder: Path, episode: str, seats: tuple[SeatInfo, SeatInfo] = PEOPLE, study: str = "pilot") -> Path:
    """Red drives to the large item beside it and holds it; blue never moves."""
    head = EpisodeHeader(
        episode_id=episode,
        map=load_map("SingleRotation"),
        seed=1,
        limit_ticks=TICKS,
        seats=seats,
        started_ns=STARTED_NS,
        source="live",
        study={"study": study},
    )
    world = World(head.map)
    writer = EpisodeWriter.create(folder, head, world.state(), clock=clock().__next__)
    for _ in range(TICKS):
        actions = np.array([[0.0, 0.0, 0.0], _towards_item(world)])
        world.step(actions)
        delivered = tuple(world.delivered().tolist())
        writer.tick(TickRecord(actions, ("agent", "human"), (-1, 0), world.state(), delivered, 0.1))
    return finalise(writer.close("time"))


def _towards_item(world: World) -> list[float]:
    """Drive to the nearest item that is not small, grab it, then stand still."""
    state = world.state()
    if state.held[1] >= 0:
        return [0.0, float(state.robot_poses[1, 2]), 0.0]
    here = state.robot_poses[1, :2]
    large = [number for number, item in enumerate(world.map.items) if item.size != "small"]
    gaps = [float(np.linalg.norm(state.item_poses[number, :2] - here)) for number in large]
    way = state.item_poses[large[int(np.argmin(gaps))], :2] - here
    heading = float(np.arctan2(-way[0], way[1]))
    return [1.0, heading, float(world.state().tick % 5 == 4)]
