"""Agent seats with real worker processes: answers, chunks, and every way a worker can fail."""

import asyncio
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any, NoReturn, cast

import numpy as np
import pytest
import uvloop

from movingout.agents.errors import AgentError, AgentsBusyError
from movingout.agents.observation.seat_observation import start_state
from movingout.agents.worker.messages import Answer, Failed, Open, Opened
from movingout.agents.worker.thread_budget import MOST_CORES
from movingout.maps import load_map
from movingout.server.agent_workers import process, process_restarts
from movingout.server.agent_workers.agent_seat import AgentAnswer, AgentSeat
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.agent_workers.process import AgentProcess
from movingout.server.agent_workers.process_restarts import MANY, ProcessRestarts
from movingout.world.state import WorldState
from tests.agents.support import HERE

pytestmark = pytest.mark.slow

MAP = load_map("HandOff")
PATIENCE_S = 20.0
FEW_CORES = 0.05  # of which even a busy machine has enough for an agent to go beyond


def state_at(tick: int) -> WorldState:
    state = start_state(MAP)
    return WorldState(tick, state.robot_poses, state.robot_velocities, state.held, state.item_poses)


def with_pool(
    scenario: Callable[[AgentPool], Awaitable[None]],
    thread_cores: float = MOST_CORES,
    run: Callable[[Coroutine[Any, Any, None]], None] = asyncio.run,
) -> None:
    async def use() -> None:
        pool = AgentPool(workers=1, thread_cores=thread_cores)
        await pool.start()
        try:
            await scenario(pool)
        finally:
            await pool.close()

    run(use())


async def until(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < limit, "waited too long"
        await asyncio.sleep(0.01)


def open_seat(pool: AgentPool, agent: str) -> AgentSeat:
    return pool.open(agent, MAP, seat=0, seed=1, ticks=500)


async def ask(seat: AgentSeat, tick: int) -> AgentAnswer:
    """One tick as a patient room would run it."""
    failures = seat.failures
    seat.observe(state_at(tick), tick, time.monotonic() + PATIENCE_S)
    # not any answer: a worker that was replaced may answer an earlier tick first
    await until(lambda: seat.decision_trace[0] == tick or seat.failures > failures or bool(seat.failed))
    return seat.answer(tick)


class _Worker:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[object] = []

    def send(self, message: object) -> None:
        self.told.append(message)


def test_the_latency_of_an_answer_is_measured_by_the_clock_that_the_seat_was_given() -> None:
    now = [10.0]
    opening = Open(7, "idle", MAP, 0, 1, 500)
    seat = AgentSeat(AgentPool(0), 7, cast(AgentProcess, _Worker()), opening, clock=lambda: now[0])
    seat.take(Opened(7))
    seat.observe(state_at(3), 3, deadline=10.1)
    now[0] = 10.0325
    seat.take(Answer(7, 3, np.zeros((1, 4)).tobytes(), execute=1, decision_ms=2.0, detail={}))
    assert seat.answer(3).latency_ms == pytest.approx(32.5)


def test_who_has_sat_down_is_not_refused_as_too_slow_at_the_next_worker_in_the_middle_of_a_round() -> None:
    worker = _Worker()
    seat = AgentSeat(AgentPool(0), 7, cast(AgentProcess, worker), Open(7, "idle", MAP, 0, 1, 500), clock=lambda: 0.0)
    seat.begin()
    seat.begin()  # the first worker was lost before it had answered
    seat.take(Opened(7))
    seat.worker_lost(guilty=False)
    seat.begin()
    assert [opening.must_keep_up for opening in worker.told if isinstance(opening, Open)] == [True, True, False]


def test_a_server_that_lets_slow_agents_play_and_rooms_that_come_back_refuse_none_as_too_slow() -> None:
    pool = AgentPool(1)
    with pool.without_limit():
        restored = pool.open("idle", MAP, 0, 1, 500)
    with pool.already_seated():
        taken_over = pool.open("idle", MAP, 0, 1, 500)
    patient = AgentPool(1, slow_agents=True).open("idle", MAP, 0, 1, 500)
    seats = pool.open("idle", MAP, 0, 1, 500), restored, taken_over, patient
    assert [seat._opening.must_keep_up for seat in seats] == [True, False, False, False]


def test_a_seat_knows_that_its_agent_was_refused_as_too_slow() -> None:
    seat = AgentPool(1).open("idle", MAP, 0, 1, 500)
    seat.take(Failed(seat.key, -1, "idle needs 200 ms", fatal=True, slow=True))
    assert seat.slow and seat.failed == "idle needs 200 ms"


def test_an_agent_answers_for_the_tick_it_was_asked_about() -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Forward:distance=7")
        await until(lambda: seat.ready)
        answer = await ask(seat, 5)
        np.testing.assert_array_equal(answer.action, [1.0, 0.0, 0.0])  # clipped at the rim
        assert not answer.missed and answer.latency_ms > 0 and answer.detail == {"rows": 1}
        seat.close()
        assert pool.report()[0]["seats"] == 0

    with_pool(scenario)


def test_a_chunk_is_played_before_the_agent_is_asked_again_and_its_rest_covers_a_miss() -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Forward:rows=4,execute=2")
        await until(lambda: seat.ready)
        await ask(seat, 1)
        seat.observe(state_at(2), 2, time.monotonic() + PATIENCE_S)
        assert not seat.answer(2).missed and seat.decisions == 1  # the second row, without a question
        seat.observe(state_at(3), 3, time.monotonic() - 1.0)  # nobody can answer in the past
        late = seat.answer(3)
        assert late.missed and late.action[0] == 1.0  # what is left of the chunk
        seat.observe(state_at(5), 5, time.monotonic() - 1.0)
        assert seat.answer(5).action[0] == 0.0  # used up: neutral
        assert seat.missed == 2

    with_pool(scenario)


def test_a_killed_worker_is_replaced_and_its_seats_go_on() -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Forward")
        await until(lambda: seat.ready)
        os.kill(int(pool.report()[0]["pid"]), signal.SIGKILL)
        await until(lambda: not seat.ready)
        seat.observe(state_at(1), 1, time.monotonic() + 0.01)
        neutral = seat.answer(1)
        assert neutral.missed and neutral.action[0] == 0.0
        killed = time.monotonic()
        await until(lambda: seat.ready)
        assert time.monotonic() - killed < 5.0
        assert (await ask(seat, 2)).action[0] == 1.0
        assert pool.report()[0]["restarts"] == 1

    with_pool(scenario)


def test_ctrl_c_at_the_terminal_does_not_end_a_worker_that_still_imports(tmp_path: Path) -> None:
    package = tmp_path / "movingout" / "agents" / "worker"
    package.mkdir(parents=True)
    interrupted = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
    (package / "process.py").write_text(f"{interrupted}\ndef main(arguments):\n    print(*arguments)\n")
    command = [sys.executable, "-S", "-c", process.PROGRAM, "3", "4"]  # -S: only the package above
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (ended.stdout, ended.stderr) == ("3 4\n", "")


@pytest.mark.parametrize("run", [asyncio.run, uvloop.run])
def test_a_worker_starts_on_the_loop_of_a_server_and_on_that_of_a_service_of_agents(
    run: Callable[[Coroutine[Any, Any, None]], None],
) -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Forward")
        await until(lambda: seat.ready)

    with_pool(scenario, run=run)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGUSR1])
