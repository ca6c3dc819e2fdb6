"""The HTTP API as the pages use it."""

import contextlib
import gzip
import http.client
import json
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from movingout.agents.built_in import AgentCard
from movingout.agents.catalogue import ALONE_TCR, UNSEEN_TCR, agent_card
from movingout.agents.checkpoint.checkpoint import SHIPPED, read_checkpoint, readable_checkpoints
from movingout.maps import map_from_json, shipped_map_names
from movingout.server import messages as m
from movingout.server.api import offered_agents, room_requests
from movingout.server.api.offered_agents import OfferedAgents
from movingout.server.api.pages import WEB
from movingout.server.monitoring import status as server_status
from movingout.server.settings import Settings
from tests.server.live import ADMIN, Live, serve


def test_all_maps_come_with_the_practice_room(live: Live) -> None:
    status, answer = live.call("/api/maps")
    assert status == 200
    assert [map_from_json(each).name for each in answer["maps"]] == list(shipped_map_names()[:-1])
    assert answer["practice"]["name"] == "Simple"


def test_the_catalogue_names_its_agents_and_the_proposed_one(live: Live) -> None:
    _, answer = live.call("/api/agents")
    assert {"scripted", "idle"} <= {agent["id"] for agent in answer["agents"]}
    assert answer["default"] == "bass@any"


def test_the_cards_of_agents_are_read_at_most_every_two_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    read = []

    def cards() -> list[AgentCard]:
        read.append(now[0])
        return []

    monkeypatch.setattr(offered_agents, "agent_cards", cards)
    offered = OfferedAgents(Settings(), lambda: now[0])
    for now[0] in (100.0, 100.5, 101.9, 102.1, 103.0):
        assert b'"default"' in offered.document()
    assert read == [100.0, 102.1]


def test_the_catalogue_says_what_a_trained_agent_learned_from_and_reaches_and_nothing_of_others(live: Live) -> None:
    _, answer = live.call("/api/agents")
    agents = {agent["id"]: agent for agent in answer["agents"]}
    card = read_checkpoint(SHIPPED / "bass-all").card
    assert (agents["bass@all"]["kind"], agents["bass@all"]["policy"]) == ("bass", "dp")
    assert agents["bass@all"]["population"] == card.training.population
    assert agents["bass@all"]["tcr"] == {"unseen": card.scores[UNSEEN_TCR].mean, "alone": card.scores[ALONE_TCR].mean}
    for untrained in ("scripted", "idle"):
        assert agents[untrained]["tcr"] == {"unseen": None, "alone": None}
        assert agents[untrained]["population"] == agents[untrained]["policy"] == ""


def test_every_language_says_whom_the_shipped_agents_learned_from() -> None:
    cards = [agent_card(checkpoint.card.id) for checkpoint in readable_checkpoints(SHIPPED)]
    learned = {card.population.split(";")[0] for card in cards}
    keys = {f"lobby.population.{people.replace(' ', '-')}" for people in learned}
    assert len(keys) >= 2
    for path in (WEB / "words").glob("*.json"):
        assert keys - json.loads(path.read_text("utf-8")).keys() == set(), path.name


def test_a_room_has_tokens_for_the_seats_at_this_screen_only(live: Live) -> None:
    room = live.open_room("here", "link")
    assert isinstance(room["tokens"][0], str) and room["tokens"][1] is None
    assert room["join_path"] == f"/play/{room['room']}" and room["watch_path"] == f"/watch/{room['room']}"
    _, view = live.call(f"/api/rooms/{room['room']}")
    assert (view["phase"], view["map"]) == ("lobby", "Simple")
    assert [seat["colour"] for seat in view["seats"]] == ["blue", "red"]
    assert view["subprotocol"] == m.SUBPROTOCOL


def test_a_limit_that_cannot_be_is_refused_for_practice_too(live: Live) -> None:
    """It was kept as it came, whatever it was."""
    wanted = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}], "practice": True}
    before = len(live.rooms)
    for limit in (-1, 9, 10**9, 10**30):
        status, answer = live.call("/api/rooms", wanted | {"limit_ticks": limit})
        assert (status, answer["error"]["code"]) in ((422, "limit_ticks"), (422, "bad_request")), limit
    assert len(live.rooms) == before
    for limit in (0, 500):
        assert live.call("/api/rooms", wanted | {"limit_ticks": limit})[0] == 200


def test_a_room_plays_a_map_mirrored_or_turned(live: Live) -> None:
    seats = [{"kind": "here"}, {"kind": "link"}]
    status, room = live.call("/api/rooms", {"maps": ["HandOff:mirror:rot90"], "seats": seats})
    assert status == 200
    _, view = live.call(f"/api/rooms/{room['room']}")
    assert view["map"] == "HandOff:mirror:rot90"


