"""Agents in a room: asked in time, waited for while they load, replaced by rest when they are late."""

from pathlib import Path

import pytest

from movingout.recordings import read_episode
from movingout.server import messages as m
from movingout.server.rooms.seat import Seat
from tests.server.support import TICK, Ear, FakeServices, Table


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


def unseen_table(tmp_path: Path, **config: str) -> tuple[Table, Ear]:
    """A round that has begun with an agent on a map that it was not trained on."""
    services = FakeServices(folder=tmp_path)
    services.agents.unseen = "fake@x has never seen the map Simple: it was trained on HandOff."
    table = Table(services=services, seats=[Seat(0, "human", shared=True), Seat(1, "agent", "idle", name="fake")],
                  limit_ticks=10, **config)  # fmt: skip
    blue = table.join(claim=1)
    table.ready(blue)
    return table, blue


def test_on_a_map_an_agent_never_saw_the_room_says_so_plays_on_and_records_it(tmp_path: Path) -> None:
    table, blue = unseen_table(tmp_path)
    sentence = table.services.agents.unseen
    assert sentence in [
        told.reason for told in blue.told if isinstance(told, m.RoomState) and told.phase == "countdown"
    ]
    table.step(12)
    episode = read_episode(table.services.archived[0])
    assert [(event.seat, event.detail) for event in episode.events if event.kind == "unseen_map"] == [(1, sentence)]
    assert len(episode.ticks) == 10


def test_in_a_study_participants_are_not_told_what_their_partner_was_trained_on(tmp_path: Path) -> None:
    table, blue = unseen_table(tmp_path, study={"unit": "1"})  # type: ignore[arg-type]
    assert not [told for told in blue.told if isinstance(told, m.RoomState) and "never seen" in told.reason]
    assert table.seats[1].agent_caution  # the experimenter is


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
