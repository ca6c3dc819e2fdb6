"""Who is let in to a served study: by which link or code, how often, and while there is a place."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.server.study.support import SOLO, Served, events_of, served


def test_of_two_with_one_link_the_second_goes_on_and_the_first_is_told(solo: Served) -> None:
    first = solo.visitor(PROLIFIC_PID="shared")
    first.agree()
    with ThreadPoolExecutor(1) as pool:
        heard = pool.submit(events_of, first, 1)
        while not solo.running.participants[first.pid].listeners:
            pass
        second = solo.visitor(known=[first.token], PROLIFIC_PID="shared")
        assert heard.result(20) == [{"changed": True}]
    assert second.kind == "form"
    assert first.look()["step"]["kind"] == "ended-elsewhere"
    assert first.look()["position"] == {"done": 0, "total": 0}, "not part 1 of 1"
    assert first.next()["step"]["kind"] == "ended-elsewhere"
    assert first.answer("age", 1, key="form")[0] == 409
    assert second.look()["step"]["kind"] == "form"
    assert "duplicate" in solo.alerts()


def test_a_code_lets_one_participant_in_and_brings_them_back_until_they_have_finished(tmp_path: Path) -> None:
    with served(tmp_path, codes=True) as study:
        known = study.live.call("/api/study")[1]
        assert (known["asks_code"], known["pays"]) == (True, True)
        for parameters, code in (
            ({}, "code"), ({"code": "NOBODY"}, "code_unknown"), ({"PROLIFIC_PID": "made-up"}, "code"),
            ({"workerId": "made-up"}, "code"), ({"code": " "}, "code"),
        ):  # fmt: skip
            status, answer = study.arrive(**parameters)
            assert (status, answer["error"]["code"]) == (403, code)
        code = study.ask("open-next")["code"]
        visitor = study.visitor(code=f" {code.lower()} ")
        visitor.agree()
        pid = visitor.pid
        again = study.visitor(code=code)
        assert (again.kind, again.pid) == ("form", pid)
        again.stop(True)
        status, answer = study.arrive(code=code)
        assert (status, answer["error"]["code"]) == (403, "code_used")
        assert again.look()["step"]["outcome"] == "withdrew", "their own page still shows the code"
        reopened = study.visitor(code=code, known=[again.token])
        assert (reopened.pid, reopened.step["code"]) == (pid, again.step["code"]), (
            "so does their link, in their browser"
        )


def test_who_guesses_codes_has_to_wait(tmp_path: Path) -> None:
    with served(tmp_path, codes=True) as study:
        study.live.host.admission._limits = study.live.host.settings.limits.__class__()
        found = [study.arrive(code=f"GUESS{number}")[1]["error"]["code"] for number in range(12)]
    assert found[0] == "code_unknown" and found[-1] == "locked"


@pytest.mark.parametrize(
    "parameters", [{"PROLIFIC_PID": "{{%PROLIFIC_PID%}}"}, {"PROLIFIC_PID": "5f3c", "STUDY_ID": "{{%STUDY_ID%}}"},
                   {"PROLIFIC_PID": "%7B%7B%25PROLIFIC_PID%25%7D%7D"}, {"workerId": "w" * 201}],
)  # fmt: skip
def test_a_link_that_the_platform_did_not_fill_in_makes_nobody_the_same_participant(
    solo: Served, parameters: dict[str, str]
) -> None:
    status, answer = solo.arrive(**parameters)
    assert (status, answer["error"]["code"]) == (403, "link")


def test_a_preview_and_a_foreign_secret_are_told_what_to_do(solo: Served) -> None:
    status, answer = solo.arrive(assignmentId="ASSIGNMENT_ID_NOT_AVAILABLE", workerId="w")
    assert (status, answer["error"]["code"]) == (403, "preview")
    status, answer = solo.live.call("/api/study/view", token="made-up")
    assert (status, answer["error"]["code"]) == (401, "no_participant")


@pytest.mark.slow
def test_a_study_that_has_everybody_it_needs_says_so(tmp_path: Path) -> None:
    with served(tmp_path, SOLO.replace("participants: 400", "participants: 1")) as study:
        first, late = study.visitor(), study.visitor()
        late.go_to("practice")
        assert "full" not in study.alerts(), "nobody holds the only slot yet"
        first.go_to("practice")
        assert "full" in study.alerts(), "one too many, and the experimenter knows"
        first.go_to("code")
        status, answer = study.arrive(PROLIFIC_PID="too-late")
        assert (status, answer["error"]["code"]) == (403, "study_full")
        known = study.running.databases.identities.known
        assert known("prolific", "too-late") is None, "nothing is kept of who was turned away"