@pytest.mark.parametrize(
    ("change", "code", "said"),
    [
        (
            {"maps": ["HandOff:mirored"]},
            "unknown_map",
            "unknown symmetry 'mirored' of HandOff; did you mean mirror? known: mirror",
        ),
        ({"maps": ["HandOf"]}, "unknown_map", "unknown map 'HandOf'; did you mean HandOff? known: HandOff"),
        ({"maps": ["../maps/HandOff.json"]}, "unknown_map", "known: HandOff"),
        ({"maps": []}, "maps", "1 to 36 maps"),
        ({"seats": [{"kind": "robot"}]}, "bad_request", "known: agent, ghost, here, link, partner, remote"),
        ({"maps": ["Simple"] * 37}, "maps", "1 to 36 maps"),
        ({"seats": [{"kind": "here"}]}, "seats", "two seats"),
        ({"seats": [{"kind": "here"}, {"kind": "throne"}]}, "bad_request", "throne"),
        ({"limit_ticks": 0}, "limit_ticks", "10 to 36000"),
        ({"limit_ticks": "long"}, "bad_request", "limit_ticks"),
        ({"challenge2_seed": -1}, "challenge2_seed", "from 0"),
        ({"colour": "blue"}, "bad_request", "colour"),
    ],
)
def test_a_room_that_cannot_be_is_refused_with_what_can(
    live: Live, change: dict[str, object], code: str, said: str
) -> None:
    body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "link"}], **change}
    status, answer = live.call("/api/rooms", body)
    assert (status, answer["error"]["code"]) == (422, code)
    assert said in answer["error"]["message"]


