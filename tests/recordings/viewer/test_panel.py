"""The viewer's controls, moved by hand; no browser."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from movingout.recordings import read_episode
from movingout.recordings.viewer.cameras import ABOVE, BLUE, Camera
from movingout.recordings.viewer.episode_scene import EpisodeScene
from movingout.recordings.viewer.panel import ALONE, Panel
from tests.recordings.viewer.support import panel, put, recorded


@pytest.fixture
def two(tmp_path: Path) -> Iterator[tuple[Panel, list[Camera]]]:
    """Two episodes side by side, of 30 and of 12 ticks."""
    with panel(recorded(tmp_path, "long", 30), recorded(tmp_path, "short", 12, map_name="FourCorners")) as opened:
        yield opened


def positions(scene: EpisodeScene) -> list[tuple[float, ...]]:
    return [tuple(handle.position) for handle in (*scene.robots, *scene.items)]


def recorded_positions(scene: EpisodeScene, tick: int) -> list[tuple[float, ...]]:
    state = scene.episode.states[tick]
    return [(x, y, 0.0) for x, y, _ in (*state.robot_poses.tolist(), *state.item_poses.tolist())]


def test_the_timeline_puts_every_body_where_it_was_recorded(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):
        scene = opened.scenes[0]
        assert positions(scene) == recorded_positions(scene, 0)
        put(opened.tick, 17)
        assert positions(scene) == recorded_positions(scene, 17)
        angle = scene.episode.states[17].robot_poses[0, 2]
        assert scene.robots[0].wxyz == pytest.approx((math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)))


def test_playing_moves_ten_ticks_a_second_times_the_speed_and_stops_at_the_end(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):
        put(opened.play, True)
        opened.advance(1.0)
        assert (opened.tick.value, opened.play.label) == (10, "Pause")
        put(opened.speed, "2x")
        opened.advance(0.5)
        assert opened.tick.value == 20
        opened.advance(60.0)
        assert (opened.tick.value, opened.play.label) == (30, "Play")


def test_steps_pause_and_stay_inside_the_episode(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):
        put(opened.play, True)
        put(opened.steps, "+10")
        put(opened.steps, "+1")
        assert (opened.tick.value, opened.playback.playing) == (11, False)
        put(opened.steps, "-10")
        put(opened.steps, "-10")
        assert opened.tick.value == 0


def test_jumps_go_from_event_to_event(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):  # the support records an event every five ticks
        put(opened.tick, 7)
        put(opened.events, "after")
        assert opened.tick.value == 10
        put(opened.events, "before")
        assert opened.tick.value == 5


def test_two_episodes_share_the_timeline_and_the_shorter_one_stands_still_at_its_end(
    two: tuple[Panel, list[Camera]],
) -> None:
    opened, _ = two
    long, short = opened.scenes
    assert opened.tick.max == 30
    put(opened.tick, 25)
    assert positions(long) == recorded_positions(long, 25)
    assert positions(short) == recorded_positions(short, 12)
    assert short.shift - long.shift > 2.4


def test_an_episode_can_be_exchanged_for_another_and_stand_alone(two: tuple[Panel, list[Camera]]) -> None:
    opened, _ = two
    put(opened.right, ALONE)
    put(opened.left, "short")
    (scene,) = opened.scenes
    assert scene.episode.header.map.name == "FourCorners"
    assert (opened.tick.max, opened.tick.value) == (12, 0)
    assert scene.shift == 0.0


def test_trails_reach_back_as_far_as_the_slider_says(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):
        put(opened.tick, 20)
        put(opened.trail, 1.0)
        line = opened.scenes[0].trails[1]
        way = [state.robot_poses[1, :2] for state in opened.scenes[0].episode.states[10:21]]
        assert np.allclose(line.points[:, 0, :2], way[:-1]) and np.allclose(line.points[:, 1, :2], way[1:])
        put(opened.trail, 0.0)
        assert not line.visible


def test_the_heat_map_is_drawn_when_it_is_chosen(tmp_path: Path) -> None:
    with panel(recorded(tmp_path)) as (opened, _):
        scene = opened.scenes[0]
        assert scene.heat is None
        put(opened.heat, "red")
        assert scene.heat is not None
        put(opened.heat, "none")
        assert scene.heat is None


def test_cameras_look_from_above_or_over_a_shoulder(two: tuple[Panel, list[Camera]]) -> None:
    opened, views = two
    put(opened.views, ABOVE)
    assert views[-1].position[:2] == (0.0, 0.0) and views[-1].position[2] > 2.0
    put(opened.views, BLUE)
    scene = opened.scenes[0]
    x, y, angle = scene.episode.initial.robot_poses[0].tolist()
    ahead = np.array([-math.sin(angle), math.cos(angle)])
    behind = np.array(views[-1].position[:2]) - np.array([x + scene.shift, y])
    assert behind @ ahead < -0.5


def test_a_recording_that_cannot_be_read_is_told_and_the_shown_one_stays(tmp_path: Path) -> None:
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"not a recording")
    paths = (recorded(tmp_path, "one"), recorded(tmp_path, "other"), broken)
    with panel(*paths) as (opened, _):
        put(opened.left, "broken")
        assert "broken.mcap is not an MCAP file" in opened.about.content
        assert opened.scenes[0].episode.header == read_episode(paths[0]).header


def test_an_episode_that_ended_before_its_first_tick_can_be_looked_at(tmp_path: Path) -> None:
    with panel(recorded(tmp_path, ticks=0)) as (opened, _):
        put(opened.play, True)
        opened.advance(1.0)
        put(opened.heat, "both")
        assert opened.tick.value == 0
        assert positions(opened.scenes[0]) == recorded_positions(opened.scenes[0], 0)
