"""Small things to learn from: episodes of random but smooth motion, and the smallest policies."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from movingout.agents.checkpoint.policy_spec import Grasp, PolicySpec
from movingout.agents.data.dataset import Trajectory, Windows, trajectory_samples, windows_of
from movingout.maps import MapSpec, load_map
from movingout.recordings import EpisodeHeader, EpisodeWriter, SeatInfo, TickRecord, finalise
from movingout.recordings.episode import Outcome, SeatKind, Source
from movingout.world import World
from movingout.world.state import WorldState


def tiny_spec(**changes: object) -> PolicySpec:
    """A policy that builds in no time."""
    fields = {"kind": "dp", "layout": "aware-v1", "obs_horizon": 2, "horizon": 8, "execute": 2, "width": 16, "depth": 1}
    return PolicySpec.model_validate({**fields, **changes})


def random_walk(ticks: int, seed: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """World actions (T, 2, 3): headings that drift, now and then a press."""
    random = np.random.default_rng(seed)
    actions = np.zeros((ticks, 2, 3))
    actions[..., 0] = random.uniform(0.3, 1.0, (ticks, 2))
    actions[..., 1] = np.cumsum(random.normal(0.0, 0.3, (ticks, 2)), axis=0)
    actions[..., 2] = random.random((ticks, 2)) < 0.2
    return actions


def walked(
    map_name: str = "HandOff", ticks: int = 40, seed: int = 0, people: tuple[str, str] = ("a", "b")
) -> Trajectory:
    """A trajectory of random motion in the real world."""
    return trajectory_of_actions(load_map(map_name), random_walk(ticks, seed), people)


def trajectory_windows(trajectories: Sequence[Trajectory], layout: str, grasp: Grasp) -> Windows:
    """The windows of all acting seats."""
    return windows_of(trajectory_samples(trajectories, layout, grasp))


def trajectory_of_actions(
    the_map: MapSpec, actions: np.ndarray[tuple[int, ...], np.dtype[np.float64]], people: tuple[str, str] = ("a", "b")
) -> Trajectory:
    """What comes of world actions (T, 2, 3)."""
    states = states_of(the_map, actions)
    return Trajectory(
        the_map,
        people,
        np.array([state.robot_poses for state in states]),
        np.array([state.robot_velocities for state in states]),
        np.array([state.held for state in states]),
        np.array([state.item_poses for state in states]),
        actions,
    )


def states_of(the_map: MapSpec, actions: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[WorldState]:
    """T + 1 states."""
    world = World(the_map, record_sub_poses=False)
    states = [world.state()]
    for action in actions:
        world.step(action)
        states.append(world.state())
    return states


def recorded(
    folder: Path,
    episode_id: str,
    ticks: int = 40,
    seed: int = 0,
    people: tuple[str, str] = ("a", "b"),
    *,
    kinds: tuple[SeatKind, SeatKind] = ("agent", "agent"),
    source: Source = "scripted",
    outcome: Outcome = "time",
    the_map: MapSpec | None = None,
    simulated: bool = False,
    actions: np.ndarray[tuple[int, ...], np.dtype[np.float64]] | None = None,
) -> Path:
    """A finished recording of random motion or given actions; `simulated`: of a rehearsal of a study."""
    the_map, actions = the_map or load_map("HandOff"), random_walk(ticks, seed) if actions is None else actions
    world = World(the_map, record_sub_poses=False)
    header = EpisodeHeader(
        episode_id, the_map, seed, ticks, (SeatInfo(kinds[0], people[0]), SeatInfo(kinds[1], people[1])), 1, source,
        {"simulated": "yes"} if simulated else {},
    )  # fmt: skip
    writer = EpisodeWriter.create(folder, header, world.state())
    for action in actions:
        world.step(action)
        delivered = tuple(bool(flag) for flag in world.delivered())
        writer.tick(TickRecord(action, ("agent", "agent"), (-1, -1), world.state(), delivered, 0.0))
    return finalise(writer.close(outcome))
