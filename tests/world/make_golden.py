"""Make the golden episodes anew: `python -m tests.world.make_golden`.

Needed only when the physics changes on purpose. Three kinds: scripted carrying (tests/world/carries.py), random
driving with grasps on every map, and two scripted agents on each of the twelve.
"""

import dataclasses

import numpy as np
import numpy.typing as npt
import pymunk

from movingout.agents.base import EpisodeInfo, Observation
from movingout.agents.catalogue import load_agent
from movingout.maps import MapSpec, Pose, load_map, map_names
from movingout.world import World, WorldState
from movingout.world.action import to_world
from movingout.world.observation import encode_state
from tests.world import golden_episode
from tests.world.carries import EPISODES

DRIVING_TICKS = 150
AGENT_TICKS = 500
NUDGE = 1e-14  # about what another machine's rounding does; where it grows beyond GROWN, the window ends
GROWN = 1e-10

Actions = npt.NDArray[np.float64]


def main() -> None:
    golden_episode.FOLDER.mkdir(exist_ok=True)
    for old in golden_episode.FOLDER.glob("*.npz"):
        old.unlink()
    for name, make in EPISODES.items():
        script = make()
        save(name.replace(" ", "-"), script.map_name, np.array(script.actions))
    for seed, map_name in enumerate((*map_names(), "Simple")):
        save(f"driving-{map_name}", map_name, driving(seed))
    for map_name in map_names():
        save(f"scripted-{map_name}", map_name, agents_play(load_map(map_name)))


def save(name: str, map_name: str, actions: Actions) -> None:
    ticks = stable_ticks(load_map(map_name), actions)
    path = golden_episode.FOLDER / f"{name}.npz"
    golden_episode.save(golden_episode.play(map_name, actions, pymunk.version, ticks), path)
    print(f"{path.name}: {len(actions)} ticks, window {ticks}, {path.stat().st_size} bytes")  # noqa: T201


def driving(seed: int) -> Actions:
    """Random headings that drift, and grasps: (T, 2, 3)."""
    generator = np.random.default_rng(seed)
    distances = generator.uniform(-0.2, 1.0, (DRIVING_TICKS, 2))
    headings = np.cumsum(generator.normal(0.0, 0.3, (DRIVING_TICKS, 2)), axis=0)
    grasps = generator.random((DRIVING_TICKS, 2)) < 0.25
    return np.stack([distances, headings, grasps], axis=2)


def agents_play(spec: MapSpec) -> Actions:
    """What two scripted agents do: (T, 2, 3)."""
    world, players, actions = World(spec), [load_agent("scripted") for _ in range(2)], []
    for seat, player in enumerate(players):
        player.reset(EpisodeInfo(spec, seat, seed=seat, ticks=AGENT_TICKS))
    for _ in range(AGENT_TICKS):
        state = world.state()
        chunks = [player.act(view(spec, state, seat)) for seat, player in enumerate(players)]
        actions.append(to_world(np.array([chunk[0] for chunk in chunks])))
        world.step(actions[-1])
        if world.score() == 1.0:
            break
    return np.array(actions)


def view(spec: MapSpec, state: WorldState, seat: int) -> Observation:
    return Observation(state, state.tick, seat, lambda layout: encode_state(spec, state, seat, layout))


def stable_ticks(spec: MapSpec, actions: Actions) -> int:
    """How far the episode stays the same when everything is nudged, as on a machine that rounds otherwise."""
    generator = np.random.default_rng(0)
    robots = [Pose(*(np.array([p.x, p.y, p.angle]) + NUDGE * generator.normal(size=3))) for p in spec.robots]
    worlds = World(spec), World(dataclasses.replace(spec, robots=(robots[0], robots[1])))
    for tick, action in enumerate(actions[: golden_episode.WINDOW_TICKS]):
        nudged = action * (1 + NUDGE * generator.normal(size=(2, 3)))
        for world, numbers in zip(worlds, (action, nudged), strict=True):
            world.step(numbers)
        here, there = (golden_episode.poses(world.state()) for world in worlds)
        if np.abs(here - there).max() > GROWN:
            return tick
    return min(len(actions), golden_episode.WINDOW_TICKS)


if __name__ == "__main__":
    main()
