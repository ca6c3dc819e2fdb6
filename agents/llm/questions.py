"""Questions in the background: one at a time, bounded in time, fewer while the server is busy or away."""

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from movingout.agents.llm.chat import Chat, ChatError, Fault, Message

MOST_HANGING = 4  # threads whose time is over; more are not begun
LONGEST_PAUSE_S = 60.0
GRACE_S = 0.5  # for an endpoint that keeps its own time limit


@dataclass(frozen=True, slots=True)
class ChatOutcome:
    """What became of a question: `answer`, or else the fault and what is known of it."""

    latency_s: float
    answer: str = ""
    fault: Fault | None = None
    problem: str = ""


class _OpenQuestion:
    """One question in a thread of its own."""

    def __init__(self, chat: Chat, messages: Sequence[Message], clock: Callable[[], float]) -> None:
        self.begun = clock()
        self.answer = ""
        self.error: ChatError | None = None
        self.latency_s = 0.0
        self.over = threading.Event()
        self._chat, self._messages, self._clock = chat, messages, clock
        self.thread = threading.Thread(target=self._run, name="llm", daemon=True)
        self.thread.start()

    def _run(self) -> None:
        try:
            self.answer = self._chat(self._messages)
        except ChatError as error:
            self.error = error
        except Exception as error:  # noqa: BLE001 - nobody else would hear of it
            self.error = ChatError("unreachable", f"{type(error).__name__}: {error}"[:200])
        self.latency_s = self._clock() - self.begun
        self.over.set()


class Questions:
    """Asks `chat` without ever blocking, except in `wait`."""

    def __init__(
        self,
        chat: Chat,
        timeout_s: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._chat, self._timeout_s, self._clock, self._sleep = chat, timeout_s, clock, sleep
        self._open: _OpenQuestion | None = None
        self._hanging: list[threading.Thread] = []
        self._failures = 0
        self._asked_to_wait = False
        self._not_before = 0.0

    @property
    def ready(self) -> bool:
        """Whether another question may be asked now."""
        self._hanging = [thread for thread in self._hanging if thread.is_alive()]
        rested = self._not_before <= self._clock()
        return self._open is None and rested and len(self._hanging) < MOST_HANGING

    def ask(self, messages: Sequence[Message]) -> None:
        """Begin to ask; `poll` has the outcome some time later."""
        self._open = _OpenQuestion(self._chat, messages, self._clock)

    def poll(self) -> ChatOutcome | None:
        """The outcome, once."""
        question = self._open
        if question is None:
            return None
        if question.over.is_set():
            return self._closed(question)
        if self._clock() - question.begun > self._timeout_s + GRACE_S:
            return self._given_up(question)
        return None

    def wait(self, messages: Sequence[Message]) -> ChatOutcome:
        """Ask and wait for the outcome: for twice the time-out at most, a pause that the server asks for included."""
        if self._asked_to_wait:
            self._sleep(min(max(self._not_before - self._clock(), 0.0), self._timeout_s))
        self.ask(messages)
        question = self._open
        assert question is not None
        if question.over.wait(self._timeout_s + GRACE_S):
            return self._closed(question)
        return self._given_up(question)

    def forget(self) -> None:
        """Whatever is still answered belongs to an episode that is over."""
        if self._open is not None and not self._open.over.is_set():
            self._hanging.append(self._open.thread)
        self._open = None

    def _closed(self, question: _OpenQuestion) -> ChatOutcome:
        self._open = None
        if question.error is None:
            self._failures, self._asked_to_wait, self._not_before = 0, False, 0.0
            return ChatOutcome(question.latency_s, question.answer)
        self._rest(question.error)
        return ChatOutcome(question.latency_s, "", question.error.fault, str(question.error))

    def _given_up(self, question: _OpenQuestion) -> ChatOutcome:
        self.forget()
        error = ChatError("timeout", f"no answer within {self._timeout_s:g} s")
        self._rest(error)
        return ChatOutcome(self._clock() - question.begun, "", error.fault, str(error))

    def _rest(self, error: ChatError) -> None:
        """Twice as long after each failure; as long as the server asks for, where it does."""
        self._failures += 1
        self._asked_to_wait = error.fault == "busy"
        pause = error.wait_s or 2.0 ** min(self._failures - 1, 10)
        self._not_before = self._clock() + min(pause, LONGEST_PAUSE_S)
