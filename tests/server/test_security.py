"""The threat table, who may: foreign pages, tokens, the administrator, addresses, logs. Numbers are its rows."""

import json
import logging
import socket
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from movingout.server import messages as m
from movingout.server.api import routes
from movingout.server.host import Host
from movingout.server.rooms import room_view
from movingout.server.rooms.seat import Seat
from movingout.server.rooms.time_limits import UNJOINED_S
from movingout.server.settings import Limits, Settings
from tests.server.live import ADMIN, Live, limits, serve
from tests.server.processes.cluster import cluster
from tests.server.support import Table
from tests.server.threats import close_code, player

pytestmark = pytest.mark.slow

# ---- 1 Origin -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "http://[bad",
        "https://127.0.0.1:{port}",
        "http://127.0.0.1:1",
        "http://localhost:{port}",
    ],
)
def test_1_a_foreign_page_gets_no_socket_and_no_room(live: Live, origin: str, caplog: pytest.LogCaptureFixture) -> None:
    origin = origin.format(port=live.port)
    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://{live.address}/ws", subprotocols=[m.SUBPROTOCOL], origin=origin)  # type: ignore[list-item, arg-type]
    assert refused.value.response.status_code == 403
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]
    status, answer = live.call("/api/rooms", {"maps": ["Simple"], "seats": []}, Origin=origin)
    assert (status, answer["error"]["code"]) == (403, "origin")


def test_1_the_servers_own_page_and_programs_without_origin_are_let_in(live: Live) -> None:
    own = f"http://{live.address}"
    connect(f"ws://{live.address}/ws", subprotocols=[m.SUBPROTOCOL], origin=own).close()  # type: ignore[list-item, arg-type]
    live.connect()


# ---- 2 seats --------------------------------------------------------------------------------------------------


def test_2_a_token_of_another_room_a_cut_one_and_an_old_one_are_refused(live: Live) -> None:
    first, second = live.open_room("here", "idle"), live.open_room("here", "idle")
    token, other = first["tokens"][0], second["tokens"][0]
    for wrong in (other, token[:-1], token + "x", "", "x" * 22):
        connection = live.connect()
        connection.send(json.dumps({"type": "join", "room": first["room"], "tokens": [wrong]}))
        assert close_code(connection) == m.CLOSE_UNAUTHORISED
    person = live.person(first["room"], tokens=[token])
    person.say(type="keyframe")
    person.wait_for("keyframe")
    connection = live.connect()
    connection.send(json.dumps({"type": "join", "room": first["room"], "tokens": [token]}))
    assert close_code(connection) == m.CLOSE_UNAUTHORISED


def test_2_guessing_is_locked_out_after_ten_tries_and_the_right_key_always_passes(tmp_path: Path) -> None:
    with serve(tmp_path, limits(wrong_tokens_per_minute=10)) as live:
        room = live.open_room("here", "idle")
        for count in range(12):
            connection = live.connect()
            connection.send(json.dumps({"type": "join", "room": room["room"], "tokens": ["guess"]}))
            assert ("wait a minute" in json.loads(connection.recv(10))["message"]) == (count >= 10)
        assert live.person(room["room"], tokens=room["tokens"][:1]).tokens, "somebody else at this address"
        found = [live.call("/api/admin/state", token="guess") for _ in range(12)]
        assert [status for status, _ in found] == [403] * 10 + [429] * 2
        assert found[-1][1]["error"]["code"] == "locked"
        assert live.call("/api/admin/state", token=ADMIN)[0] == 200


def test_2_an_older_key_of_the_own_seat_is_no_guess(tmp_path: Path) -> None:
    with serve(tmp_path, limits(wrong_tokens_per_minute=2)) as live:
        room = live.open_room("here", "idle")
        person = live.person(room["room"], tokens=room["tokens"][:1])
        person.say(type="keyframe")
        person.wait_for("keyframe")
        for _ in range(6):  # a tab that was left open tries to come back
            connection = live.connect()
            connection.send(json.dumps({"type": "join", "room": room["room"], "tokens": room["tokens"][:1]}))
            assert "no longer valid" in json.loads(connection.recv(10))["message"]


# ---- 3 rooms ----------------------------------------------------------------------------------------------------


SEATS = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]}


