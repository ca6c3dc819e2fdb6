"""Our own golden episodes: their file format, and replaying them.

A file holds a map's name, the actions, a hash of every state, and some whole states for machines on which
other floats are to be expected.
"""

import hashlib
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from movingout.maps import load_map
from movingout.world import World, WorldState

FOLDER = Path(__file__).parent / "golden"
WINDOW_TICKS = 100  # whole states are kept at most this far ...
WINDOW_STEP = 10  # ... at every tenth tick, and not beyond where rounding grows: see make_golden.py


@dataclass(frozen=True, slots=True, eq=False)
class Golden:
    """One episode and what our world made of it; T is its number of ticks."""

    map_name: str
    pymunk: str  # the engine's version
    actions: npt.NDArray[np.float64]  # (T, 2, 3)
    hashes: npt.NDArray[np.uint64]  # (T + 1,)
    window: npt.NDArray[np.float64]  # (K, 2 + N, 3) poses at ticks 0, 10, ... of the window


def play(map_name: str, actions: npt.NDArray[np.float64], pymunk: str, window_ticks: int = WINDOW_TICKS) -> Golden:
    """Play the actions in a fresh world."""
    world = World(load_map(map_name))
    hashes, window = [state_hash(world)], [poses(world.state())]
    for action in actions:
        world.step(action)
        hashes.append(state_hash(world))
        if world.tick <= window_ticks and world.tick % WINDOW_STEP == 0:
            window.append(poses(world.state()))
    return Golden(map_name, pymunk, actions, np.array(hashes, dtype=np.uint64), np.array(window))


def state_hash(world: World) -> int:
    """64 bits over every number of the state, the sub-poses and the deliveries."""
    state = world.state()
    parts = [np.asarray(part).tobytes() for part in (*astuple(state), world.sub_poses(), world.delivered())]
    return int.from_bytes(hashlib.blake2b(b"".join(parts), digest_size=8).digest(), "little")


def poses(state: WorldState) -> npt.NDArray[np.float64]:
    return np.vstack([state.robot_poses, state.item_poses])


def save(golden: Golden, path: Path) -> None:
    np.savez_compressed(
        path,
        map_name=golden.map_name,
        pymunk=golden.pymunk,
        actions=golden.actions,
        hashes=golden.hashes,
        window=golden.window,
    )


def load(path: Path) -> Golden:
    with np.load(path) as file:
        return Golden(str(file["map_name"]), str(file["pymunk"]), file["actions"], file["hashes"], file["window"])
