"""Who plays where nobody chose a partner: the trained one, and the scripted one where it cannot."""

from pathlib import Path
from typing import Any

import pytest

from movingout.agents.errors import CheckpointError
from movingout.maps import load_map, map_to_json
from movingout.server.api import proposed_partner as proposed
from movingout.server.settings import PARTNER
from tests.server.live import ADMIN, Live, limits, serve

LEFT_OPEN = [{"kind": "here"}, {"kind": "partner"}]


def opened(live: Live, token: str = "") -> tuple[int, str]:
    """The status, and who then sits opposite."""
    status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": LEFT_OPEN}, token=token)
    return status, next((room.seats[1].agent_id for room in live.rooms if room.id == answer.get("room")), "")


def test_a_seat_that_is_left_to_the_server_has_the_trained_partner(live: Live) -> None:
    assert opened(live) == (200, PARTNER)


@pytest.mark.parametrize(
    ("seat", "right"),
    [
        ({"kind": "partner", "agent": "scripted"}, "agent"),
        ({"kind": "here", "agent": "scripted"}, "agent"),
        ({"kind": "ghost", "recording": "x", "agent": "scripted"}, "agent"),
        ({"kind": "partner", "recording": "x"}, "ghost"),
    ],
)
@pytest.mark.parametrize("tutorial", [False, True])
def test_a_seat_that_names_what_its_kind_leaves_unread_is_refused(
    live: Live, seat: dict[str, str], right: str, tutorial: bool
) -> None:
    asked = {"maps": [] if tutorial else ["Simple"], "seats": [{"kind": "here"}, seat], "tutorial": tutorial}
    before = len(live.rooms)
    status, answer = live.call("/api/rooms", asked)
    assert (status, answer["error"]["code"]) == (422, "seat_kind")
    assert f"write kind '{right}'" in answer["error"]["message"]
    assert len(live.rooms) == before


def test_the_scripted_one_plays_while_agents_have_no_capacity_left(tmp_path: Path) -> None:
    with serve(tmp_path, limits()) as live:
        live.host.agents._most = 0.25
        live.host.agents.costs.measured(PARTNER, 0.2)
        live.host.agents.costs.measured("scripted", 0.01)
        assert opened(live) == (200, PARTNER)
        assert opened(live) == (200, "scripted")
        chosen = [{"kind": "here"}, {"kind": "agent", "agent": PARTNER}]
        status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": chosen})
        assert (status, answer["error"]["code"]) == (503, "no_agent")  # whoever chose it chooses again


def test_the_scripted_one_plays_where_a_study_needs_the_agents(tmp_path: Path) -> None:
    with serve(tmp_path, limits(), lobby=False) as live:
        live.host.agents._most = 0.3
        live.host.agents.costs.measured(PARTNER, 0.2)
        live.host.agents.costs.measured("scripted", 0.01)
        assert opened(live, token=ADMIN) == (200, "scripted")


@pytest.mark.parametrize("missing", ["weights", "runtime"])
def test_the_scripted_one_is_proposed_where_the_trained_one_does_not_run(
    live: Live, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    def damaged(agent_id: str) -> None:
        raise CheckpointError(f"{agent_id} is damaged")

    if missing == "weights":
        monkeypatch.setattr(proposed, "agent_card", damaged)
    else:
        monkeypatch.setattr(proposed, "RUNTIME", "no_such_runtime")
    assert live.call("/api/agents")[1]["default"] == "scripted"
    assert opened(live) == (200, "scripted")


@pytest.mark.slow
def test_nobody_plays_instead_of_whom_the_operator_names(tmp_path: Path) -> None:
    with serve(tmp_path, limits(), partner="dp@any") as live:
        live.host.agents._most = 0.25
        live.host.agents.costs.measured("dp@any", 0.2)
        assert opened(live) == (200, "dp@any")
        assert opened(live) == (503, "")


def five_goals() -> dict[str, Any]:
    """A drawn map with a goal more than trained agents see."""
    goals = [{"x0": x, "y0": 1.2, "x1": x + 0.35, "y1": 0.8} for x in (-1.2, -0.75, -0.3, 0.15, 0.6)]
    return map_to_json(load_map("Simple")) | {"name": "Five", "title": "Five", "goals": goals}


@pytest.mark.parametrize("agent", [PARTNER, "bass@any:sub_steps=20", "dp@all"])
def test_an_agent_that_does_not_see_all_of_a_drawn_map_is_refused(live: Live, agent: str) -> None:
    seats = [{"kind": "here"}, {"kind": "agent", "agent": agent}]
    before = len(live.rooms)
    status, answer = live.call("/api/rooms", {"map": five_goals(), "seats": seats})
    assert (status, answer["error"]["code"]) == (422, "agent_map")
    assert "4 slots for goals; Five has 5" in answer["error"]["message"]
    assert len(live.rooms) == before


def test_the_scripted_one_plays_on_a_map_that_the_trained_one_does_not_see(live: Live) -> None:
    status, answer = live.call("/api/rooms", {"map": five_goals(), "seats": LEFT_OPEN})
    room = next(room for room in live.rooms if room.id == answer["room"])
    assert (status, room.seats[1].agent_id) == (200, "scripted")


@pytest.mark.parametrize(
    ("agent", "why"),
    [
        ("scripted:seed=" + "9" * 5000, "up to 400 letters"),
        ("bass@any:partner=x", "partner=policy or"),
        ("scripted:speed=3", "no habit 'speed'"),
        ("dp@any:a", "key=value"),
    ],
)
def test_options_that_an_agent_does_not_take_open_no_room(live: Live, agent: str, why: str) -> None:
    """They opened one, in which people waited for a countdown that ended with the refusal."""
    before = len(live.rooms)
    seats = [{"kind": "link"}, {"kind": "agent", "agent": agent}]
    status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": seats})
    assert (status, answer["error"]["code"], answer["error"]["values"]) == (
        422,
        "agent_options",
        {"agent": agent if len(agent) < 50 else f"{agent[:40]}…"},
    )
    assert why in answer["error"]["message"]
    assert len(live.rooms) == before
