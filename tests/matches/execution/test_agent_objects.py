"""Agents as objects in `play`: a class, an instance, and what is said about anything else."""

import signal
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, EpisodeInfo, Observation
from movingout.matches import play
from movingout.matches.errors import MatchError
from movingout.matches.execution.agent_objects import AgentLike
from movingout.recordings import read_episode
from movingout.world.state import Floats


class Counting:
    """Drives ahead and counts its episodes."""

    def __init__(self) -> None:
        self.episodes = 0

    def reset(self, episode: EpisodeInfo) -> None:
        self.episodes += 1

    def act(self, observation: Observation) -> ActionChunk:
        return np.array([[1.0, 1.0, 0.0, 0.0]])


class Faulty(Counting):
    def act(self, observation: Observation) -> ActionChunk:
        raise ValueError("no idea")


def test_an_instance_plays_every_match_and_its_recording_names_its_class(tmp_path: Path) -> None:
    agent = Counting()
    results = play(agent, "idle", "HandOff", episodes=3, ticks=5, record=tmp_path)
    assert agent.episodes == 3 and [result.ending for result in results] == ["time"] * 3
    assert results[0].match.blue == f"{__name__}:Counting"
    assert read_episode(Path(results[0].recording)).header.seats[0].name == f"{__name__}:Counting"


def test_a_class_plays_both_seats_and_two_instances_too() -> None:
    for blue, red in ((Counting, Counting), (Counting(), Counting()), (lambda: Counting(), "idle")):
        assert play(blue, red, ticks=3)[0].ending == "time"
    one = Counting()
    with pytest.raises(MatchError, match="cannot play both seats; give its class, or two instances"):
        play(one, one, ticks=3)


@pytest.mark.parametrize("first", ["object", "id", "list"])
def test_an_object_does_not_play_for_the_agent_that_has_the_id_of_its_class(first: str, tmp_path: Path) -> None:
    """It took both seats."""
    agent, name, file = Counting(), f"{__name__}:Counting", tmp_path / "list.txt"
    file.write_text(name)
    pairs: dict[str, tuple[AgentLike, AgentLike]] = {
        "object": (agent, name),
        "id": (name, agent),
        "list": (f"@{file}", agent),
    }
    (result,) = play(*pairs[first], ticks=3)
    assert agent.episodes == 1 and result.ending == "time"
    other = f"{name}:instance=2"
    assert result.match.seats == ((other, name) if first == "object" else (name, other))


def test_objects_give_the_result_that_ids_give() -> None:
    assert (
        play("scripted", Counting, ticks=40)[0].play_hash
        == play("scripted", f"{__name__}:Counting", ticks=40)[0].play_hash
    )


class Circling(Counting):
    """Its robot goes in circles; `seen` are the states that it was shown."""

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[Floats] = []

    def act(self, observation: Observation) -> ActionChunk:
        state, turn = observation.state, 0.1 * observation.tick
        self.seen.append(
            np.concatenate([state.robot_poses, state.robot_velocities, state.item_poses, [[*state.held, 0]]])
        )
        return np.array([[1.0, np.cos(turn), np.sin(turn), 0.0]])


class Scribbling(Circling):
    """The same, but it writes into what it was shown, as code does that normalises in place."""

    def act(self, observation: Observation) -> ActionChunk:
        answer = super().act(observation)
        state = observation.state
        for array in (state.robot_poses, state.robot_velocities, state.item_poses, state.held):
            array *= 0
        return answer


def test_what_an_agent_writes_into_its_observation_changes_no_recording_and_is_not_seen_by_its_partner(
    tmp_path: Path,
) -> None:
    partners = Circling(), Circling()
    results = [
        play(agent, partner, "HandOff", ticks=30, record=tmp_path / type(agent).__name__)[0]
        for agent, partner in zip((Circling(), Scribbling()), partners, strict=True)
    ]
    assert np.array_equal(partners[0].seen, partners[1].seen)
    # blue's hand 0 of a scribbled state holds an item: it would have waited from the first tick to the last
    assert results[0].metrics == results[1].metrics and results[0].play_hash == results[1].play_hash
    one, other = (read_episode(Path(result.recording)) for result in results)
    first, second = (
        episode.to_frame().filter(regex="^(item|blue|red)").select_dtypes("number").to_numpy("float64", na_value=np.nan)
        for episode in (one, other)
    )
    assert np.array_equal(first, second, equal_nan=True)


def test_no_episodes_are_a_fault() -> None:
    with pytest.raises(MatchError, match="episodes is a whole number from 1 to 1000000, not 0"):
        play("idle", "idle", episodes=0)


def test_a_fault_is_told_with_its_place_and_what_is_no_agent_before_anything_is_played() -> None:
    with pytest.warns(UserWarning, match="1 of 1 matches failed: .*ValueError"):
        result = play(Faulty, "idle", ticks=3)[0]
    assert (
        result.ending == "failed" and "ValueError" in result.failure and "test_agent_objects.py, line" in result.failure
    )
    for wrong, sentence in (
        (3, "3 is no agent"),
        (dict, "returns dict, which has no reset"),
        (lambda weights: Counting(), "missing a required argument: 'weights'.*; give an instance"),
    ):
        with pytest.raises(MatchError, match=sentence):
            play(wrong, "idle", ticks=3)  # type: ignore[arg-type]


class Stopped(Counting):
    """Somebody presses Ctrl-C in its first episode."""

    def act(self, observation: Observation) -> ActionChunk:
        if self.episodes == 1 and observation.tick == 2:
            signal.raise_signal(signal.SIGINT)
        return super().act(observation)


class Interrupting(Counting):
    def act(self, observation: Observation) -> ActionChunk:
        raise KeyboardInterrupt("mine")


def test_a_keyboard_interrupt_that_an_agent_raises_is_its_fault_and_no_ctrl_c() -> None:
    """It ended the caller, and a worker process with a traceback, three times."""
    with pytest.warns(UserWarning, match="1 of 1 matches failed"):
        (result,) = play(Interrupting, "idle", ticks=3)
    assert "raised KeyboardInterrupt in act() at tick 0: mine (" in result.failure
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_after_ctrl_c_the_same_can_be_played_and_recorded_again(tmp_path: Path) -> None:
    """A notebook keeps the traceback, and with it the journal, which was locked until the kernel was restarted."""
    agent = Stopped()
    with pytest.raises(KeyboardInterrupt) as kept:
        play(agent, "idle", "HandOff", ticks=5, record=tmp_path)
    assert list(tmp_path.iterdir()) == []
    (result,) = play(agent, "idle", "HandOff", ticks=5, record=tmp_path)
    assert result.ticks == 5 and kept.tb is not None