def test_an_agent_with_a_damaged_card_is_refused_by_what_is_wrong_and_others_play(
    live: Live, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "data" / "models" / "odd-mine"
    folder.mkdir(parents=True)
    (folder / "card.json").write_text('{"schema_version": 1}')
    monkeypatch.chdir(tmp_path)
    body = {"maps": ["Simple"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "odd@mine"}]}
    status, answer = live.call("/api/rooms", body)
    assert (status, answer["error"]["code"]) == (422, "damaged_agent")
    assert "odd@mine cannot play: odd-mine/card.json: id: Field required" in answer["error"]["message"]
    _, offered = live.call("/api/agents")
    assert "bass@all" in {agent["id"] for agent in offered["agents"]}
    assert live.call("/api/rooms", {**body, "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}]})[0] == 200


def test_a_randomised_series_is_the_same_for_the_same_seed(live: Live) -> None:
    seen = []
    for _ in range(2):
        room = live.open_room("here", "link", maps=("HandOff", "HandOff"), challenge2_seed=5)
        person = live.person(room["room"], tokens=[room["tokens"][0]])
        seen.append(person.wait_for("round")["map"])
    assert seen[0] == seen[1]
    assert seen[0]["variant"]


def test_practice_has_no_limit(live: Live) -> None:
    room = live.open_room("here", "idle", practice=True, limit_ticks=0)
    person = live.person(room["room"], tokens=[room["tokens"][0]])
    round_ = person.wait_for("round")
    assert (round_["practice"], round_["limit_ticks"]) == (True, 0)


def test_the_qr_code_is_a_picture_of_the_join_link(live: Live) -> None:
    room = live.open_room("here", "link")
    status, picture = live.call(f"/api/rooms/{room['room']}/qr.svg")
    assert status == 200 and b"<svg" in picture and b"<path" in picture


def test_the_questionnaire_comes_in_the_language_that_is_asked_for(live: Live) -> None:
    titles = [live.call(f"/api/questionnaire?language={language}")[1]["title"] for language in ("de", "en", "xx")]
    assert titles == ["Über Ihren Partner", "About your partner", "About your partner"]


@pytest.mark.parametrize("path", ["/api/rooms/nowhere", "/api/rooms/nowhere/qr.svg", "/api/rooms/nowhere/answers"])
def test_a_room_that_is_gone_is_told_in_a_sentence(live: Live, path: str) -> None:
    status, answer = live.call(path)
    assert (status, answer["error"]["code"]) == (404, "no_room")


def test_answers_are_saved_per_seat_and_the_newest_counts(live: Live) -> None:
    room = live.open_room("here", "here")
    both = live.person(room["room"], tokens=room["tokens"])
    path = f"/api/rooms/{room['room']}/answers"
    for value in (3, 6):
        answer = {"question": "teamwork", "value": value, "elapsed_ms": 1200}
        assert live.call(path, answer, token=both.tokens[0]) == (200, {"saved": True})
    comment = {"question": "comment", "value": -1, "text": "Schön – 🙂"}
    assert live.call(path, comment, token=both.tokens[0])[0] == 200
    assert live.call(path, token=both.tokens[0])[1]["answers"] == {
        "teamwork": {"value": 6, "text": ""},
        "comment": {"value": -1, "text": "Schön – 🙂"},
    }
    assert live.call(path, token=both.tokens[1])[1]["answers"] == {}


@pytest.mark.parametrize(
    "answer",
    [
        {"question": "teamwork", "value": 8},
        {"question": "weather", "value": 3},
        {"question": "comment", "value": -1, "text": "x" * 4001},
    ],
)
def test_an_answer_that_does_not_fit_its_question_is_refused(live: Live, answer: dict[str, object]) -> None:
    room = live.open_room("here", "idle")
    person = live.person(room["room"], tokens=room["tokens"][:1])
    status, said = live.call(f"/api/rooms/{room['room']}/answers", answer, token=person.tokens[0])
    assert (status, said["error"]["code"]) == (422, "answer")


def test_answers_need_the_token_of_a_seat(live: Live) -> None:
    room = live.open_room("here", "idle")
    path = f"/api/rooms/{room['room']}/answers"
    for token in ("", "wrong"):
        assert live.call(path, {"question": "teamwork", "value": 3}, token=token)[0] == 401


def test_a_token_of_before_the_last_join_is_no_guess(live: Live) -> None:
    """As a page that rejoins while somebody answers questions may still send."""
    room = live.open_room("here", "idle")
    person = live.person(room["room"], tokens=room["tokens"][:1])
    old = person.tokens[0]
    person.connection.close()
    again = live.person(room["room"], tokens=[old])
    again.say(type="ready", seat=0)
    path, answer = f"/api/rooms/{room['room']}/answers", {"question": "teamwork", "value": 3}
    assert again.tokens[0] != old
    said = [live.call(path, answer, token=old)[0] for _ in range(30)]
    assert set(said) <= {200, 401}, "429 would lock the address of the page itself"


def test_maps_are_made_for_an_address_as_often_as_it_may_check_maps(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    monkeypatch.setattr(room_requests, "own_map", lambda host, name: made.append(name))
    seats = [{"kind": "here"}, {"kind": "link"}]
    status, answer = live.call("/api/rooms", {"maps": [f"generated:test:{n}" for n in range(400)], "seats": seats})
    assert (status, answer["error"]["code"]) == (422, "maps")
    assert not made, "too many are refused before the first of them is made"


def test_the_administrator_sees_rooms_and_closes_one(live: Live) -> None:
    room = live.open_room("here", "idle")
    person = live.person(room["room"], tokens=room["tokens"][:1])
    _, state = live.call("/api/admin/state", token=ADMIN)
    (row,) = [each for each in state["rooms"] if each["room"] == room["room"]]
    assert (row["phase"], row["map"], row["round"], row["rounds"]) == ("lobby", "Simple", 1, 1)
    assert {"late_ms", "missed_ticks", "cpu_percent", "rss_mb", "sockets", "agents", "refusal"} <= set(state)
    assert live.call(f"/api/admin/rooms/{room['room']}/close", {}, token=ADMIN) == (200, {"closed": True})
    code, told = person.end()
    assert (code, told[-1]["type"]) == (m.CLOSE_KICKED, "bye")
    assert live.call(f"/api/rooms/{room['room']}")[0] == 404


@pytest.mark.slow
def test_recordings_are_listed_for_the_administrator(live: Live) -> None:
    room = live.open_room("here", "idle", limit_ticks=10)
    person = live.person(room["room"], tokens=room["tokens"][:1])
    person.say(type="ready", seat=0)
    recording = person.wait_for("result")["recording"]
    assert live.call(f"/api/recordings/{recording}")[0] == 200
    _, answer = live.call("/api/recordings", token=ADMIN)
    (row,) = [each for each in answer["recordings"] if each["id"] == recording]
    assert (row["map"], row["ticks"], row["outcome"], row["complete"]) == ("Simple", 10, "time", True)
    assert row["red"].startswith("idle")
    assert "path" not in row
    assert live.call("/api/recordings/nothing")[1]["error"]["code"] == "no_recording"


def test_a_browser_gets_a_page_and_a_program_json_where_nothing_is(live: Live) -> None:
    status, page = live.call("/nothing")
    assert status == 404 and b"<!doctype html>" in page.lower()
    assert live.call("/api/nothing")[1]["error"]["code"] == "not_found"


@pytest.mark.parametrize(
    ("accepted", "packed"),
    [("gzip, deflate, br", True), ("br;q=1.0, gzip;q=0.5", True), ("gzip;q=0", False), ("", False)],
)
def test_texts_go_compressed_to_whoever_understands_it(live: Live, accepted: str, packed: bool) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", live.port)
    connection.request("GET", "/static/words/en.json", headers={"Accept-Encoding": accepted})
    answer = connection.getresponse()
    body = answer.read()
    assert answer.getheader("vary") == "accept-encoding"
    assert answer.getheader("content-encoding") == ("gzip" if packed else None)
    plain = (WEB / "words" / "en.json").read_bytes()
    assert (gzip.decompress(body) if packed else body) == plain
    assert not packed or len(body) < len(plain) / 3
    known = {"Accept-Encoding": accepted, "If-None-Match": answer.getheader("etag") or ""}
    connection.request("GET", "/static/words/en.json", headers=known)
    again = connection.getresponse()
    assert (again.status, again.read()) == (304, b"")
    connection.close()


def test_static_files_are_revalidated(live: Live) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=20)
    connection.request("GET", "/static/messages.js")
    first = connection.getresponse()
    first.read()
    assert first.getheader("cache-control") == "no-cache"
    connection.request("GET", "/static/messages.js", headers={"If-None-Match": first.getheader("etag") or ""})
    again = connection.getresponse()
    assert (again.status, again.read()) == (304, b"")
    connection.close()


def answered(live: Live, path: str, method: str = "GET", token: str = "") -> tuple[int, str | None, str | None, bytes]:
    """Status, Cache-Control, Content-Length and body."""
    connection = http.client.HTTPConnection("127.0.0.1", live.port, timeout=20)
    with contextlib.closing(connection):
        connection.request(method, path, headers={"Authorization": f"Bearer {token}"} if token else {})
        answer = connection.getresponse()
        return answer.status, answer.getheader("cache-control"), answer.getheader("content-length"), answer.read()


@pytest.mark.parametrize("path", ["/", "/healthz", "/static/messages.js", "/favicon.ico", "/nothing"])
def test_head_answers_as_get_does_without_a_body(live: Live, path: str) -> None:
    """Programs that watch a server ask so; `curl -I` too."""
    status, kept, length, body = answered(live, path)
    assert answered(live, path, "HEAD") == (status, kept, str(len(body)), b"")
    assert length == str(len(body))


@pytest.mark.parametrize("path", ["/api/agents", "/api/rooms/none", "/api/admin/state", "/api/recordings", "/healthz"])
def test_answers_about_rooms_and_people_are_kept_by_no_cache(live: Live, path: str) -> None:
    assert answered(live, path, token=ADMIN)[1] == answered(live, path)[1] == "no-store"


def test_a_server_that_runs_a_study_opens_rooms_for_its_experimenter_alone(tmp_path: Path) -> None:
    wanted = {"maps": ["Simple"], "seats": [{"kind": "link"}, {"kind": "link"}]}
    with serve(tmp_path, lobby=False) as study:
        status, answer = study.call("/api/rooms", wanted)
        assert (status, answer["error"]["code"]) == (403, "study")
        status, answer = study.call("/api/rooms", wanted, token=ADMIN)
        assert status == 200
        assert study.call(f"/api/rooms/{answer['room']}")[1]["study"] is False


def test_the_tutorial_needs_nothing_but_its_name(live: Live) -> None:
    status, room = live.call("/api/rooms", {"tutorial": True})
    assert status == 200 and isinstance(room["tokens"][0], str) and room["tokens"][1] is None
    _, view = live.call(f"/api/rooms/{room['room']}")
    assert (view["map"], [seat["kind"] for seat in view["seats"]]) == ("Tutorial", ["human", "agent"])


def test_the_tutorial_is_for_one_or_two_players_on_its_own_map(live: Live) -> None:
    here, agent = {"kind": "here"}, {"kind": "agent"}
    assert live.call("/api/rooms", {"tutorial": True, "seats": [here, {"kind": "link"}]})[0] == 200
    for change in ({"seats": [agent, agent]}, {"maps": ["HandOff"]}, {"seats": [here]}):
        status, answer = live.call("/api/rooms", {"tutorial": True, **change})
        assert (status, answer["error"]["code"]) == (422, "tutorial")


def test_the_time_that_the_server_is_up_follows_no_clock_that_is_set(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = SimpleNamespace(time=lambda: 0.0, monotonic=time.monotonic, process_time=time.process_time)
    monkeypatch.setattr(server_status, "time", clock)
    assert 0.0 <= live.call("/api/admin/state", token=ADMIN)[1]["uptime_s"] < 86_400.0
