"""The queue of an agent worker: who is answered when, and together with whom."""

import re
import tempfile
import time
from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from movingout.agents.base import ActionChunk, Observation
from movingout.agents.observation.seat_observation import start_state
from movingout.agents.worker import process
from movingout.agents.worker.heartbeat import WorkerHeartbeat
from movingout.agents.worker.messages import (
    Answer,
    Close,
    Failed,
    FromWorker,
    Observe,
    Open,
    Opened,
    Skipped,
    frame,
    observe_message,
    read_to_worker,
)
from movingout.agents.worker.process import MAX_BATCH, DecisionQueue
from movingout.maps import MapSpec, load_map
from movingout.world.ping import HelpPing
from tests.agents.support import Forward

MAP = load_map("HandOff")
HERE = __name__


class Chorus(Forward):
    """Answers in batches and remembers how many there were; with `out_of_tune` no batch works."""

    sizes: ClassVar[list[int]] = []

    def __init__(self, out_of_tune: bool = False, alone: bool = True) -> None:
        super().__init__()
        self._out_of_tune = out_of_tune
        self._alone = alone

    @property
    def batch_key(self) -> Hashable:
        return "chorus"

    @staticmethod
    def act_many(agents: Sequence["Chorus"], observations: Sequence[Observation]) -> list[ActionChunk]:
        Chorus.sizes.append(len(agents))
        if any(agent._out_of_tune for agent in agents):
            raise ValueError("somebody is out of tune")
        return [np.array([[0.5, 1.0, 0.0, 0.0]]) for _ in agents]

    def act(self, observation: Observation) -> ActionChunk:
        if not self._alone and observation.tick > 0:
            raise ValueError("I do not sing alone")
        return super().act(observation)


class Speaking(Forward):
    """Says what only headless matches could write down."""

    def act(self, observation: Observation) -> ActionChunk:
        self.detail = {"scores": np.array([0.25, 0.75])}  # type: ignore[dict-item]
        return super().act(observation)


class Listening(Forward):
    """Remembers the pings of each observation."""

    heard: ClassVar[list[tuple[HelpPing, ...]]] = []

    def act(self, observation: Observation) -> ActionChunk:
        Listening.heard.append(observation.pings)
        return super().act(observation)


class Counted(Forward):
    """Counts how many were made."""

    made = 0

    def __init__(self) -> None:
        super().__init__()
        Counted.made += 1


class Waiting(Forward):
    """Takes a while without using the processor, as a decision does on a busy machine."""

    def act(self, observation: Observation) -> ActionChunk:
        time.sleep(0.02)
        return super().act(observation)


def _work() -> None:
    """Uses 20 ms of the processor."""
    begun = time.thread_time()
    while time.thread_time() < begun + 0.02:
        pass


class Slow(Forward):
    """Works for each decision."""

    def act(self, observation: Observation) -> ActionChunk:
        _work()
        return super().act(observation)


class Working(Chorus):
    """Works for each batch."""

    @staticmethod
    def act_many(agents: Sequence["Chorus"], observations: Sequence[Observation]) -> list[ActionChunk]:
        _work()
        return Chorus.act_many(agents, observations)


class Leaving(Forward):
    """Ends the program in the second tick."""

    def act(self, observation: Observation) -> ActionChunk:
        if observation.tick > 0:
            raise SystemExit(3)
        return super().act(observation)


class Interrupting(Forward):
    """Raises what Ctrl-C raises, in the second tick."""

    def act(self, observation: Observation) -> ActionChunk:
        if observation.tick > 0:
            raise KeyboardInterrupt("mine")
        return super().act(observation)


class Keyless(Chorus):
    """Cannot say with whom it goes together."""

    @property
    def batch_key(self) -> Hashable:
        raise ValueError("no key")


@pytest.fixture
def queue() -> DecisionQueue:
    Chorus.sizes.clear()
    with tempfile.TemporaryFile() as file:
        return DecisionQueue(WorkerHeartbeat(file.fileno()))


def _open(queue: DecisionQueue, key: int, agent_id: str) -> None:
    assert isinstance(queue.take(Open(key, agent_id, MAP, 0, 0, 100)), Opened)


def _ask(queue: DecisionQueue, key: int, deadline: float = 10.0) -> None:
    message = observe_message(key, 1, deadline, start_state(MAP))
    assert isinstance(message, Observe)
    queue.take(message)


