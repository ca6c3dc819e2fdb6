"""Episodes as training data: the observation at time t with the action taken then, per seat or for both at once.

Unlike the tables, where a row is the state after its action, row t here is (s_t, a_t), as behaviour cloning wants it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from movingout.maps.spec import SEAT_COLOURS
from movingout.recordings.episode import Episode
from movingout.recordings.errors import RecordingError
from movingout.world.action import to_policy, turned
from movingout.world.observation import LAYOUTS, encoder
from movingout.world.reward import PaperReward

Singles = npt.NDArray[np.float32]
ACTION_NAMES = ("distance", "cos", "sin", "grasp")
VIEWS = ("ego", "joint")


@dataclass(frozen=True, slots=True)
class ExportedTrajectory:
    """T steps as one seat saw them, or as blue saw them with both actions (`seat` is -1)."""

    episode_id: str
    seat: int
    task: str  # one line
    split: str
    map: str  # its name
    variant: str  # of Challenge 2, empty on a map as designed
    observations: Singles  # (T + 1, D)
    actions: Singles  # (T, 4) or (T, 8): blue's, then red's; headings in the frame of the observations
    rewards: Singles  # (T,) the paper's dense reward, of the seat or of both together
    dones: npt.NDArray[np.bool_]  # (T,) everything delivered


def trajectories(episode: Episode, split: str, view: str, layout: str) -> Iterator[ExportedTrajectory]:
    """One trajectory per seat (`ego`) or one for both (`joint`); none for an episode without ticks.

    Raises RecordingError for a view or layout that is none.
    """
    if view not in VIEWS:
        raise RecordingError(f"unknown view {view!r}; known: {', '.join(VIEWS)}")
    if layout not in LAYOUTS:
        raise RecordingError(f"unknown layout {layout!r}; known: {', '.join(LAYOUTS)}")
    if not episode.ticks:
        return
    seen = _observations(episode, layout)
    actions = _actions(episode, view, layout)
    rewards = _rewards(episode)
    dones = np.array([all(tick.delivered) for tick in episode.ticks])
    task = f"{episode.header.map.title}: {episode.header.map.description}"
    common = (task, split, episode.header.map.name, episode.header.map.variant)
    episode_id = episode.header.episode_id
    if view == "joint":
        both = actions.reshape(len(actions), 8)
        yield ExportedTrajectory(episode_id, -1, *common, seen[0], both, rewards.sum(axis=1), dones)
        return
    for seat in (0, 1):
        yield ExportedTrajectory(episode_id, seat, *common, seen[seat], actions[:, seat], rewards[:, seat], dones)


def all_trajectories(episode: Episode, split: str, view: str, layout: str) -> list[ExportedTrajectory]:
    """The same at once, as a value that can be sent between processes."""
    return list(trajectories(episode, split, view, layout))


def action_names(view: str) -> list[str]:
    """A name for each number of an action."""
    if view == "joint":
        return [f"{colour}_{name}" for colour in SEAT_COLOURS for name in ACTION_NAMES]
    return list(ACTION_NAMES)


def headings(view: str, layout: str) -> str:
    """What headings of actions are relative to: own or arena, and blue where blue's frame is that of both."""
    said = LAYOUTS[layout].headings
    return "blue" if view == "joint" and said == "own" else said


def _observations(episode: Episode, layout: str) -> Singles:
    """(2, T + 1, D) what each seat saw, the last state included."""
    states, encode = episode.states, encoder(episode.header.map, layout).encode_arrays
    arrays = (
        np.array([state.robot_poses for state in states]),
        np.array([state.robot_velocities for state in states]),
        np.array([state.held for state in states]),
        np.array([state.item_poses for state in states]),
    )
    return np.array([encode(*arrays, seat) for seat in (0, 1)], dtype=np.float32)


def _actions(episode: Episode, view: str, layout: str) -> Singles:
    """(T, 2, 4) what each seat did; in an own frame, headings are relative to the angle of the seat that saw."""
    actions = to_policy(episode.actions)
    if LAYOUTS[layout].own_frame:
        angles = np.array([state.robot_poses[:, 2] for state in episode.states[:-1]])
        for seat in (0, 1):
            actions[:, seat] = turned(actions[:, seat], -angles[:, 0 if view == "joint" else seat])
    return actions.astype(np.float32)


def _rewards(episode: Episode) -> Singles:
    """(T, 2) the paper's dense reward of each tick."""
    reward = PaperReward(episode.header.map)
    return np.array([reward(before, after) for before, after in pairwise(episode.states)], dtype=np.float32)
