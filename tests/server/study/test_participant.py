"""A participant in a served study: nothing is kept before consent, and reloads keep the place."""

import json
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed

from movingout.recordings.storage.index import list_recordings
from movingout.server.study.participant_actions import LONGEST_MS
from movingout.study.store.tables import answers, audit, consents, counts, identities, participants, rounds
from tests.server.live import Person
from tests.server.study.support import Served, Visitor, served

WAY = [
    "consent", "form", "input-check", "practice", "round", "questionnaire", "round", "questionnaire", "debrief", "code",
]  # fmt: skip


def test_from_the_link_to_the_code_a_reload_anywhere_returns_to_the_same_place(solo: Served) -> None:
    visitor = solo.visitor(PROLIFIC_PID="whole-way", STUDY_ID="s1")
    kinds = [visitor.kind]
    while visitor.kind != "code":
        visitor.do()
        kinds.append(visitor.kind)
        shown = dict(visitor.view)
        assert visitor.look() == shown
        visitor = solo.visitor(PROLIFIC_PID="whole-way", known=[visitor.token])
        assert visitor.view == shown, "the link brings them back, too"
    assert kinds == WAY
    step = visitor.step
    minutes, amount = step["earned"].pop("minutes"), step["earned"].pop("amount")
    assert amount == pytest.approx(0.2 * minutes, abs=0.02)
    assert step == {
        "key": "code", "kind": "code", "code": step["code"], "outcome": "done", "kept": True, "long_ago": False,
        "shared_code": False, "html": None, "ask_to_keep": False,
        "completion_url": f"https://app.prolific.com/submissions/complete?cc={step['code']}",
        "earned": {"currency": "USD"}, "from_platform": True,
    }  # fmt: skip
    store = solo.running.databases.store
    unit = solo.running.participants[visitor.pid].record.unit
    played = [row for row in store.rows(rounds) if row["unit"] == unit]
    assert [(row["outcome"], row["ticks"], row["partner"]) for row in played] in (
        [("time", 20, "good"), ("time", 20, "bad")],
        [("time", 20, "bad"), ("time", 20, "good")],
    )
    assert len([row for row in store.rows(answers) if row["pid"] == visitor.pid]) == 7 + 2 * 10


@pytest.mark.slow
def test_every_finished_round_has_exactly_one_recording_and_nothing_says_who_it_was(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="5f3c-the-worker")
        visitor.go_to("code")
        pid, episodes = visitor.pid, {row["episode"] for row in study.running.databases.store.rows(rounds)}
        assert study.state()["server"]["recordings"] == 2
    found, damaged = list_recordings(tmp_path / "recordings")
    assert ({one.id for one in found}, damaged) == (episodes, [])
    assert all(pid in one.blue + one.red and one.study["study"] == "solo" for one in found)
    for path in tmp_path.rglob("*"):
        if path.is_file() and not path.name.startswith("identity"):
            assert b"5f3c-the-worker" not in path.read_bytes(), path


@pytest.mark.parametrize("key", ["form", "input-check", "practice", "play/1/HandOff-1", "debrief", "code"])
def test_nothing_leads_past_the_consent(solo: Served, key: str) -> None:
    visitor = solo.visitor()
    status, answer = visitor.call("next", {"key": key, "rtt_ms": 1, "keep": True, "done": True})
    assert (status, answer["view"]["step"]["kind"]) == (200, "consent")
    assert visitor.pid not in [seat.alias for room in solo.live.rooms for seat in room.seats]


def test_no_answer_is_kept_before_the_consent(solo: Served) -> None:
    visitor = solo.visitor()
    status, answer = visitor.answer("age", 1, key="form")
    assert (status, answer["error"]["code"]) == (422, "step")


