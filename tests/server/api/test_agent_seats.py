"""Agents that strangers seat: never alone, at most half of them for one address, and none that a study needs."""

from pathlib import Path
from typing import Any

import pytest

from movingout.server.settings import Settings
from tests.server.live import ADMIN, Live, limits, serve

ELSEWHERE = ("10.9.9.9",)  # a proxy: whoever comes may be a stranger


def ask(live: Live, *seats: dict[str, str], token: str = "") -> tuple[int, str]:
    status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": list(seats)}, token=token)
    return status, answer.get("error", {}).get("code", "")


HERE, BASS = {"kind": "here"}, {"kind": "agent", "agent": "bass@all"}


def test_strangers_let_no_agents_play_alone_and_the_operator_does(tmp_path: Path) -> None:
    with serve(tmp_path, limits(), trusted_proxies=ELSEWHERE) as live:
        assert ask(live, BASS, BASS) == (403, "agents_only")
        assert ask(live, BASS, {"kind": "agent", "agent": "idle"}) == (403, "agents_only")
        assert not live.rooms
        assert ask(live, BASS, {"kind": "agent", "agent": "idle"}, token=ADMIN) == (200, "")


def test_on_a_server_for_this_machine_alone_one_may_watch_agents(live: Live) -> None:
    scripted = {"kind": "agent", "agent": "scripted"}
    assert ask(live, scripted, scripted)[0] == 200


@pytest.mark.parametrize("agent", ["scripted\n", " scripted", "scripted\u3000"])
def test_an_agent_whose_id_has_spaces_around_it_is_the_same_agent(live: Live, agent: str) -> None:
    """It was recorded as another one, and its costs and faults were not counted with those of the agent."""
    status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": [HERE, {"kind": "agent", "agent": agent}]})
    assert status == 200
    room = next(one for one in live.rooms if one.id == answer["room"])
    assert [seat.agent_id for seat in room.seats] == ["", "scripted"]


def test_behind_a_forgotten_proxy_whoever_comes_may_be_a_stranger(tmp_path: Path) -> None:
    with serve(tmp_path, limits(), allowed_hosts=("game.example.org",)) as live:
        assert ask(live, BASS, BASS) == (403, "agents_only")


@pytest.mark.parametrize(
    ("settings", "private"),
    [
        ({}, True),
        ({"host": "::1", "allowed_hosts": ("game.localhost", "127.0.0.1"), "origins": ("http://[::1]:5173",)}, True),
        ({"allowed_hosts": ("localhost", "game.example.org")}, False),
        ({"origins": ("https://game.example.org",)}, False),
        ({"trusted_proxies": ("127.0.0.1",)}, False),
        ({"host": "0.0.0.0"}, False),
    ],
)
def test_a_server_with_a_name_elsewhere_is_not_for_this_machine_alone(settings: dict[str, Any], private: bool) -> None:
    assert Settings(**settings).private == private


def test_one_address_takes_at_most_half_of_the_agents(tmp_path: Path) -> None:
    with serve(tmp_path, limits(unjoined_rooms_per_address=50), trusted_proxies=ELSEWHERE) as live:
        live.host.agents._most = 0.8
        live.host.agents.costs.measured("bass@all", 0.1)
        assert [ask(live, HERE, BASS)[0] for _ in range(5)] == [200] * 4 + [429]
        assert ask(live, HERE, BASS)[1] == "too_many_agents"
        assert ask(live, HERE, HERE)[0] == 200


def test_rooms_beside_a_study_leave_its_participants_their_agents(tmp_path: Path) -> None:
    with serve(tmp_path, limits(), lobby=False) as live:
        live.host.agents._most = 0.8
        live.host.agents.costs.measured("bass@all", 0.15)
        assert [ask(live, HERE, BASS, token=ADMIN)[0] for _ in range(3)] == [200, 200, 503]


def test_a_tutorial_counts_as_a_room_of_its_address(tmp_path: Path) -> None:
    with serve(tmp_path, limits(unjoined_rooms_per_address=2)) as live:
        assert [live.call("/api/rooms", {"tutorial": True})[0] for _ in range(3)] == [200, 200, 429]
