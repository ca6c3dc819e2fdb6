"""Looking into agents while they play."""

import contextlib
import time
import urllib.error
import urllib.request
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from movingout.agents.decision_trace import MAX_PLAN
from movingout.agents.worker.messages import Answer, Open
from movingout.maps import load_map
from movingout.server.agent_workers.agent_seat import AgentSeat
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.api.agent_debug import STREAMS_OF_ADDRESS, newest, weighs
from movingout.server.rooms.room import Room
from tests.server.live import ADMIN, WAIT_S, Live, serve

WEIGHED = {"chosen": 1, "scores": [0.1, 0.2], "candidates": [[[1.0, 1.0, 0.0]]] * 2, "items": []}


def _answered(*details: dict[str, object]) -> AgentSeat:
    seat = AgentSeat(AgentPool(0), 7, cast(Any, None), Open(7, "bass@all", load_map("Simple"), 1, 0, 100), lambda: 0.0)
    for tick, detail in enumerate(details, start=4):
        seat.take(Answer(7, tick, b"\0" * 32, 1, 1.0, detail))
    return seat


def _room(*players: AgentSeat | None, study: dict[str, str] | None = None) -> Room:
    seats = [SimpleNamespace(index=i, player=p) for i, p in enumerate(players)]
    return cast(Room, SimpleNamespace(seats=seats, config=SimpleNamespace(study=study or {})))


def test_a_decision_is_told_once() -> None:
    room, seen = _room(None, _answered(WEIGHED)), dict[int, tuple[int, int]]()
    found, seen = newest(room, seen)
    assert found == [{"seat": 1, "tick": 4, **WEIGHED}]
    assert newest(room, seen) == ([], seen)


def test_a_plan_is_told_and_nothing_of_how_it_was_asked_for() -> None:
    found, _ = newest(_room(_answered({"plan": "I wait. " * 100, "prompt": "You are", "errand": "Stay"})), {})
    assert found == [{"seat": 0, "tick": 4, "plan": ("I wait. " * 100)[:MAX_PLAN]}]


def test_an_agent_that_weighs_nothing_is_not_told_of() -> None:
    assert newest(_room(_answered({"errand": "Fetch", "plan": ""}), None), {}) == ([], {})


def test_an_agent_that_decides_every_second_tick_weighs_whenever_it_is_asked() -> None:
    assert weighs(_room(_answered(WEIGHED, {}), None))  # the second decision goes on with the first
    assert not weighs(_room(_answered({}, {"errand": "Fetch"}), None))


def test_nobody_in_a_study_hears_that_an_agent_weighs() -> None:
    assert not weighs(_room(_answered(WEIGHED), study={"study": "one"}))


def test_a_room_that_is_not_there_is_answered_in_a_sentence(live: Live) -> None:
    status, answer = live.call("/api/rooms/nosuchroom22/thoughts")
    assert (status, answer["error"]["message"]) == (404, "This room no longer exists. Start a new game.")


def test_a_stream_begins_at_once_and_ends_with_its_room(live: Live) -> None:
    room = live.open_room("here", "idle")["room"]
    with urllib.request.urlopen(f"http://{live.address}/api/rooms/{room}/thoughts", timeout=WAIT_S) as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        assert stream.readline() == b": open\n"
        live.call(f"/api/admin/rooms/{room}/close", {}, token=ADMIN)
        assert stream.read().strip() == b""


def test_one_address_leaves_streams_to_others_and_gets_its_own_back(tmp_path: Path) -> None:
    with serve(tmp_path, trusted_proxies=("127.0.0.1",)) as live, contextlib.ExitStack() as open_ones:
        room = live.open_room("here", "idle")["room"]

        def status(address: str) -> int:
            request = urllib.request.Request(f"http://{live.address}/api/rooms/{room}/thoughts")
            request.add_header("X-Forwarded-For", address)
            try:
                open_ones.enter_context(urllib.request.urlopen(request, timeout=WAIT_S))
            except urllib.error.HTTPError as error:
                with error:
                    return error.code
            return 200

        assert [status("192.0.2.1") for _ in range(8)] == [200] * STREAMS_OF_ADDRESS + [503] * 2
        assert status("192.0.2.2") == 200
        open_ones.close()
        deadline = time.monotonic() + WAIT_S
        while status("192.0.2.1") != 200:  # the server hears of it in a moment
            assert time.monotonic() < deadline