def test_a_signal_to_the_whole_group_leaves_the_workers_to_their_server(number: signal.Signals) -> None:
    """SIGUSR1 lets rounds end: the agents that play in them went at once, where a service manager signals all."""

    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Forward")
        await until(lambda: seat.ready)
        pid = pool.report()[0]["pid"]
        os.kill(int(pid), number)
        assert (await ask(seat, 1)).action[0] == 1.0
        assert (pool.report()[0]["pid"], pool.report()[0]["restarts"]) == (pid, 0)

    with_pool(scenario)


@pytest.mark.parametrize("error", [OSError(24, "Too many open files"), ValueError("no such thing")])
def test_a_worker_that_cannot_be_started_is_tried_again_and_is_a_fault_meanwhile(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, error: Exception
) -> None:
    monkeypatch.setattr(process, "QUICK_DEATH_S", 0.01)

    async def no_more(*_: object) -> NoReturn:
        raise type(error)(*error.args)  # another one each time: its traceback, which is logged, would grow

    async def scenario(pool: AgentPool) -> None:
        with monkeypatch.context() as broken:
            broken.setattr(process, "_spawn", no_more)
            seat = open_seat(pool, f"{HERE}:Forward")
            await until(lambda: pool.report()[0]["restarts"] >= MANY)
            (fault,) = pool.faults()  # it may have ended once more since it was counted
            assert re.fullmatch(r"an agent worker: ended \d+ times within a minute", fault)
            broken.setattr(process_restarts, "AWAY_S", -1.0)
            assert any(re.fullmatch(r"an agent worker: away for \d+ s", fault) for fault in pool.faults())
        await until(lambda: seat.ready)
        assert (await ask(seat, 1)).action[0] == 1.0
        assert caplog.messages[0] == f"an agent worker cannot be run: {error}"

    with_pool(scenario)


def test_agents_that_end_their_worker_are_no_fault_of_the_server() -> None:
    kept = ProcessRestarts("a worker", lambda: 7.0)
    for _ in range(2 * MANY):
        kept.ended(by_itself=False)
    assert (kept.restarts, [*kept.faults()]) == (2 * MANY, [])


def test_a_hanging_agent_costs_its_neighbour_only_the_restart() -> None:
    async def scenario(pool: AgentPool) -> None:
        hanging, neighbour = open_seat(pool, f"{HERE}:Hanging:at=3"), open_seat(pool, f"{HERE}:Forward")
        await until(lambda: hanging.ready and neighbour.ready)
        answer = await ask(hanging, 3)  # comes back when the worker has been replaced
        assert answer.action[0] == 0.0 and "hung" in answer.problem
        await until(lambda: hanging.ready and neighbour.ready)
        assert (await ask(neighbour, 4)).action[0] == 1.0
        assert (await ask(hanging, 4)).action[0] == 1.0
        assert (hanging.strikes, neighbour.strikes) == (1, 0)

    with_pool(scenario)