def test_3_rooms_that_nobody_joins_do_not_fill_the_server(tmp_path: Path) -> None:
    with serve(tmp_path, limits(unjoined_rooms_per_address=2)) as live:
        first, _ = live.open_room("here", "idle"), live.open_room("here", "idle")
        status, answer = live.call("/api/rooms", SEATS)
        assert (status, answer["error"]["code"]) == (429, "rooms_unjoined")
        live.person(first["room"], tokens=first["tokens"][:1])
        assert live.call("/api/rooms", SEATS)[0] == 200, "who plays may open another one"


def test_3_a_room_left_behind_gives_way_to_another_one_of_the_same_address(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serve(tmp_path, limits(open_rooms_per_address=2)) as live:
        kept, left = live.open_room("here", "idle"), live.open_room("here", "idle")
        live.person(kept["room"], tokens=kept["tokens"][:1])
        live.person(left["room"], tokens=left["tokens"][:1]).connection.close()
        status, answer = live.call("/api/rooms", SEATS)
        assert (status, answer["error"]["code"]) == (429, "rooms_open"), "whoever left may come back for a while"
        monkeypatch.setattr(room_view, "LEFT_BEHIND_S", 0.0)
        opened = live.call("/api/rooms", SEATS)[1]["room"]
        assert {room.id for room in live.rooms} == {kept["room"], opened}


def test_3_the_last_rooms_are_kept_for_the_operator(tmp_path: Path) -> None:
    with serve(tmp_path, limits(unjoined_rooms_per_address=50, rooms=20, rooms_for_operator=2)) as live:
        assert [live.call("/api/rooms", SEATS)[0] for _ in range(19)] == [200] * 18 + [503]
        assert [live.call("/api/rooms", SEATS, token=ADMIN)[0] for _ in range(3)] == [200, 200, 503]


@pytest.mark.parametrize("served", [serve, cluster], ids=["one process", "two"])
def test_3_the_admin_closes_all_rooms_of_an_address_and_no_other(
    tmp_path: Path, served: Callable[..., AbstractContextManager[Live]]
) -> None:
    with served(tmp_path, trusted_proxies=("127.0.0.1",)) as live:
        flooded = [live.call("/api/rooms", SEATS, **{"X-Forwarded-For": "192.0.2.7"})[1]["room"] for _ in range(3)]
        other = live.call("/api/rooms", SEATS, **{"X-Forwarded-For": "192.0.2.8"})[1]["room"]
        mine = live.call("/api/rooms", SEATS, token=ADMIN)[1]["room"]
        path = f"/api/admin/rooms/{flooded[0]}/close-address"
        assert live.call(path, {})[0] == 401
        found = {row["room"]: row["rooms_of_address"] for row in live.call("/api/admin/state", token=ADMIN)[1]["rooms"]}
        assert found == dict.fromkeys(flooded, 3) | {other: 1, mine: 0}
        assert live.call(path, {}, token=ADMIN) == (200, {"closed": 3})
        left = {row["room"] for row in live.call("/api/admin/state", token=ADMIN)[1]["rooms"]}
        assert left == {other, mine}
        assert live.call(path, {}, token=ADMIN)[0] == 404


def test_3_a_room_that_its_own_page_never_joined_closes_soon() -> None:
    for seats, closed in (
        ([Seat(0, "human"), Seat(1, "idle")], True),
        ([Seat(0, "human", shared=True), Seat(1, "human", shared=True)], False),  # friends have the link
    ):
        table = Table(seats=seats)
        table.seconds(UNJOINED_S + 1)
        assert (table.phase == "closed") == closed


def test_2_tokens_are_kept_as_hashes_only(live: Live) -> None:
    person = player(live)
    live.run(live.host.store.flush)
    kept = "".join(path.read_text() for path in live.host.settings.rooms.glob("*.json"))
    assert kept and person.tokens[0] not in kept


# ---- 3 administration -----------------------------------------------------------------------------------------


def test_3_every_admin_route_wants_the_admin_token(live: Live) -> None:
    token = player(live).tokens[0]
    app_routes = [route for route in _routes(live) if isinstance(route, APIRoute)]
    admin = [route for route in app_routes if route.path.startswith("/api/admin") or route.path == "/api/recordings"]
    assert len(admin) >= 4
    for route in admin:
        for method in route.methods or ():
            path = route.path.replace("{room_id}", "x")
            assert live.call(path, method=method)[0] == 401
            assert live.call(path, method=method, token=token)[0] == 403
    assert live.call("/api/admin/state", token=ADMIN)[0] == 200


def _routes(live: Live) -> list[object]:
    """All routes of a fresh application, included ones flattened."""
    app = FastAPI()
    routes.install(app, live.host)
    found: list[object] = []
    waiting = list(app.router.routes)
    while waiting:
        route = waiting.pop()
        found.append(route)
        inner = getattr(route, "original_router", None) or getattr(route, "router", None)
        waiting.extend(getattr(inner, "routes", []))
    return found


def test_3_a_server_that_is_given_no_admin_token_makes_one_and_loopback_is_the_default() -> None:
    assert Settings().host == "127.0.0.1"
    first, second = Host(Settings()), Host(Settings())
    assert first.admin_token != second.admin_token and len(first.admin_token) >= 20


# ---- 14, 15 addresses and logs --------------------------------------------------------------------------------


def test_14_a_spoofed_forwarded_address_is_not_believed(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms_per_address_per_minute=2)) as live:
        body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]}
        answers = [live.call("/api/rooms", body, X_Forwarded_For=f"10.0.0.{count}")[0] for count in range(3)]
    assert answers == [200, 200, 429]


