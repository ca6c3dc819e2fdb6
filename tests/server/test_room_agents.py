"""Agents in a room: asked in time, waited for while they load, replaced by rest when they are late."""

import pytest

from server import messages as m
from server.seats import Seat
from tests.server.support import TICK, Table


def agent_table() -> Table:
    return Table(seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake", name="fake")])


def test_an_agent_is_asked_about_the_state_it_acts_on_until_the_next_tick() -> None:
    table = agent_table()
    blue = table.join(claim=1)
    table.ready(blue)
    (player,) = table.services.agents.players
    table.step(2)
    assert [tick for tick, _ in player.observed] == [0, 1, 2, 3]
    assert player.observed[-1][1] == pytest.approx(table.now + TICK)
    y = [bundle.poses[-1, 1, 1] for bundle in blue.bundles]
    assert y == sorted(y) and y[-1] > y[0], "red drives as the agent says"


def test_the_game_waits_for_an_agent_that_still_loads() -> None:
    table = agent_table()
    blue = table.join(claim=1)
    (player,) = table.services.agents.players
    player.ready = False
    table.say(blue, m.Ready(0))
    table.seconds(3)
    assert table.phase == "lobby"
    player.ready = True
    table.step()
    assert table.phase == "countdown"


def test_the_countdown_to_the_next_round_waits_for_its_fresh_agent_but_not_for_ever() -> None:
    table = Table("Simple", "HandOff", seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake")], limit_ticks=10)
    blue = table.join(claim=1)
    table.ready(blue)
    table.step(12)
    table.services.agents.slow = True
    table.say(blue, m.Ready(0))
    table.seconds(5)
    assert table.phase == "countdown"
    table.seconds(8.6)
    assert table.phase == "playing"


def test_an_agent_is_free_for_other_rooms_while_nobody_is_in_the_lobby_and_comes_back_with_the_first() -> None:
    table = agent_table()
    (player,) = table.services.agents.players
    table.seconds(59)
    assert not player.closed
    table.seconds(2)
    assert player.closed
    table.join(claim=1)
    assert [each.closed for each in table.services.agents.players] == [True, False]


def test_a_missed_deadline_is_neutral_counted_and_shown() -> None:
    table = agent_table()
    blue = table.join(claim=1)
    table.ready(blue)
    (player,) = table.services.agents.players
    player.asleep = True
    player.problem = "the worker died"
    table.step()
    assert [event.kind for event in blue.bundles[-1].events] == ["deadline_missed", "agent_error"]
    assert table.room.round.deadline_misses == 1
    assert table.phase == "playing"


def test_agents_play_among_themselves_only_while_somebody_looks_on() -> None:
    table = Table(seats=[Seat(0, "agent", "fake"), Seat(1, "idle")])
    table.seconds(5)
    assert table.phase == "lobby"
    table.join(mode="watch")
    table.seconds(4)
    assert table.phase == "playing"


def test_every_round_has_a_fresh_agent() -> None:
    table = Table("Simple", "HandOff", seats=[Seat(0, "human", shared=True), Seat(1, "agent", "fake")], limit_ticks=10)
    blue = table.join(claim=1)
    table.ready(blue)
    table.step(12)
    table.ready(blue)
    first, second = table.services.agents.players
    assert first.closed and not second.closed
