"""The tutorial: five steps that follow from the states of the world, a partner who waits, a recording that verifies."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from movingout.agents.base import EpisodeInfo
from movingout.agents.catalogue import load_agent
from movingout.agents.observation.seat_observation import observe
from movingout.maps import MapSpec
from movingout.recordings import read_episode
from movingout.recordings.storage.finished import recover_journal
from movingout.recordings.verification import verify
from movingout.server import messages as m
from movingout.server.agent_workers.agent_seat import AgentAnswer
from movingout.server.rooms import player_requests
from movingout.server.rooms.seat import AgentPlayer, Seat
from movingout.server.rooms.services import WrongRequest
from movingout.server.rooms.tutorial import STEPS, partner_seat, tutorial_map
from movingout.world.constants import TUTORIAL_TICKS
from movingout.world.ping import HelpPing
from movingout.world.state import WorldState
from tests.server.learner import Learner
from tests.server.support import Ear, FakeAgents, FakeServices, Table


class RealPlayer:
    """The agent itself, asked in the test's own process."""

    ready, failed, slow, unseen = True, "", False, ""

    def __init__(self, agent_id: str, the_map: MapSpec, seat: int, ticks: int) -> None:
        self._agent, self._map, self._seat = load_agent(agent_id), the_map, seat
        self._agent.reset(EpisodeInfo(the_map, seat, 0, ticks))
        self._seen: WorldState | None = None

    def observe(self, state: WorldState, tick: int, deadline: float, pings: tuple[HelpPing, ...] = ()) -> None:
        self._seen = state

    def answer(self, tick: int) -> AgentAnswer:
        if self._seen is None:  # it took the seat in the middle of a tick
            return AgentAnswer(np.zeros(3), True, -1.0)
        distance, cos, sin, grasp = self._agent.act(observe(self._map, self._seen, self._seat))[0].tolist()
        return AgentAnswer(np.array([distance, np.arctan2(sin, cos), grasp]), False, 1.0)

    def close(self) -> None:
        self._seen = None


class RealAgents(FakeAgents):
    def open(self, agent_id: str, map: MapSpec, seat: int, seed: int, ticks: int) -> AgentPlayer:
        return RealPlayer(agent_id, map, seat, ticks)


def tutorial(folder: Path | None = None, alone: int = 0, **config: Any) -> tuple[Table, Ear]:
    """One player and the partner, the first tick made."""
    seats = [partner_seat(0), partner_seat(1)]
    seats[alone] = Seat(alone, "human", shared=True)
    table = Table(
        "Tutorial",
        services=FakeServices(folder, RealAgents()),
        seats=seats,
        practice=True,
        tutorial=True,
        **{"limit_ticks": TUTORIAL_TICKS} | config,
    )
    ear = table.join(claim=1)
    while table.phase in ("lobby", "countdown"):
        table.step()
    return table, ear


def play(table: Table, *learners: Learner, most: int = 1500) -> None:
    for _ in range(most):
        if table.phase != "playing":
            return
        for learner in learners:
            learner.act()
        table.step()
    raise AssertionError(f"stuck in step {table.room.round.tutorial and table.room.round.tutorial.message()}")


def shown(ear: Ear) -> list[m.Tutorial]:
    return [each for each in ear.told if isinstance(each, m.Tutorial)]


@pytest.mark.parametrize("alone", [0, 1])
def test_one_player_learns_step_by_step_and_the_recording_verifies(tmp_path: Path, alone: int) -> None:
    table, ear = tutorial(tmp_path, alone)
    play(table, Learner(table, ear, alone))
    assert table.phase == "series_over"
    assert list(dict.fromkeys(each.step for each in shown(ear))) == list(STEPS)
    assert [each.number for each in shown(ear)] == [1, 2, 3, 4, 5, 5] and shown(ear)[-1].finished
    ((_, result),), (journal,) = table.services.results, table.services.archived
    assert result.outcome == "delivered"
    recording = recover_journal(journal).recording
    assert recording is not None
    episode = read_episode(recording)
    assert episode.header.source == "tutorial" and episode.header.map == tutorial_map((alone == 0, alone == 1))
    steps = [event.detail for event in episode.events if event.kind == "tutorial_step"]
    assert steps == [*STEPS[1:], "finished"]
    assert verify(recording).identical


