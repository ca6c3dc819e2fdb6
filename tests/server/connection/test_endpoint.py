"""The conversation over real sockets, as docs/protocol.md tells it."""

import json
import time
from pathlib import Path

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from movingout.recordings import read_episode, verify
from movingout.server import messages as m
from movingout.server.connection.client_connection import STATES_S
from movingout.server.frames import Ping, Pong
from tests.server.live import Live, Person, serve


def two_people(live: Live, **config: object) -> tuple[str, Person, Person]:
    room = live.open_room("here", "link", **config)  # type: ignore[arg-type]
    blue = live.person(room["room"], tokens=[room["tokens"][0]])
    red = live.person(room["room"], claim=1, name="Ana")
    return room["room"], blue, red


def start(*people: tuple[Person, int]) -> None:
    for person, seat in people:
        person.say(type="ready", seat=seat)
    for person, _ in people:
        person.wait_for("room", phase="playing")


def test_two_people_play_a_round_and_its_recording_is_exact(live: Live) -> None:
    room, blue, red = two_people(live, limit_ticks=12)
    start((blue, 0), (red, 1))
    assert [(blue.next_tick(), red.next_tick(1)) for _ in range(12)] == [(tick, tick) for tick in range(1, 13)]
    result = blue.wait_for("result")
    assert (result["outcome"], result["ticks"], result["items"]) == ("time", 12, 3)
    status, summary = live.call(f"/api/recordings/{result['recording']}")
    assert (status, summary["ticks"], summary["outcome"], summary["exact"]) == (200, 12, "time", True)
    path = live.host.settings.recordings / f"{result['recording']}.mcap"
    assert verify(path).identical
    assert len(read_episode(path).inputs) > 12
    status, poses = live.call(f"/api/recordings/{result['recording']}/poses")
    assert len(poses) == (1 + 5 * 12) * 5 * 3 * 2
    status, file = live.call(f"/api/recordings/{result['recording']}/file")
    assert file == path.read_bytes()
    status, view = live.call(f"/api/rooms/{room}")
    assert (view["phase"], view["map"]) == ("series_over", "Simple")


def test_a_ping_is_answered_with_the_servers_clock(live: Live) -> None:
    _, blue, _ = two_people(live)
    answers = []
    for sent in (1.5, 2.5):
        blue.connection.send(Ping(client_ms=sent).encode())
        while not isinstance(frame := blue.hear(), bytes):
            pass
        answers.append(Pong.decode(frame))
    assert [answer.client_ms for answer in answers] == [1.5, 2.5]
    assert 0 < answers[1].server_ms - answers[0].server_ms < 5000


def test_a_reload_comes_back_to_its_seat_and_the_old_page_is_told(live: Live) -> None:
    room, blue, red = two_people(live)
    start((blue, 0), (red, 1))
    red.play(3, seat=1)
    again = live.person(room, tokens=red.tokens)
    code, told = red.end()
    assert code == m.CLOSE_REPLACED
    assert told[-1]["type"] == "bye"
    assert again.welcome["seats"][0]["seat"] == 1
    again.push(1)
    again.wait_for("room", phase="playing")


def test_a_lost_connection_pauses_and_a_return_resumes(live: Live) -> None:
    room, blue, red = two_people(live)
    start((blue, 0), (red, 1))
    seen = blue.play(3)
    red.connection.close()
    paused = blue.wait_for("room", phase="paused")
    assert paused["reason"] == "Ana lost the connection. The game waits."
    back = live.person(room, tokens=red.tokens)
    back.wait_for("room", phase="playing")
    assert blue.play(1)[0] > seen[-1]


def test_one_socket_plays_both_seats(live: Live) -> None:
    room = live.open_room("here", "here")
    both = live.person(room["room"], tokens=room["tokens"])
    start((both, 0), (both, 1))
    both.push(0)
    both.push(1)
    both.play(2)
    assert min(both.bundles[-1].seqs) > 0


def test_a_spectator_sees_the_game(live: Live) -> None:
    room, blue, red = two_people(live)
    watcher = live.person(room, mode="watch")
    start((blue, 0), (red, 1), (watcher, 0))
    blue.play(3)
    while len(watcher.bundles) < 3:
        watcher.hear()
    assert [bundle.tick for bundle in watcher.bundles] == [1, 2, 3]