def _keys(answers: list[FromWorker]) -> list[int]:
    assert all(isinstance(answer, Answer) for answer in answers)
    return [answer.key for answer in answers]


def test_questions_for_agents_that_go_together_are_answered_in_one_batch(queue: DecisionQueue) -> None:
    for key in range(4):
        _open(queue, key, f"{HERE}:Chorus" if key < 3 else "idle")
        _ask(queue, key, deadline=10.0 - key)
    assert _keys(queue.answer_next(0.0)) == [3]  # idle, whose deadline is first
    assert _keys(queue.answer_next(0.0)) == [2, 1, 0]
    assert Chorus.sizes == [3] and not queue.busy


def test_a_decision_costs_its_part_of_the_batch_and_not_what_a_busy_machine_adds(queue: DecisionQueue) -> None:
    for key in range(3):
        _open(queue, key, f"{HERE}:Waiting" if key == 0 else f"{HERE}:Working")
        _ask(queue, key, deadline=10.0 + key)
    (alone,) = queue.answer_next(0.0)
    assert isinstance(alone, Answer) and alone.decision_ms < 15.0
    for together in queue.answer_next(0.0):
        assert isinstance(together, Answer) and 10.0 <= together.decision_ms < 18.0


def test_a_batch_is_small_enough_not_to_keep_its_first_waiting(queue: DecisionQueue) -> None:
    for key in range(MAX_BATCH + 2):
        _open(queue, key, f"{HERE}:Chorus")
        _ask(queue, key, deadline=float(key + 1))
    assert _keys(queue.answer_next(0.0)) == list(range(MAX_BATCH))
    assert _keys(queue.answer_next(0.0)) == [MAX_BATCH, MAX_BATCH + 1]


def test_who_is_too_late_is_told_so_and_not_taken_along(queue: DecisionQueue) -> None:
    for key, deadline in enumerate((1.0, 5.0, 6.0)):
        _open(queue, key, f"{HERE}:Chorus")
        _ask(queue, key, deadline)
    assert queue.answer_next(2.0) == [Skipped(0, 1)]
    assert _keys(queue.answer_next(2.0)) == [1, 2]


def test_in_a_batch_that_fails_each_is_asked_alone_and_only_the_culprit_fails(queue: DecisionQueue) -> None:
    _open(queue, 0, f"{HERE}:Chorus")
    _open(queue, 1, f"{HERE}:Chorus:out_of_tune=true,alone=false")
    for key in (0, 1):
        _ask(queue, key)
    answer, failed = queue.answer_next(0.0)
    assert isinstance(answer, Answer) and answer.key == 0
    assert isinstance(failed, Failed) and failed.key == 1
    assert re.fullmatch(
        r"ValueError: I do not sing alone \(tests/agents/worker/test_process.py, line \d+\)", failed.reason
    )


def test_arrays_that_an_agent_says_reach_the_server(queue: DecisionQueue) -> None:
    _open(queue, 0, f"{HERE}:Speaking")
    _ask(queue, 0)
    (answer,) = queue.answer_next(0.0)
    assert isinstance(answer, Answer) and answer.detail == {"scores": [0.25, 0.75]}
    assert frame(answer)


def test_an_agent_that_cannot_say_with_whom_it_goes_is_refused_in_a_sentence(queue: DecisionQueue) -> None:
    failed = queue.take(Open(0, f"{HERE}:Keyless", MAP, 0, 0, 100))
    assert isinstance(failed, Failed) and failed.fatal and "no key" in failed.reason


def test_an_agent_that_ends_the_program_fails_alone(queue: DecisionQueue) -> None:
    failed = queue.take(Open(0, "tests.agents.support:ending_factory", MAP, 0, 0, 100))
    assert isinstance(failed, Failed) and failed.fatal and "could not be made: SystemExit: 2" in failed.reason
    _open(queue, 1, f"{HERE}:Leaving")
    _ask(queue, 1)
    (answer,) = queue.answer_next(0.0)
    assert isinstance(answer, Failed) and not answer.fatal and answer.reason.startswith("SystemExit: 3 (")
    _open(queue, 2, f"{HERE}:Interrupting")
    _ask(queue, 2)
    (answer,) = queue.answer_next(0.0)
    assert isinstance(answer, Failed) and answer.reason.startswith("KeyboardInterrupt: mine (")