def test_14_a_trusted_proxy_is_believed(tmp_path: Path) -> None:
    with serve(tmp_path, limits(rooms_per_address_per_minute=2), trusted_proxies=("127.0.0.1",)) as live:
        body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}]}
        answers = [live.call("/api/rooms", body, X_Forwarded_For=f"10.0.0.{count}")[0] for count in range(3)]
    assert answers == [200, 200, 200]


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="IPv4 and IPv6 have sockets of their own here")
@pytest.mark.parametrize("proxy", ["127.0.0.1", "127.0.0.0/8"])
def test_14_a_proxy_is_believed_where_ipv4_comes_as_ipv6(tmp_path: Path, proxy: str) -> None:
    with serve(tmp_path, limits(rooms_per_address_per_minute=2), trusted_proxies=(proxy,), host="::") as live:
        headers = {"X-Forwarded-Proto": "https", "Origin": f"https://{live.address}"}
        found = [live.call("/api/rooms", SEATS, **headers, X_Forwarded_For=f"10.0.0.{count}")[0] for count in range(3)]
    assert found == [200, 200, 200]


def test_15_no_token_is_logged_and_none_is_in_an_address(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    caplog.set_level(logging.DEBUG)
    caplog.set_level(logging.INFO, logger="websockets")  # the test's own client logs what it sends
    with serve(tmp_path) as live:
        room = live.open_room("here", "idle", limit_ticks=10)
        person = live.person(room["room"], tokens=[room["tokens"][0]])
        person.say(type="ready", seat=0)
        person.wait_for("result")
        live.call("/api/admin/state", token=ADMIN)
        live.call(f"/api/rooms/{room['room']}/answers", token=person.tokens[0])
        secrets = [ADMIN, room["tokens"][0], *person.tokens]
        assert not any(secret in room["join_path"] + room["watch_path"] for secret in secrets)
    logged = "\n".join(record.getMessage() for record in caplog.records)
    printed = "".join(capfd.readouterr())
    assert not [secret for secret in secrets if secret in logged + printed]


# ---- 16, 17 models and people ---------------------------------------------------------------------------------


@pytest.mark.parametrize("agent", ["os:system", "subprocess:run", "tests.x:y", "unknown", "", "scripted;x"])
def test_16_nobody_imports_code_through_an_agents_name(live: Live, agent: str) -> None:
    body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": agent}]}
    status, answer = live.call("/api/rooms", body)
    assert (status, answer["error"]["code"]) == (422, "unknown_agent")
    assert "known: scripted" in answer["error"]["message"]


def test_17_recordings_hold_pseudonyms_and_no_nickname(live: Live) -> None:
    room = live.open_room("here", "link", limit_ticks=10)
    blue = live.person(room["room"], tokens=[room["tokens"][0]], name="Ada Lovelace")
    red = live.person(room["room"], claim=1, name="Grace Hopper")
    blue.say(type="ready", seat=0)
    red.say(type="ready", seat=1)
    recording = blue.wait_for("result")["recording"]
    _, summary = live.call(f"/api/recordings/{recording}")
    names = [seat["name"] for seat in summary["seats"]]
    assert all(name.startswith("person-") for name in names)
    _, file = live.call(f"/api/recordings/{recording}/file")
    assert b"Ada" not in json.dumps(summary).encode() + file and b"Hopper" not in file


def test_defaults_are_the_tables_numbers() -> None:
    assert Limits().frame_bytes == 4096
    assert (Limits().join_s, Limits().header_s) == (5.0, 10.0)
    assert (Limits().messages_per_s, Limits().message_burst) == (60.0, 60.0)