def test_a_request_that_does_not_fit_is_answered_and_the_socket_stays(live: Live) -> None:
    _, blue, _ = two_people(live)
    blue.say(type="pause", seat=0)
    problem = blue.wait_for("error")
    assert problem["code"] == "wrong_phase"
    blue.say(type="pause", seat=1)
    assert blue.wait_for("error")["code"] == "not_your_seat"
    blue.say(type="keyframe")
    assert blue.wait_for("keyframe")["tick"] == 0


def test_whoever_asks_for_the_state_all_the_time_gets_it_now_and_then(live: Live) -> None:
    _, blue, _ = two_people(live)
    blue.wait_for("keyframe")  # part of the welcome
    asked = time.monotonic()
    for _ in range(30):
        blue.say(type="keyframe")
    for _ in range(2):
        blue.wait_for("keyframe")
    assert time.monotonic() - asked >= STATES_S
    time.sleep(2 * STATES_S)
    blue.say(type="pause", seat=0)
    blue.wait_for("error")
    times = (time.monotonic() - asked) / STATES_S
    assert sum(told["type"] == "keyframe" for told in blue.told) <= 2 + times


@pytest.mark.parametrize(
    ("first", "code", "said"),
    [
        ({"type": "join", "room": "nowhere"}, m.CLOSE_NOT_FOUND, "no longer exists"),
        ({"type": "ready", "seat": 0}, m.CLOSE_BAD_MESSAGE, "not understood"),
        ({"type": "join", "room": 7}, m.CLOSE_BAD_MESSAGE, "not understood"),
        ({"type": "join", "room": "x", "sudo": True}, m.CLOSE_BAD_MESSAGE, "not understood"),
        ("hello", m.CLOSE_BAD_MESSAGE, "not understood"),
        (b"hello", m.CLOSE_BAD_MESSAGE, "must be a join"),
    ],
    ids=["no room", "not a join", "wrong type", "unknown field", "no JSON", "binary"],
)
def test_a_wrong_first_message_is_answered_with_a_sentence(live: Live, first: object, code: int, said: str) -> None:
    with live.connect() as connection:
        connection.send(first if isinstance(first, bytes) else json.dumps(first))
        bye = json.loads(connection.recv(10))
        assert (bye["type"], bye["code"]) == ("bye", code)
        assert said in bye["message"]
        with pytest.raises(Exception, match=str(code)):
            connection.recv(10)


@pytest.mark.parametrize("subprotocols", [None, ["movingout.v0"], ["chat"]])
def test_another_protocol_version_is_refused_before_the_handshake(live: Live, subprotocols: list[str] | None) -> None:
    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://{live.address}/ws", subprotocols=subprotocols)  # type: ignore[arg-type]
    assert refused.value.response.status_code == 400
    assert b"movingout.v1" in refused.value.response.body


def test_a_partner_from_the_catalogue_plays(live: Live) -> None:
    room = live.open_room("here", "scripted")
    blue = live.person(room["room"], tokens=[room["tokens"][0]])
    start((blue, 0))
    for _ in range(10):  # on a busy machine it may think a while before it goes
        blue.play(15)
        moved = abs(blue.bundles[-1].poses[-1, 1] - blue.bundles[0].poses[0, 1]).max()
        if moved > 0.05:
            break
    assert moved > 0.05, "red has moved"


@pytest.mark.slow
def test_a_stop_says_goodbye_and_keeps_the_round_to_go_on_with(tmp_path: Path) -> None:
    with serve(tmp_path) as live:
        _, blue, red = two_people(live)
        start((blue, 0), (red, 1))
        blue.play(3)
    code, told = blue.end()
    assert code == m.CLOSE_SHUTDOWN
    assert told[-1]["type"] == "bye"
    (recording,) = (tmp_path / "recordings").iterdir()
    episode = read_episode(recording)
    assert (recording.suffix, episode.outcome, episode.complete) == (".journal", "interrupted", False)
    with serve(tmp_path) as live:
        back = live.person(json.loads(next((tmp_path / "rooms").glob("*.json")).read_text())["id"], tokens=blue.tokens)
        assert back.wait_for("room")["phase"] == "paused"
