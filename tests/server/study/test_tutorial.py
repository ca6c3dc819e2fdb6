"""The tutorial as the practice of a study."""

from pathlib import Path

import pytest

from movingout.recordings import read_episode
from movingout.recordings.storage.listing import recording_paths
from movingout.study.store.tables import rounds
from tests.server.study.support import PAIR, SOLO, Served, Visitor, served

TUTORIAL = "practice: tutorial"
ALONE = SOLO.replace("practice: {map: Simple, limit_ticks: 20, agent: idle}", TUTORIAL)
TOGETHER = PAIR.replace("practice: {map: Simple, limit_ticks: 30}", TUTORIAL)


def playing(visitor: Visitor) -> Visitor:
    visitor.go_to("practice")
    visitor.next()
    visitor.wait_until(lambda one: one.step.get("state") == "playing")
    return visitor


def skipped(study: Served, pid: str) -> list[tuple[str, str]]:
    """Who skipped a tutorial, and at which step, from the recordings."""
    study.live.run(lambda: None)
    episodes = [read_episode(path) for path in recording_paths(study.folder.recordings)]
    assert {episode.header.source for episode in episodes} == {"tutorial"}
    assert {episode.header.study["step"] for episode in episodes} == {"practice"}
    return [
        (episode.header.seats[event.seat].name, event.detail)
        for episode in episodes
        for event in episode.events
        if event.kind == "tutorial_skipped"
    ]


@pytest.mark.slow
def test_a_participant_who_skips_the_tutorial_goes_on_and_that_is_recorded(tmp_path: Path) -> None:
    with served(tmp_path, ALONE, agent_workers=1) as study:
        visitor = playing(study.visitor())
        assert visitor.step["tutorial"] and visitor.step["map"]["name"] == "Tutorial"
        person = visitor.player()
        seat = visitor.step["room"]["seat"]
        person.next_tick(seat)
        visitor.next(done=True)
        assert visitor.kind == "round" and visitor.step["tutorial"] is False
        assert skipped(study, visitor.pid) == [(visitor.pid, "drive")]
        assert study.running.databases.store.rows(rounds) == [], "a tutorial is no round of the study"


@pytest.mark.slow
def test_whoever_stays_in_a_pair_goes_on_with_the_waiting_partner(tmp_path: Path) -> None:
    with served(tmp_path, TOGETHER, agent_workers=1) as study:
        first, second = study.visitor(), study.visitor()
        for visitor in (first, second):
            visitor.agree()
            visitor.do()
        first, second = first.go_to("practice"), second.go_to("practice")
        first.next()
        second.next()
        first.look()
        players = [first.player(), second.player()]
        seat = second.step["room"]["seat"]
        players[1].next_tick(seat)
        first.next(done=True)
        (room,) = [room for room in study.live.rooms if room.config.tutorial]
        assert sorted(one.kind for one in room.seats) == ["agent", "human"]
        tick = players[1].next_tick(seat)
        assert players[1].next_tick(seat) > tick