def test_nobody_answers_what_they_have_not_been_asked_yet(solo: Served) -> None:
    """Else a program says what it thinks of partners whom it has never met, and is let through afterwards."""
    visitor = solo.visitor().go_to("form")
    later = [step.key for step in solo.running.participants[visitor.pid].steps if step.kind == "questionnaire"]
    status, answer = visitor.answer("teamwork", 7, key=later[0])
    assert (status, answer["error"]["code"]) == (422, "step")
    asked = visitor.step["key"]
    visitor.fill_in()
    assert visitor.answer("age", 1, key=asked)[0] == 200, "a click that arrives late is kept"


def test_the_consent_is_kept_with_the_language_and_the_hash_of_the_shown_text(solo: Served) -> None:
    visitor = solo.visitor("de")
    assert "<h1>Einwilligung</h1>" in visitor.step["html"]
    status, answer = visitor.call("next", {"key": "consent", "boxes": ["release"]})
    assert (status, answer["error"]["code"]) == (422, "boxes")
    visitor.next(boxes=["adult", "unknown"])
    visitor.call("next", {"key": "consent", "boxes": ["adult"]})
    mine = [row for row in solo.running.databases.store.rows(consents) if row["pid"] == visitor.pid]
    text = solo.running.study.consent.text.text("de")
    assert [(row["language"], row["sha256"], row["boxes"]) for row in mine] == [
        ("de", sha256(text.encode()).hexdigest(), '["adult"]')
    ]


def test_who_declines_is_a_number_and_nothing_else(tmp_path: Path) -> None:
    with served(tmp_path) as study:
        visitor = study.visitor(PROLIFIC_PID="curious")
        for _ in range(2):
            visitor.decline()
            assert (visitor.step["code"], visitor.step["outcome"]) == (None, "declined")
        visitor.look()
        store = study.running.databases.store
        assert (store.rows(participants), store.rows(counts)) == ([], [{"name": "declined", "number": 1}])
        with study.running.databases.identities.database.read() as connection:
            assert connection.execute(identities.select()).all() == []
        assert study.visitor(PROLIFIC_PID="curious").kind == "consent", "who changes their mind is welcome"


def test_controls_that_could_not_be_tried_are_kept_and_the_experimenter_is_told(solo: Served) -> None:
    visitor = solo.visitor().go_to("input-check")
    visitor.next(rtt_ms=8.0, device="keyboard", untried=["grab", "up", "anything else"])
    assert visitor.kind == "practice"
    kept = [row for row in solo.running.databases.store.rows(audit) if row["action"] == "input-check"]
    assert [(row["actor"], json.loads(row["detail"])) for row in kept] == [("participant", {"untried": ["up", "grab"]})]
    (alert,) = [one for one in solo.running.alerts.to_json() if one["about"] == "controls"]
    assert alert["text"] == f"{visitor.pid} continued without trying: up, grab."


def test_double_clicks_do_what_one_click_does(solo: Served) -> None:
    visitor = solo.visitor()
    for _ in range(4):
        if visitor.kind == "form":
            visitor.answer_all()
        said = {"key": visitor.step["key"], "boxes": ["adult"], "rtt_ms": 3.0, "device": "touch"}
        with ThreadPoolExecutor(3) as pool:
            heard = [pool.submit(visitor.call, "next", said) for _ in range(3)]
        assert {one.result()[0] for one in heard} == {200}
        visitor.look()
    assert visitor.kind == "practice"
    mine = [row for row in solo.running.databases.store.rows(consents) if row["pid"] == visitor.pid]
    assert len(mine) == 1
    assert len([room for room in solo.live.rooms if visitor.pid == room.seats[0].alias]) == 1


def test_the_language_is_the_participants_choice(solo: Served) -> None:
    visitor = solo.visitor("fr")
    assert (visitor.view["language"], visitor.view["languages"]) == ("en", ["en", "de"])
    visitor.look("de")
    assert (visitor.view["language"], visitor.view["study"]["title"]) == ("de", "Mit Partnern spielen")
    visitor.look("fr")
    assert visitor.look()["language"] == "de"
    assert solo.visitor("de-AT").view["language"] == "de"


