"""A ghost repeats its recording, in its own seat on its own map."""

from pathlib import Path

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo, Observation
from movingout.agents.catalogue import agent_card, load_agent
from movingout.agents.errors import AgentError
from movingout.maps import load_map
from movingout.recordings import finalise
from movingout.world import World
from movingout.world.action import to_world
from movingout.world.observation import encode_state
from tests.recordings.support import Played, record


@pytest.fixture
def recording(tmp_path: Path) -> tuple[Path, Played]:
    journal, played = record(tmp_path, ticks=50, map_name="LeftRight")
    return finalise(journal), played


def observation(world: World, seat: int) -> Observation:
    state = world.state()
    return Observation(state, state.tick, seat, lambda layout: encode_state(world.map, state, seat, layout))


def test_two_ghosts_of_one_recording_play_the_episode_again(recording: tuple[Path, Played]) -> None:
    path, played = recording
    world = World(played.header.map)
    ghosts = [load_agent(f"ghost:{path}#{colour}") for colour in ("blue", "red")]
    for seat, ghost in enumerate(ghosts):
        ghost.reset(EpisodeInfo(world.map, seat, 0, 500))
    for tick in played.ticks:
        rows = [ghost.act(observation(world, seat))[0] for seat, ghost in enumerate(ghosts)]
        world.step(to_world(np.array(rows)))
        np.testing.assert_allclose(world.state().robot_poses, tick.state.robot_poses, atol=1e-6)


def test_after_its_last_tick_a_ghost_stands_still(recording: tuple[Path, Played]) -> None:
    path, played = recording
    ghost = load_agent(f"ghost:{path}#red")
    world = World(played.header.map)
    for _ in range(50):
        world.step(np.zeros((2, 3)))
    assert ghost.act(observation(world, 1)).tolist() == [[0.0, 1.0, 0.0, 0.0]]


def test_a_ghost_has_a_card_of_its_own(recording: tuple[Path, Played]) -> None:
    card = agent_card(f"ghost:{recording[0]}#red")
    assert (card.kind, card.name) == ("ghost", "Ghost")


def test_another_map_or_seat_is_refused(recording: tuple[Path, Played]) -> None:
    path, played = recording
    ghost = load_agent(f"ghost:{path}#red")
    with pytest.raises(AgentError, match="recorded on LeftRight, not on HandOff"):
        ghost.reset(EpisodeInfo(load_map("HandOff"), 1, 0, 500))
    with pytest.raises(AgentError, match="in the red seat"):
        ghost.reset(EpisodeInfo(played.header.map, 0, 0, 500))


@pytest.mark.parametrize("text", ["", "x.mcap", "x.mcap#green", "none.mcap#red"])
def test_a_ghost_that_names_no_recorded_seat_gets_a_sentence(text: str) -> None:
    with pytest.raises(AgentError, match=r"FILE#blue or FILE#red|there is no such file"):
        load_agent(f"ghost:{text}")
