"""Verification: a true record passes, any untruth is named."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.recordings import Episode, EpisodeWriter, Event, InputSample, TickRecord, finalise, read_episode, verify
from movingout.recordings.verification import first_divergence, first_unexplained
from movingout.recordings.versions import versions, why_not_exact
from movingout.world import World
from movingout.world.state import WorldState
from tests.recordings.support import record


@pytest.fixture(scope="module")
def episode(tmp_path_factory: pytest.TempPathFactory) -> Episode:
    journal, _ = record(tmp_path_factory.mktemp("verify"), ticks=25, map_name="LeftRight")
    return read_episode(journal)


def changed(episode: Episode, tick: int, change: Callable[[TickRecord], TickRecord]) -> Episode:
    ticks = list(episode.ticks)
    ticks[tick - 1] = change(ticks[tick - 1])
    return replace(episode, ticks=tuple(ticks))


def with_state(record: TickRecord, **fields: object) -> TickRecord:
    names = ("tick", "robot_poses", "robot_velocities", "held", "item_poses")
    values = {name: getattr(record.state, name) for name in names} | fields
    return record._replace(state=WorldState(**values))


def test_a_true_recording_is_identical_finished_or_not(tmp_path: Path) -> None:
    journal, _ = record(tmp_path, ticks=40, map_name="CornerDecision")
    for verdict in (verify(journal), verify(finalise(journal))):
        assert (verdict.ticks, verdict.identical, verdict.caveat, verdict.damage) == (40, True, "", "")


def test_the_smallest_change_of_a_position_is_named_with_tick_and_field(episode: Episode) -> None:
    def nudge(record: TickRecord) -> TickRecord:
        poses = record.state.item_poses.copy()
        poses[1, 0] = np.nextafter(poses[1, 0], 2.0)
        return with_state(record, item_poses=poses)

    found = first_divergence(changed(episode, 17, nudge))
    assert found is not None
    assert (found.tick, found.field) == (17, "item_poses[1, 0]")
    assert found.recorded != found.simulated
    assert str(found).startswith("tick 17, item_poses[1, 0]: recorded ")


def test_an_action_that_its_input_does_not_say_is_named_though_the_states_follow_from_it(tmp_path: Path) -> None:
    journal, played = record(tmp_path / "true", ticks=6, map_name="LeftRight")
    forged = EpisodeWriter.create(tmp_path / "forged", played.header, World(played.header.map).state())
    world = World(played.header.map)
    for tick, sample in zip(read_episode(journal).ticks, played.inputs, strict=True):
        actions = tick.actions.copy()
        actions[0, 1] += 0.5 * (tick.state.tick == 4)
        world.step(actions)
        forged.input(sample)
        forged.tick(tick._replace(actions=actions, state=world.state(), delivered=tuple(world.delivered().tolist())))
    found = verify(finalise(forged.close("time"))).first_divergence
    assert found is not None
    assert (found.tick, found.field) == (4, "actions[0].heading")
    assert found.recorded == found.simulated + 0.5


def test_a_stick_let_go_or_last_heard_of_before_play_began_is_at_rest(episode: Episode) -> None:
    def at_rest(record: TickRecord) -> TickRecord:
        actions = record.actions.copy()
        actions[0, 0] = 0.0
        return record._replace(actions=actions)

    assert first_unexplained(changed(episode, 1, at_rest)) is None
    unheard = replace(episode, inputs=episode.inputs[1:])
    assert first_unexplained(changed(unheard, 1, at_rest)) is None
    found = first_unexplained(unheard)
    assert found is not None
    assert (found.tick, found.field, found.simulated) == (1, "actions[0].distance", 0.0)


def test_inputs_of_an_earlier_connection_explain_nothing(tmp_path: Path) -> None:
    """Recordings used to leave out what a seat sent before play went on; their numbers repeat after a return."""
    _, played = record(tmp_path / "like", ticks=3, map_name="LeftRight")
    world = World(played.header.map)
    writer = EpisodeWriter.create(tmp_path, replace(played.header, episode_id="returned"), world.state())
    sample = InputSample(1, 0, 5, 0.0, 1.0, 0.25, 0, "keyboard", 20.0)

    def step(distance: float, heading: float) -> None:
        actions = np.array([[distance, heading, 0.0], [0.0, 0.0, 0.0]])
        world.step(actions)
        delivered = tuple(world.delivered().tolist())
        writer.tick(TickRecord(actions, ("human", "idle"), (5, -1), world.state(), delivered, 0.0))

    writer.input(sample)
    step(1.0, 0.25)
    writer.event(Event(2, "drop", 0))
    writer.event(Event(2, "return", 0))
    writer.event(Event(2, "resume"))
    step(0.0, -1.5)  # the fifth input of the new connection, sent during the countdown
    writer.input(sample._replace(tick=3, heading=-1.0))
    step(1.0, -1.0)
    assert verify(writer.close("time")).first_divergence is None


def test_a_changed_hold_is_named(episode: Episode) -> None:
    found = first_divergence(changed(episode, 4, lambda r: with_state(r, held=np.array([2, -1]))))
    assert found is not None
    assert (found.tick, found.field, found.recorded) == (4, "held[0]", 2.0)


def test_a_changed_delivery_is_named(episode: Episode) -> None:
    found = first_divergence(changed(episode, 9, lambda r: r._replace(delivered=(True, False, False))))
    assert found is not None
    assert (found.tick, found.field, found.recorded, found.simulated) == (9, "delivered[0]", 1.0, 0.0)


def test_a_changed_action_shows_in_the_state_after_it(episode: Episode) -> None:
    def turn(record: TickRecord) -> TickRecord:
        actions = record.actions.copy()
        actions[0] = (1.0, actions[0, 1] + 1.0, 0.0)
        return record._replace(actions=actions)

    found = first_divergence(changed(episode, 6, turn))
    assert found is not None
    assert found.tick == 6
    assert found.field.startswith("robot_")


def test_a_changed_start_is_named(episode: Episode) -> None:
    start = episode.initial
    poses = start.robot_poses.copy()
    poses[1, 2] += 0.5
    moved = WorldState(0, poses, start.robot_velocities, start.held, start.item_poses)
    found = first_divergence(replace(episode, initial=moved))
    assert found is not None
    assert (found.tick, found.field) == (0, "robot_poses[1, 2]")


def test_a_false_recording_on_disk_is_found(tmp_path: Path, episode: Episode) -> None:
    writer = EpisodeWriter.create(tmp_path, replace(episode.header, episode_id="false"), episode.initial)
    false = changed(episode, 12, lambda r: with_state(r, robot_poses=r.state.robot_poses + 1e-9))
    for sample, tick in zip(false.inputs, false.ticks, strict=True):
        writer.input(sample)
        writer.tick(tick)
    verdict = verify(finalise(writer.close("time")))
    assert not verdict.identical
    assert verdict.first_divergence is not None
    assert (verdict.first_divergence.tick, verdict.first_divergence.field) == (12, "robot_poses[0, 0]")


def test_another_engine_means_no_promise() -> None:
    assert why_not_exact(versions()) == ""
    sentence = why_not_exact({**versions(), "pymunk": "7.0.0"})
    assert "pymunk 7.0.0 (here 6.11.1)" in sentence
    assert "equal bits are not promised" in sentence