def test_an_agent_that_raises_is_neutral_says_why_and_recovers() -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Raising:first=2,last=3")
        await until(lambda: seat.ready)
        assert (await ask(seat, 1)).problem == ""
        answer = await ask(seat, 2)
        assert answer.problem.startswith("ValueError: I do not know this place (tests/agents/support.py, line ")
        assert answer.missed and answer.action[0] == 0.0
        await ask(seat, 3)
        assert (await ask(seat, 4)).action[0] == 1.0 and not seat.failed

    with_pool(scenario)


def test_an_agent_that_answers_nan_for_ever_is_given_up_with_a_reason() -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:NotANumber")
        await until(lambda: seat.ready)
        for tick in range(1, 21):
            assert np.isfinite((await ask(seat, tick)).action).all()
        assert "finite" in seat.failed

    with_pool(scenario)


def test_an_agent_that_kills_its_process_three_times_is_given_up() -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:Dying")
        for tick in range(1, 4):
            await until(lambda: seat.ready)
            await ask(seat, tick)
        assert "3 times" in seat.failed
        assert seat.answer(4).action[0] == 0.0

    with_pool(scenario)


@pytest.mark.parametrize("factory", ["broken_factory", "not_an_agent", "missing"])
def test_an_agent_that_cannot_be_made_leaves_its_seat_neutral_with_a_reason(factory: str) -> None:
    async def scenario(pool: AgentPool) -> None:
        seat = open_seat(pool, f"{HERE}:{factory}")
        await until(lambda: bool(seat.failed))
        seat.observe(state_at(1), 1, time.monotonic() + 1.0)
        answer = seat.answer(1)
        assert answer.action[0] == 0.0 and not answer.missed

    with_pool(scenario)


def test_an_unknown_agent_is_refused_at_once() -> None:
    pool = AgentPool()
    with pytest.raises(AgentError, match="known: scripted, "):
        open_seat(pool, "scriptet")


def test_a_pool_without_time_left_refuses_one_more() -> None:
    pool = AgentPool()
    for _ in range(200):
        pool.note_cost("idle", 35.0, 1)
    open_seat(pool, "idle")
    open_seat(pool, "idle")
    with pytest.raises(AgentsBusyError, match="no room for one more 'idle': one agent process would be busy"):
        open_seat(pool, "idle")


def test_one_slow_first_decision_refuses_nobody_and_one_seat_is_always_had() -> None:
    pool = AgentPool()
    pool.note_cost("idle", 95.0, 1)
    for _ in range(5):
        open_seat(pool, "idle")
    slow = AgentPool()
    for _ in range(200):
        slow.note_cost("idle", 500.0, 1)
    open_seat(slow, "idle")


@pytest.mark.parametrize("options", ["threads=1", "threads=4", "threads=2,short=true"])
def test_an_agent_whose_threads_compute_for_ever_is_stopped_and_its_neighbour_plays_on(
    options: str, caplog: pytest.LogCaptureFixture
) -> None:
    async def scenario(pool: AgentPool) -> None:
        runaway, neighbour = open_seat(pool, f"{HERE}:Threaded:{options}"), open_seat(pool, f"{HERE}:Forward")
        await until(lambda: runaway.ready and neighbour.ready)
        for tick in range(1, 500):
            for seat in (runaway, neighbour):
                seat.observe(state_at(tick), tick, time.monotonic() + PATIENCE_S)
            await asyncio.sleep(0.1)
            if runaway.failed:
                break
        assert re.fullmatch(r"the agent's own threads took \d+\.\d cores, and 0.05 are allowed", runaway.failed)
        assert runaway.answer(500).action[0] == 0.0
        await until(lambda: pool.report()[0]["overruns"] == 1 and neighbour.ready)
        assert (await ask(neighbour, 501)).action[0] == 1.0 and neighbour.strikes == 0
        again = open_seat(pool, f"{HERE}:Threaded:{options}")
        assert again.failed == "the agent's own threads computed too much a short while ago"
        assert [*pool.faults()] == []

    with_pool(scenario, thread_cores=FEW_CORES)
    assert any(said.startswith(f"{HERE}:Threaded:{options} takes no seat for 10 minutes:") for said in caplog.messages)


def test_an_agent_that_asks_for_all_memory_fails_alone() -> None:
    """A network may compute the size of what it makes: ConstantOfShape with 10^10 elements."""

    async def scenario(pool: AgentPool) -> None:
        hungry, neighbour = open_seat(pool, f"{HERE}:Hungry"), open_seat(pool, f"{HERE}:Forward")
        await until(lambda: hungry.ready and neighbour.ready)
        answer = await ask(hungry, 1)
        assert answer.action[0] == 0.0 and "Memory" in answer.problem
        assert (await ask(neighbour, 1)).action[0] == 1.0
        assert pool.report()[0]["restarts"] == 0

    with_pool(scenario)
