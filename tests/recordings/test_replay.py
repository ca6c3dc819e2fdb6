"""The replay that the browser gets: the same poses that the players saw."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from movingout.maps.spec import Pose
from movingout.recordings import EpisodeWriter, TickRecord, browser_replay, finalise, read_episode
from movingout.recordings.replay import replay_poses
from movingout.world import World
from movingout.world.state import WorldState
from tests.recordings.support import header, record

POSITION, ANGLE = 20000.0, 32768 / math.pi


def test_frames_are_the_sub_poses_of_the_world(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=20, map_name="AdaptiveAssist")
    summary, frames, _ = browser_replay(finalise(journal), POSITION, ANGLE)
    world = World(played.header.map)
    expected = [world.sub_poses()[-1:]]
    for tick in played.ticks:
        world.step(tick.actions)
        expected.append(world.sub_poses())
    poses = np.concatenate(expected)
    assert frames.shape == poses.shape == (101, 8, 3)
    assert frames.dtype == np.int16
    np.testing.assert_allclose(frames[..., :2] / POSITION, poses[..., :2], atol=0.5 / POSITION + 1e-12)
    turns = (frames[..., 2] / ANGLE - poses[..., 2] + math.pi) % (2 * math.pi) - math.pi
    assert np.abs(turns).max() <= 0.5 / ANGLE + 1e-9
    assert summary["exact"] is True


def test_the_summary_is_json_with_everything_but_the_poses(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=20)
    summary, _, _ = browser_replay(journal, POSITION, ANGLE)
    assert json.loads(json.dumps(summary)) == summary
    assert summary["map"]["name"] == "HandOff"
    assert summary["ticks"] == len(summary["delivered"]) == len(summary["held"]) - 1 == 20
    assert [event["tick"] for event in summary["events"]] == [5, 10, 15, 20]
    assert [seat["name"] for seat in summary["seats"]] == ["P-3f2a", "scripted"]
    assert summary["held"] == [state.held.tolist() for state in read_episode(journal).states]
    assert played.header.episode_id == summary["id"]
    for name, curve in summary["curves"].items():
        assert len(curve) == 20
        assert curve[-1] == summary["metrics"][name]


def test_items_that_lie_in_a_goal_from_the_start_count_as_delivered_before_the_first_tick(tmp_path: Path) -> None:
    start = header()
    goal, item = start.map.goals[0], start.map.items[0]
    middle = Pose((goal.left + goal.right) / 2, (goal.bottom + goal.top) / 2, 0.0)
    inside = replace(start.map, items=(replace(item, pose=middle), *start.map.items[1:]))
    world = World(inside)
    writer = EpisodeWriter.create(tmp_path, replace(start, map=inside), world.state())
    summary, _, _ = browser_replay(writer.close("time"), POSITION, ANGLE)
    assert summary["delivered_at_start"] == world.delivered().tolist() == [True, False, False, False]
    assert summary["delivered"] == []


def test_what_an_agent_weighed_is_told_beside_the_episode(tmp_path: Path) -> None:
    journal, played = record(tmp_path, ticks=20)
    summary, _, traces = browser_replay(journal, POSITION, ANGLE)
    assert summary["has_thoughts"] is True
    assert json.loads(json.dumps(traces)) == traces
    assert [trace["tick"] for trace in traces] == [d.tick for d in played.decisions if d.detail]
    expected = {"seat": 1, "tick": 1, "chosen": 0, "scores": [0.5], "ways": [[[0.0, 1.0], [0.1, 1.1]]], "moves": []}
    assert traces[0] == {**expected, "robots": [], "guesses": []}


def test_states_that_cannot_be_simulated_are_interpolated(tmp_path: Path) -> None:
    start = header()
    initial = World(start.map).state()
    writer = EpisodeWriter.create(tmp_path, start, initial)
    jump = initial.robot_poses.copy()
    jump[0] += (0.5, 0.0, 3.5)
    after = WorldState(1, jump, initial.robot_velocities, initial.held, initial.item_poses)
    writer.tick(TickRecord(np.zeros((2, 3)), ("idle", "idle"), (-1, -1), after, (False,) * 4, 0.0))
    poses, exact = replay_poses(read_episode(writer.close("time")))
    assert not exact
    assert poses.shape == (6, 6, 3)
    np.testing.assert_allclose(poses[:, 0, 0] - poses[0, 0, 0], [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    np.testing.assert_allclose(np.diff(poses[:, 0, 2]), (3.5 - 2 * math.pi) / 5, err_msg="the shorter way round")