def test_two_players_learn_together_and_each_has_an_own_part(tmp_path: Path) -> None:
    seats = [Seat(0, "human", shared=True), Seat(1, "human", shared=True)]
    table = Table("Tutorial", seats=seats, practice=True, tutorial=True, limit_ticks=TUTORIAL_TICKS)
    blue, red = table.pair()
    while table.phase in ("lobby", "countdown"):
        table.step()
    first = Learner(table, blue, 0)
    for _ in range(30):
        first.act()
        table.step()
    assert (shown(red)[-1].step, shown(red)[-1].done) == ("drive", [True, False]), "blue waits for red"
    play(table, first, Learner(table, red, 1))
    assert shown(red)[-1].finished


def test_the_partner_alone_delivers_nothing_and_ends_nothing() -> None:
    table, ear = tutorial(limit_ticks=900)
    while table.room.round.state.tick < 899:
        table.push(ear, 0, 0.0, 0.0)
        table.step()
    assert table.phase == "playing" and not any(table.room.round.delivered)
    assert [each.step for each in shown(ear)] == ["drive"]
    table.step()
    assert table.phase == "series_over" and table.services.results[0][1].outcome == "time"


def test_the_partner_takes_its_end_and_does_not_move_while_the_player_holds_still() -> None:
    table, ear = tutorial()
    learner = Learner(table, ear, 0)
    for _ in range(1500):
        learner.act()
        table.step()
        if table.room.round.state.held.tolist() == [1, 1]:
            break
    held_at = table.room.round.state.item_poses[1].copy()
    for _ in range(100):
        table.push(ear, 0, 0.0, 0.0, learner.grabs)
        table.step()
    moved = table.room.round.state.item_poses[1] - held_at
    assert float(np.hypot(*moved[:2])) < 0.05 and not table.room.round.delivered[1]


def test_a_skipped_tutorial_is_recorded_with_the_step(tmp_path: Path) -> None:
    table, ear = tutorial(tmp_path)
    table.say(ear, m.Skip(0))
    assert table.phase == "series_over" and table.services.results[0][1].outcome == "stopped"
    episode = read_episode(table.services.archived[0])
    assert [(event.kind, event.seat, event.detail) for event in episode.events if "tutorial" in event.kind] == [
        ("tutorial_skipped", 0, "drive")
    ]


def test_only_a_tutorial_can_be_skipped() -> None:
    table = Table("Simple")
    blue, _ = table.play()
    with pytest.raises(WrongRequest, match="tutorial"):
        table.say(blue, m.Skip(0))


def test_again_begins_anew_with_every_item_back() -> None:
    table, ear = tutorial()
    table.say(ear, m.Skip(0))
    table.say(ear, m.Again(0))
    while table.phase != "playing":
        table.step()
    assert shown(ear)[-1].step == "drive" and table.room.round.state.tick == 1


def test_what_was_done_before_is_not_asked_again() -> None:
    """Grabbing the item on the way does not have to be repeated for the step that teaches it."""
    table, ear = tutorial()
    learner = Learner(table, ear, 0)
    while shown(ear)[-1].step != "deliver":
        learner.act()
        table.step()
    reached = table.room.round
    assert reached.tutorial is not None
    known = reached.tutorial.message()
    table.push(ear, 0, 0.0, 0.0, learner.grabs + 1)  # lets go on the way
    table.step(2)
    assert reached.tutorial.message() == known, "the step stays, its item still glows"


def test_a_player_who_has_had_enough_is_replaced_by_the_partner() -> None:
    seats = [Seat(0, "human", shared=True), Seat(1, "human", shared=True)]
    table = Table(
        "Tutorial", services=FakeServices(None, RealAgents()), seats=seats, practice=True, tutorial=True,
        limit_ticks=TUTORIAL_TICKS,
    )  # fmt: skip
    blue, _ = table.pair()
    while table.phase in ("lobby", "countdown"):
        table.step()
    table.step(20)
    player_requests.retire(table.room, table.seats[1], table.now)
    assert table.seats[1].kind == "agent"
    play(table, Learner(table, blue, 0))
    assert shown(blue)[-1].finished
