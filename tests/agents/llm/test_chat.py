"""One question to a server that answers, errs, dawdles or talks rubbish."""

import itertools
import time

import pytest

from movingout.agents.errors import AgentError
from movingout.agents.llm.chat import ChatEndpoint, ChatError
from movingout.agents.llm.model_id import ModelId
from tests.agents.llm.stand_in import Reply, said, stand_in

KEY = "sk-secret"
HELLO = [{"role": "user", "content": "hello"}]


def asked(reply: Reply, timeout_s: float = 20.0) -> str:
    with stand_in(lambda _: reply) as server:
        return ChatEndpoint(ModelId("m", server.url), KEY, timeout_s, {})(HELLO)


def test_the_model_is_asked_with_the_key() -> None:
    with stand_in(lambda _: said(f"hi {KEY}")) as server:
        assert ChatEndpoint(ModelId("m", server.url), KEY, 2.0, {"temperature": 0.5})(HELLO) == "hi [key]"
        assert ChatEndpoint(ModelId("m", server.url), "", 2.0, {})(HELLO) == f"hi {KEY}"
    assert server.requests[0] == {"model": "m", "messages": HELLO, "stream": False, "temperature": 0.5}
    assert server.keys == [f"Bearer {KEY}", ""]


@pytest.mark.parametrize(
    ("reply", "fault", "wait_s"),
    [
        (Reply(f"bad key {KEY}", 401), "http", 0.0),
        (Reply("oops", 500), "http", 0.0),
        (Reply("", 302, {"location": "http://127.0.0.1:1/"}), "http", 0.0),
        (Reply("slowly", 429, {"retry-after": "7"}), "busy", 7.0),
        (Reply("slowly", 429, {"retry-after": "Mon, 01 Jan 2029 00:00:00 GMT"}), "busy", 0.0),
        (Reply("full", 503, {"retry-after": "inf"}), "busy", 0.0),
        (Reply("<html>"), "rubbish", 0.0),
        (Reply("[" * 100_000), "rubbish", 0.0),
        (Reply('{"choices": []}'), "rubbish", 0.0),
        (Reply('{"choices": [{"message": {"content": null}}]}'), "rubbish", 0.0),
        (Reply("[]"), "rubbish", 0.0),
        (Reply("x" * (2 << 20)), "rubbish", 0.0),
    ],
)
def test_faults_have_a_kind_and_never_tell_the_key(reply: Reply, fault: str, wait_s: float) -> None:
    with pytest.raises(ChatError) as error:
        asked(reply)
    assert (error.value.fault, error.value.wait_s) == (fault, wait_s)
    assert KEY not in str(error.value) and len(str(error.value)) <= 200


@pytest.mark.parametrize("slow", [Reply("{}", delay_s=0.6), Reply(" " * 200, drips_s=0.05)])
def test_a_slow_answer_ends_in_time(slow: Reply) -> None:
    begun = time.monotonic()
    with stand_in(lambda _: slow) as server, pytest.raises(ChatError) as error:
        try:
            ChatEndpoint(ModelId("m", server.url), "", 0.3, {})(HELLO)
        finally:
            took = time.monotonic() - begun
    assert error.value.fault == "timeout" and took < 8.0, "the whole answer takes ten seconds"


def test_what_cannot_be_sent_is_no_fault_of_the_answer() -> None:
    with stand_in(lambda _: said("hi")) as server, pytest.raises(ChatError, match="codec can't encode") as error:
        ChatEndpoint(ModelId("m", server.url), "sk-\u200babc", 2.0, {})(HELLO)
    assert error.value.fault == "unreachable" and not server.requests


def test_the_first_contact_says_what_is_wrong() -> None:
    with stand_in(lambda _: said("hi")) as server:
        endpoint = ChatEndpoint(ModelId("m", server.url), KEY, 2.0, {})
        endpoint.meet()
        server.models = Reply("not here", 404)  # not every server lists its models
        endpoint.meet()
        server.models = Reply(f"wrong {KEY}", 401)
        with pytest.raises(AgentError, match=r"refuses the key \(HTTP 401: wrong \[key\]\)"):
            endpoint.meet()
    with pytest.raises(AgentError, match=r"nothing answers at http://127.0.0.1:\d+/v1 .*start the server"):
        endpoint.meet()


def test_a_server_that_takes_seconds_at_the_first_contact_is_there() -> None:
    with stand_in(lambda _: said("hi")) as server:
        six_seconds_later = itertools.count(0.0, 6.0).__next__
        ChatEndpoint(ModelId("m", server.url), KEY, 2.0, {}, six_seconds_later).meet()
        with pytest.raises(AgentError, match="nothing answers"):
            ChatEndpoint(ModelId("m", server.url), KEY, 2.0, {}, itertools.count(0.0, 11.0).__next__).meet()
