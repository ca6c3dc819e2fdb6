"""Questions in the background: what comes of them, and when the next one may be asked. Time is stepped by hand."""

import threading
from collections.abc import Callable, Sequence

from movingout.agents.llm.chat import ChatError, Message
from movingout.agents.llm.questions import MOST_HANGING, ChatOutcome, Questions


class Clock:
    def __init__(self) -> None:
        self.now = 100.0
        self.slept: list[float] = []

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


def questions(chat: Callable[[Sequence[Message]], str], clock: Clock) -> Questions:
    return Questions(chat, 5.0, clock, clock.sleep)


def outcome(asked: Questions) -> ChatOutcome:
    """The outcome of a question that is answered at once."""
    while (found := asked.poll()) is None:
        threading.Event().wait(0.001)
    return found


def test_an_answer_comes_once_and_asking_never_blocks() -> None:
    clock, go = Clock(), threading.Event()

    def chat(_: Sequence[Message]) -> str:
        go.wait()
        return "yes"

    asked = questions(chat, clock)
    asked.ask([])
    assert asked.poll() is None and not asked.ready
    clock.now += 3.0
    go.set()
    assert outcome(asked) == ChatOutcome(3.0, "yes")
    assert asked.poll() is None and asked.ready


def test_a_question_that_hangs_is_given_up_and_there_are_few_of_them() -> None:
    clock, go = Clock(), threading.Event()
    asked = questions(lambda _: str(go.wait()), clock)
    for _ in range(MOST_HANGING):
        assert asked.ready
        asked.ask([])
        clock.now += 6.0
        given_up = asked.poll()
        assert given_up is not None and given_up.fault == "timeout" and given_up.latency_s == 6.0
        clock.now += 100.0
    assert not asked.ready
    go.set()
    while not asked.ready:
        threading.Event().wait(0.001)


def test_pauses_double_and_are_as_long_as_the_server_asks_for() -> None:
    clock = Clock()
    errors = [ChatError("http", "HTTP 500"), ChatError("http", "HTTP 500"), ChatError("busy", "HTTP 429", 20.0)]
    errors += [ChatError("busy", "HTTP 429", 9999.0)]

    def chat(_: Sequence[Message]) -> str:
        if errors:
            raise errors.pop(0)
        return "yes"

    asked = questions(chat, clock)
    for pause in (1.0, 2.0, 20.0, 60.0):
        asked.ask([])
        assert outcome(asked).fault in ("http", "busy")
        clock.now += pause - 0.1
        assert not asked.ready
        clock.now += 0.1
        assert asked.ready
    asked.ask([])
    assert outcome(asked).answer == "yes" and asked.ready


def test_who_waits_keeps_a_pause_that_was_asked_for_and_no_other() -> None:
    clock = Clock()
    errors = [ChatError("unreachable", "gone"), ChatError("busy", "HTTP 429", 2.0), ChatError("busy", "HTTP 429", 50.0)]

    def chat(_: Sequence[Message]) -> str:
        if errors:
            raise errors.pop(0)
        return "yes"

    asked = questions(chat, clock)
    assert [asked.wait([]).fault for _ in range(3)] == ["unreachable", "busy", "busy"]
    assert asked.wait([]).answer == "yes" and clock.slept == [2.0, 5.0]


def test_an_answer_for_the_last_episode_is_nobody_s() -> None:
    clock, go = Clock(), threading.Event()
    asked = questions(lambda _: str(go.wait()), clock)
    asked.ask([])
    asked.forget()
    go.set()
    assert asked.poll() is None and asked.ready


def test_a_mistake_in_the_chat_is_an_outcome() -> None:
    clock = Clock()
    asked = questions(lambda _: str(1 // 0), clock)
    asked.ask([])
    found = outcome(asked)
    assert found.fault == "unreachable" and "ZeroDivisionError" in found.problem