def test_a_click_is_kept_at_once_and_shown_again(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    assert visitor.answer("age", 2) == (200, {"saved": True})
    assert visitor.look()["step"]["answers"] == {"age": {"value": 2, "text": ""}}
    for item, value, status in (("age", 99, 422), ("nothing", 1, 422)):
        assert visitor.answer(item, value)[0] == status
    assert visitor.answer("age", 1, key="practice")[0] == 422
    assert visitor.call("next", {"key": "form"})[1]["error"]["code"] == "unanswered"
    visitor.fill_in()
    assert visitor.answer("age", 3, key="form") == (200, {"saved": True}), "one that was on its way"
    kept = [
        row for row in solo.running.databases.store.rows(answers) if (row["pid"], row["item"]) == (visitor.pid, "age")
    ]
    assert [(row["value"], row["elapsed_ms"], row["hidden_ms"]) for row in kept] == [
        (n, 900.0, 10.0) for n in (2, 0, 3)
    ]


def test_no_time_of_a_click_is_longer_than_anybody_can_have_looked(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    body = {"key": visitor.step["key"], "item": "age", "value": 2, "elapsed_ms": 1e308, "hidden_ms": -5.0}
    assert visitor.call("answer", body) == (200, {"saved": True})
    (kept,) = [row for row in solo.running.databases.store.rows(answers) if row["pid"] == visitor.pid]
    assert (kept["elapsed_ms"], kept["hidden_ms"]) == (LONGEST_MS, 0.0)


def test_a_page_that_is_reloaded_in_a_round_comes_back_to_the_same_seat(solo: Served) -> None:
    visitor = solo.visitor().go_to("round")
    assert (visitor.step["state"], visitor.step["number"], visitor.step["of"]) == ("card", 1, 2)
    visitor.next()
    assert visitor.step["state"] == "playing"
    first = visitor.player()
    first.play(2, visitor.step["room"]["seat"])
    visitor = Visitor(solo, visitor.token, visitor.look())
    again = visitor.player()
    assert again.welcome["seats"][0]["seat"] == visitor.step["room"]["seat"]
    assert again.welcome["study"] is True
    again.play_out(visitor.step["room"]["seat"])
    visitor.wait_until(lambda one: one.kind == "questionnaire")


def test_partners_are_letters_and_nobody_says_which_model_it_is(solo: Served) -> None:
    visitor = solo.visitor().go_to("round")
    visitor.next()
    person = visitor.player()
    person.play(1, visitor.step["room"]["seat"])
    told = str([person.welcome, person.told, visitor.view, solo.row(visitor.pid)])
    assert "good" not in told and "bad" not in told
    assert visitor.step["partner_letter"] in ("A", "B") and f"Partner {visitor.step['partner_letter']}" in told
    episode = next(one["episode"] for one in person.told if one["type"] == "round")
    assert solo.live.call(f"/api/recordings/{episode}")[0] == 401
    assert solo.live.call(f"/api/rooms/{visitor.step['room']['id']}/thoughts")[0] == 403


def test_nobody_takes_a_seat_of_a_study_without_its_key(solo: Served) -> None:
    visitor = solo.visitor().go_to("round")
    visitor.next()
    with pytest.raises(ConnectionClosed):
        Person(solo.live.connect(), visitor.step["room"]["id"], mode="play", claim=1)


def test_pages_and_texts_are_served_and_the_start_page_leads_to_the_study(solo: Served) -> None:
    for path, part in (("/study", b"study.js"), ("/experimenter", b"experimenter.js"), ("/?lang=de", b"study.js")):
        status, page = solo.live.call(path)
        assert status == 200 and part in page, path
    assert solo.live.call("/static/words/de.json")[0] == 200


def test_nobody_is_done_with_a_questionnaire_without_an_answer(solo: Served) -> None:
    visitor = solo.visitor().go_to("form")
    status, told = visitor.call("next", {"key": visitor.step["key"]})
    assert (status, told["error"]["code"]) == (422, "unanswered")
    for item in visitor.step["items"]:
        visitor.answer(item["id"], -1)  # "I prefer not to answer" is one, and a text may stay empty
    assert visitor.next()["step"]["key"] != "form"
