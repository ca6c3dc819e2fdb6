"""Looking into agents while they play."""

import urllib.request
from types import SimpleNamespace
from typing import Any, cast

from movingout.agents.worker.messages import Answer, Open
from movingout.maps import load_map
from movingout.server.agent_workers.pool import AgentPool, AgentSeat
from movingout.server.api.agent_debug import newest
from movingout.server.rooms.room import Room
from tests.server.live import ADMIN, WAIT_S, Live

WEIGHED = {"chosen": 1, "scores": [0.1, 0.2], "candidates": [[[1.0, 1.0, 0.0]]] * 2, "items": []}


def _answered(detail: dict[str, object]) -> AgentSeat:
    seat = AgentSeat(AgentPool(0), 7, cast(Any, None), Open(7, "bass@all", load_map("Simple"), 1, 0, 100), lambda: 0.0)
    seat.take(Answer(7, 4, b"\0" * 32, 1, 1.0, detail))
    return seat


def _room(*players: AgentSeat | None) -> Room:
    return cast(Room, SimpleNamespace(seats=[SimpleNamespace(index=i, player=p) for i, p in enumerate(players)]))


def test_a_decision_is_told_once() -> None:
    room, seen = _room(None, _answered(WEIGHED)), dict[int, tuple[int, int]]()
    assert newest(room, seen) == [{"seat": 1, "tick": 4, **WEIGHED}]
    assert newest(room, seen) == []


def test_an_agent_that_weighs_nothing_is_not_told_of() -> None:
    assert newest(_room(_answered({"errand": "Fetch"}), None), {}) == []


def test_a_room_that_is_not_there_is_answered_in_a_sentence(live: Live) -> None:
    status, answer = live.call("/api/rooms/nosuchroom22/thoughts")
    assert (status, answer["error"]["message"]) == (404, "There is no such game. It may be over.")


def test_a_stream_begins_at_once_and_ends_with_its_room(live: Live) -> None:
    room = live.open_room("here", "idle")["room"]
    with urllib.request.urlopen(f"http://{live.address}/api/rooms/{room}/thoughts", timeout=WAIT_S) as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        assert stream.readline() == b": open\n"
        live.call(f"/api/admin/rooms/{room}/close", {}, token=ADMIN)
        assert stream.read().strip() == b""
