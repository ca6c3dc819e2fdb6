"""Pings: shown to both, recorded, seen by agents, limited, and refused where they are off."""

from pathlib import Path

import pytest
from mcap.reader import make_reader

from movingout.recordings import finalise, read_episode, verify
from movingout.recordings.pings import ping_outcomes
from movingout.server import messages as m
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.services import WrongRequest
from movingout.world.ping import PING_TICKS
from tests.server.support import Ear, FakeServices, Table


def pings(ear: Ear) -> list[m.ShownPing]:
    return [message for message in ear.told if isinstance(message, m.ShownPing)]


def test_both_and_spectators_see_where_somebody_asks_for_help() -> None:
    table = Table(pings=True)
    blue, red = table.play()
    watcher = table.join(mode="watch")
    table.push(red, 1)
    table.step(5)
    state = table.room.round.state
    table.say(red, m.SayPing(1))
    table.say(red, m.SayPing(1, item=2))
    robot, item = state.robot_poses[1].tolist(), state.item_poses[2].tolist()
    expected = [
        m.ShownPing(table.room.round.epoch, state.tick + 1, 1, -1, robot[0], robot[1], PING_TICKS),
        m.ShownPing(table.room.round.epoch, state.tick + 1, 1, 2, item[0], item[1], PING_TICKS),
    ]
    assert pings(blue) == pings(red) == pings(watcher) == expected


def test_the_welcome_says_whether_there_are_pings() -> None:
    for on in (True, False):
        welcome = Table(pings=on).join(claim=1).last(m.Welcome)
        assert isinstance(welcome, m.Welcome) and welcome.pings is on


@pytest.mark.parametrize(
    ("message", "code"),
    [(m.SayPing(1), "not_your_seat"), (m.SayPing(0, 3), "ping_item"), (m.SayPing(0, -2), "ping_item")],
)
def test_a_ping_for_another_seat_or_at_no_item_is_refused(message: m.SayPing, code: str) -> None:
    table = Table(pings=True)
    blue, red = table.play()
    with pytest.raises(WrongRequest) as refused:
        table.say(blue, message)
    assert refused.value.code == code
    assert pings(red) == []


def test_where_pings_are_off_or_nobody_plays_none_is_shown() -> None:
    off, lobby = Table(pings=False), Table(pings=True)
    blue, _ = off.play()
    with pytest.raises(WrongRequest, match="no pings"):
        off.say(blue, m.SayPing(0))
    early, _ = lobby.pair()
    with pytest.raises(WrongRequest, match="possible in playing"):
        lobby.say(early, m.SayPing(0))
    assert pings(blue) == pings(early) == []


def test_a_flood_is_refused_and_counted_and_the_other_seat_may_ping_meanwhile(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), pings=True, limit_ticks=30)
    blue, red = table.play()
    refused = 0
    for _ in range(20):
        try:
            table.say(blue, m.SayPing(0))
        except WrongRequest as error:
            assert error.code == "ping_rate"
            refused += 1
    table.say(red, m.SayPing(1))
    assert (refused, len(pings(red))) == (18, 3)
    table.step(10)
    table.say(blue, m.SayPing(0))
    table.step(25)
    episode = read_episode(table.services.archived[0])
    counted = [(event.seat, event.detail) for event in episode.events if event.kind == "pings_refused"]
    assert counted == [(0, "18")]
    assert [event.seat for event in episode.events if event.kind == "ping"] == [0, 0, 1, 0]


def test_an_agent_sees_pings_for_two_seconds() -> None:
    table = Table(seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake", name="fake")], pings=True)
    blue = table.join(claim=1)
    table.ready(blue)
    (player,) = table.services.agents.players
    table.say(blue, m.SayPing(0, item=1))
    said_at = table.room.round.state.tick
    seen = []
    for _ in range(PING_TICKS + 2):
        table.step()
        seen.append([(ping.seat, ping.item, ping.tick) for ping in player.pings])
    assert seen == [[(0, 1, said_at + 1)]] * PING_TICKS + [[]] * 2


def test_pings_are_in_the_recording_which_verifies(tmp_path: Path) -> None:
    table = Table(services=FakeServices(folder=tmp_path), pings=True, limit_ticks=30)
    blue, red = table.play()
    table.step(3)
    table.say(blue, m.SayPing(0, item=1))
    table.push(red, 1)
    table.step(12)
    table.say(red, m.SayPing(1))
    table.step(20)
    recording = finalise(table.services.archived[0])
    assert verify(recording).identical
    told = pings(red)
    with recording.open("rb") as stream:
        topic = [each.data for _, _, each in make_reader(stream).iter_messages(topics=["/pings"])]
    shown = [outcome.ping for outcome in ping_outcomes(read_episode(recording))]
    assert [(one.tick, one.seat, one.item, one.x, one.y) for one in told] == [tuple(one) for one in shown]
    assert len(topic) == 2 and topic[0].startswith(b'{"tick":5,"seat":0,"item":1,"x":')
