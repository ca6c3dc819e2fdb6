"""A recorded seat plays again in a live room: from the server's own recordings by id, or as the operator's partner."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from movingout.maps import load_map
from movingout.maps.randomize import randomize
from movingout.recordings import finalise, read_episode
from movingout.server.cli import main
from movingout.server.rooms.ghost_partner import ghost_seat
from movingout.server.rooms.seat import Seat
from tests.recordings.support import record
from tests.server.live import Live, serve

TICKS = 30


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    journal, _ = record(tmp_path_factory.mktemp("ghosts"), ticks=TICKS, map_name="HandOff", episode_id="then")
    return finalise(journal)


@pytest.fixture
def kept(live: Live, recording: Path) -> str:
    """The id of the recording among the server's own."""
    shutil.copy(recording, live.host.settings.recordings / recording.name)
    return "then"


def asked(live: Live, *seats: dict[str, str], **room: object) -> tuple[int, Any]:
    return live.call("/api/rooms", {"maps": [], "seats": list(seats), "limit_ticks": TICKS, **room})


@pytest.mark.slow
def test_a_person_plays_with_the_recorded_red(live: Live, kept: str, recording: Path) -> None:
    status, room = asked(live, {"kind": "here"}, {"kind": "ghost", "recording": kept})
    assert status == 200, room
    person = live.person(room["room"], tokens=[room["tokens"][0]])
    assert person.wait_for("round")["map"]["name"] == "HandOff"
    person.say(type="ready", seat=0, ready=True)
    again = person.play_out()["recording"]
    path = live.host.settings.recordings / f"{again}.mcap"
    live.call(f"/api/recordings/{again}")  # waits until it is finalised
    episode, then = read_episode(path), read_episode(recording)
    red = episode.header.seats[1]
    assert (red.kind, red.name) == ("ghost", "ghost:then#red")
    assert {tick.sources[1] for tick in episode.ticks} == {"ghost"}
    np.testing.assert_allclose(episode.actions[:, 1], then.actions[:, 1], atol=1e-12)
    assert person.told[-1]["recording"] == again


def test_the_map_comes_from_the_recording_and_no_other_is_played(live: Live, kept: str) -> None:
    seats: tuple[dict[str, str], ...] = ({"kind": "here"}, {"kind": "ghost", "recording": kept})
    assert asked(live, *seats, maps=["HandOff"])[0] == 200
    for wrong in ({"maps": ["Simple"]}, {"maps": ["HandOff", "HandOff"]}, {"challenge2_seed": 3}):
        status, answer = asked(live, *seats, **wrong)
        assert (status, answer["error"]["code"]) == (422, "ghost")
        assert "recorded on HandOff" in answer["error"]["message"]


@pytest.mark.parametrize("name", ["../then", "/etc/passwd", "then.mcap", "", "gone", "then#red"])
def test_only_an_id_among_the_recordings_of_the_server_is_a_ghost(live: Live, kept: str, name: str) -> None:
    status, answer = asked(live, {"kind": "here"}, {"kind": "ghost", "recording": name})
    assert (status, answer["error"]["code"]) == (422, "ghost")


def test_a_ghost_is_recorded_under_its_episode_whatever_the_file_is_called(recording: Path, tmp_path: Path) -> None:
    copy = shutil.copy(recording, tmp_path / "best.mcap")
    assert ghost_seat(f"{copy}#red").seat_at(1).info().name == "ghost:then#red"
    assert Seat(1, "ghost", f"ghost:{copy}#red").info().name == "ghost:then#red", "of a room that was saved before"


def test_a_ghost_is_no_agent_that_anybody_may_name(live: Live, recording: Path) -> None:
    status, answer = asked(
        live, {"kind": "here"}, {"kind": "agent", "agent": f"ghost:{recording}#red"}, maps=["HandOff"]
    )
    assert (status, answer["error"]["code"]) == (422, "unknown_agent")


def test_a_randomised_map_comes_back_as_it_was(live: Live, tmp_path: Path) -> None:
    variant = randomize(load_map("HandOff"), 7, "evaluation")  # 7: the seed in the header of tests.recordings
    journal, _ = record(tmp_path, ticks=3, map=variant, episode_id="changed")
    shutil.copy(finalise(journal), live.host.settings.recordings / "changed.mcap")
    status, room = asked(live, {"kind": "ghost", "recording": "changed"}, {"kind": "here"})
    assert status == 200, room
    person = live.person(room["room"], tokens=[room["tokens"][1]])
    assert person.wait_for("round")["map"]["variant"] == "challenge2-evaluation-7"


@pytest.mark.slow
def test_the_operator_names_a_ghost_and_the_lobby_offers_it(tmp_path: Path, recording: Path) -> None:
    partner = f"ghost:{recording}#red"
    with serve(tmp_path, partner=partner) as live:
        _, offered = live.call("/api/agents")
        assert offered["default"] == offered["agents"][-1]["id"] == partner
        person, ghost = {"kind": "here"}, {"kind": "agent", "agent": partner}
        assert asked(live, person, ghost, maps=["HandOff"])[0] == 200
        _, answer = asked(live, ghost, person, maps=["HandOff"])
        assert "in the red seat" in answer["error"]["message"]


def test_a_partner_that_is_no_recording_is_told_before_the_server_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["play", "--data", str(tmp_path), "--port", "0", "--partner", f"ghost:{tmp_path}/gone.mcap#red"]) == 2
    assert "gone.mcap" in capsys.readouterr().err
