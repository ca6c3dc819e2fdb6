"""Whatever a participant's page or the experimenter's sends: a refusal in words, never a fault, and the study goes on.

100 cases by default; more with `--hypothesis-profile=long`, as in tests/server/test_fuzz.py.
"""

import json
import socket
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.server.live import ADMIN
from tests.server.study.support import Served, Visitor, served
from tests.server.test_fuzz import VALUES

ANSWERED = {*range(200, 430), 503}
KEYS = ["consent", "form", "input-check", "practice", "debrief", "code"]
STEPS = st.fixed_dictionaries(
    {},
    optional={
        "key": st.sampled_from(KEYS) | VALUES,
        "boxes": st.lists(st.sampled_from(["adult", "release"]) | VALUES, max_size=3) | VALUES,
        "item": st.sampled_from(["age", "teamwork"]) | VALUES,
        "value": st.integers(-3, 9) | VALUES,
        "text": st.text(max_size=20) | VALUES,
        "elapsed_ms": st.floats() | VALUES,
        "hidden_ms": st.floats() | VALUES,
        "rtt_ms": st.floats() | VALUES,
        "device": st.sampled_from(["keyboard", "touch"]) | VALUES,
        "keep": st.booleans() | VALUES,
        "parameters": st.dictionaries(st.sampled_from(["PROLIFIC_PID", "code", "link"]), st.text(max_size=9)) | VALUES,
        "language": st.sampled_from(["en", "de", "xx"]) | VALUES,
        "beside": VALUES,
        "known": st.lists(st.text(max_size=9), max_size=2) | VALUES,
    },
)
ORDERS = st.fixed_dictionaries(
    {},
    optional={
        "pid": st.text(max_size=9) | VALUES,
        "unit": st.integers(-1, 3) | VALUES,
        "text": st.text(max_size=20) | VALUES,
        "keep": st.booleans() | VALUES,
    },
)
PARTICIPANT = ("next", "answer", "decline", "stop", "arrive", "view", "")
EXPERIMENTER = (
    "pause", "resume", "restart-round", "kick", "invalid", "note", "allow-device", "open-next", "next-code", "state",
    "payments.csv", "qr.svg",
)  # fmt: skip
PATHS = [*(f"study/{name}".rstrip("/") for name in PARTICIPANT), *(f"experimenter/{name}" for name in EXPERIMENTER)]
BODIES = (STEPS | ORDERS | VALUES).map(lambda body: json.dumps(body).encode()) | st.binary(max_size=60)


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with served(tmp_path_factory.mktemp("fuzz")) as running:
        yield running


@pytest.fixture(scope="module")
def http(study: Served) -> Iterator[httpx.Client]:
    at_once = [(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)]
    transport = httpx.HTTPTransport(socket_options=at_once)
    with httpx.Client(base_url=f"http://{study.live.address}", timeout=30.0, transport=transport) as client:
        yield client


@pytest.fixture(scope="module")
def visitor(study: Served) -> Visitor:
    """Somebody at the first questions, whose page sends nonsense."""
    return study.visitor().go_to("form")


@pytest.mark.slow
@settings(deadline=None, suppress_health_check=list(HealthCheck))
@given(
    asked=st.sampled_from(PATHS),
    query=st.fixed_dictionaries(
        {}, optional={"code": st.text(max_size=30) | st.just("x" * 3000), "lang": st.sampled_from(["de", "xx", ""])}
    ),
    body=BODIES,
    method=st.sampled_from(["GET", "POST", "PUT", "HEAD"]),
    known=st.sampled_from([True, True, False]),
)
def test_no_request_is_a_fault(
    study: Served,
    http: httpx.Client,
    visitor: Visitor,
    asked: str,
    query: dict[str, str],
    body: bytes,
    method: str,
    known: bool,
) -> None:
    token = ADMIN if asked.startswith("experimenter") else visitor.token
    headers = {"authorization": f"Bearer {token if known else 'x'}", "content-type": "application/json"}
    answer = http.request(method, f"/api/{asked}", params=query, content=body, headers=headers)
    assert answer.status_code in ANSWERED, (answer.status_code, answer.text)
    assert known or answer.status_code >= 400 or asked in ("study", "study/arrive", "study/view") or method == "PUT"
    if answer.status_code >= 400 and method != "HEAD":
        error: dict[str, Any] = answer.json()["error"]
        assert error["code"] and error["message"]
    assert not {"fault", "database"} & {*study.alerts()}


@pytest.mark.parametrize("path", PATHS)
def test_what_is_drawn_is_there(http: httpx.Client, path: str) -> None:
    assert {http.request(method, f"/api/{path}").status_code for method in ("GET", "POST")} != {404}


@pytest.mark.parametrize("query", [{}, {"code": "x" * 3000}])
def test_a_wrong_parameter_is_refused_like_anything_else(http: httpx.Client, query: dict[str, str]) -> None:
    answer = http.get("/api/experimenter/qr.svg", params=query, headers={"authorization": f"Bearer {ADMIN}"})
    assert (answer.status_code, answer.json()["error"]["code"]) == (422, "bad_request")


def test_the_study_goes_on(study: Served) -> None:
    study.ask("resume")
    assert study.visitor().go_to("code").step["outcome"] == "done"