@pytest.mark.parametrize("agent", ["NotUtf8", "NotUtf8AgentError"])
def test_an_exception_with_a_name_that_is_not_utf8_can_be_told(queue: DecisionQueue, agent: str) -> None:
    _open(queue, 0, f"tests.agents.support:{agent}")
    question = observe_message(0, 1, 10.0, replace(start_state(MAP), tick=1))
    assert isinstance(question, Observe)
    queue.take(question)
    (answer,) = queue.answer_next(0.0)
    assert isinstance(answer, Failed) and "no such file: caf\\udce9.txt" in answer.reason
    assert frame(answer)


def test_an_agent_whose_every_decision_takes_longer_than_a_tick_is_refused_in_a_sentence(
    queue: DecisionQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "TICK_SECONDS", 0.001)
    failed = queue.take(Open(0, f"{HERE}:Slow", MAP, 0, 0, 100))
    assert isinstance(failed, Failed) and failed.fatal
    assert re.fullmatch(
        rf"{HERE}:Slow needs \d+ ms for a decision on this machine and on this map, and a tick has 1 ms: "
        "here it is for matches without people; a server that is started with --slow-agents lets it play and miss "
        "ticks",
        failed.reason,
    )
    assert failed.slow
    opened = queue.take(Open(0, f"{HERE}:Slow", MAP, 0, 0, 100, must_keep_up=False))
    assert isinstance(opened, Opened) and opened.share > 1.0


def test_a_slow_agent_that_a_restored_room_had_sits_in_no_new_room(
    queue: DecisionQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    def sits(must_keep_up: bool) -> FromWorker | None:
        answer = queue.take(Open(0, f"{HERE}:Slow", MAP, 0, 0, 100, must_keep_up=must_keep_up))
        queue.take(Close(0))
        return answer

    monkeypatch.setattr(process, "TICK_SECONDS", 0.001)
    assert [type(sits(must_keep_up)) for must_keep_up in (False, True, False)] == [Opened, Failed, Opened]
    again = sits(must_keep_up=False)
    assert isinstance(again, Opened) and again.share == 0.0, "it is timed once where it need not keep up"
    monkeypatch.setattr(process, "TICK_SECONDS", 100.0)
    assert isinstance(sits(must_keep_up=True), Opened)


def test_an_agent_that_has_played_elsewhere_is_timed_again_on_a_map_that_people_made(
    queue: DecisionQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    def sits(the_map: MapSpec) -> FromWorker | None:
        answer = queue.take(Open(0, f"{HERE}:Counted", the_map, 0, 0, 100))
        queue.take(Close(0))
        return answer

    def share(the_map: MapSpec) -> float:
        opened = sits(the_map)
        assert isinstance(opened, Opened)
        return opened.share

    drawn, shipped = replace(MAP, name="Den"), load_map("FourCorners")
    assert share(MAP) > 0.0
    assert [share(shipped), share(MAP)] == [0.0, 0.0]
    assert share(drawn) > 0.0
    assert [share(drawn), share(replace(drawn, name="Lair")), share(MAP)] == [0.0, 0.0, 0.0]
    monkeypatch.setattr(process, "TICK_SECONDS", 1e-9)
    refused = sits(replace(drawn, walls=()))
    assert isinstance(refused, Failed) and "on this map" in refused.reason


def test_an_agent_sits_again_until_its_checkpoint_is_another(
    queue: DecisionQueue, monkeypatch: pytest.MonkeyPatch
) -> None:
    Counted.made = 0
    for fingerprint, made in (("old", 1), ("old", 1), ("new", 2), ("new", 2), ("old", 3)):
        monkeypatch.setattr(process, "fingerprint", lambda _, now=fingerprint: now)
        _open(queue, 0, f"{HERE}:Counted")
        assert Counted.made == made
        queue.take(Close(0))


def test_the_pings_that_are_shown_reach_the_agent(queue: DecisionQueue) -> None:
    ping = HelpPing(3, 1, 2, 0.25, -0.5)
    _open(queue, 1, f"{HERE}:Listening")
    for pings in ((), (ping,)):
        sent = observe_message(1, 1, 1e9, start_state(MAP), pings)
        queue.take(read_to_worker(frame(sent)[4:]))
        queue.answer_next(0.0)
    assert Listening.heard[-2:] == [(), (ping,)]
