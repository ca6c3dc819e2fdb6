"""Whose threads compute too much: by hand, second by second."""

from dataclasses import dataclass, field

import pytest

from movingout.agents.worker.thread_budget import (
    LOOK_S,
    WINDOW_S,
    Overrun,
    Spent,
    ThreadBudget,
    spent_now,
    thread_numbers,
    thread_seconds,
)

DECIDING = 1  # the thread that decides


@dataclass
class Machine:
    """A process whose threads use the processor as they are told."""

    now: float = 100.0
    ended: float = 0.0  # seconds of threads that are gone
    threads: dict[int, float] = field(default_factory=lambda: {DECIDING: 7.0})

    def budget(self, most_cores: float = 0.4) -> ThreadBudget:
        return ThreadBudget(
            most_cores,
            clock=lambda: self.now,
            spent=lambda: Spent(sum(self.threads.values()) + self.ended, self.threads[DECIDING]),
            threads=lambda: frozenset(self.threads),
            seconds=lambda thread: self.threads.get(thread, 0.0),
        )

    def end(self, thread: int) -> None:
        self.ended += self.threads.pop(thread)

    def use(self, budget: ThreadBudget, seconds: float, thread: int, cores: float) -> Overrun | None:
        """Let a thread use so many cores for so long; what the budget says, at once when it says something."""
        until = self.now + seconds
        while self.now < until:
            self.now += LOOK_S
            self.threads[thread] += cores * LOOK_S
            if found := budget.overrun():
                return found
        return None


def test_a_thread_belongs_to_the_agent_at_work_when_it_began() -> None:
    machine, agents = Machine(), ["first", "second"]
    budget = machine.budget()
    for number, agent in enumerate(agents):
        with budget.deciding(agent):
            machine.threads[10 + number] = 0.0
    assert machine.use(budget, 20.0, thread=10, cores=0.3) is None
    found = machine.use(budget, 20.0, thread=11, cores=1.0)
    assert found is not None and found.agent is agents[1] and 0.4 < found.cores <= 1.0


def test_the_thread_that_decides_may_take_all_of_a_core() -> None:
    machine = Machine()
    assert machine.use(machine.budget(), 30.0, thread=DECIDING, cores=1.0) is None


def test_many_threads_are_found_sooner() -> None:
    machine = Machine()
    budget = machine.budget()
    with budget.deciding("agent"):
        machine.threads[10] = 0.0
    begun = machine.now
    assert machine.use(budget, 20.0, thread=10, cores=8.0) == Overrun("agent", 8.0)
    assert machine.now - begun <= 1.0 < WINDOW_S


def test_threads_that_end_within_a_decision_count_for_it() -> None:
    machine = Machine()
    budget = machine.budget()
    found = None
    for _ in range(30):
        machine.now += LOOK_S
        with budget.deciding("culprit", "its twin"):
            machine.ended += 0.5
        with budget.deciding("innocent"):
            pass
        if found := budget.overrun():
            break
    assert found is not None and found.agent in ("culprit", "its twin")


def test_what_loading_takes_counts_for_nobody() -> None:
    machine = Machine()
    budget = machine.budget()
    with budget.loading():
        machine.threads[10] = 30.0
    budget.claim("agent")
    machine.now += LOOK_S
    assert budget.overrun() is None
    machine.end(10)
    budget.claim("agent")
    assert machine.use(budget, 20.0, thread=DECIDING, cores=0.5) is None


def test_a_burst_is_forgotten_after_its_window() -> None:
    machine = Machine()
    budget = machine.budget()
    with budget.deciding("agent"):
        machine.threads[10] = 0.0
    for _ in range(5):
        assert machine.use(budget, 1.0, thread=10, cores=1.5) is None
        assert machine.use(budget, WINDOW_S, thread=DECIDING, cores=1.0) is None


@pytest.mark.skipif(not thread_numbers(), reason="a system without /proc")
def test_the_threads_of_this_process_are_measured() -> None:
    before = spent_now()
    while spent_now().thread < before.thread + 0.05:
        pass
    import threading

    number = threading.get_native_id()
    assert number in thread_numbers() and thread_seconds(number) > 0.04
    assert thread_seconds(2**22 + 1) == 0.0 and spent_now().elsewhere >= 0.0
