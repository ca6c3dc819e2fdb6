"""How many agents are admitted: by measured cost, kept over a restart, and by decisions that came too late."""

import asyncio
import json
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from movingout.agents.errors import AgentsBusyError
from movingout.agents.worker.heartbeat import WorkerHeartbeat
from movingout.agents.worker.messages import Close, Open, Opened, answer_message
from movingout.agents.worker.process import MOST_SPARE_IDS, DecisionQueue
from movingout.maps import load_map
from movingout.server.agent_workers.capacity import (
    GUESS_TRAINED,
    MOST_KEPT,
    AgentCosts,
    LateDecisions,
    cost_name,
    per_worker,
)
from movingout.server.agent_workers.pool import AgentPool
from movingout.server.processes.agent_service import RoomsLink, ServicePool
from movingout.server.processes.shared_agents import SharedAgents
from tests.agents.support import HERE

MAP = load_map("HandOff")
DRAWN = replace(MAP, name="Den")


def queue(tmp_path: Path) -> DecisionQueue:
    with (tmp_path / "heartbeat").open("w+b") as file:
        return DecisionQueue(WorkerHeartbeat(file.fileno()))


def test_a_worker_times_the_decisions_of_an_agent_that_it_has_loaded_and_not_of_a_spare_one(tmp_path: Path) -> None:
    worker = queue(tmp_path)
    opened = worker.take(Open(1, "scripted", MAP, 0, 1, 500))
    assert isinstance(opened, Opened) and 1e-4 < opened.share < 1.0
    worker.take(Close(1))
    again = worker.take(Open(2, "scripted", MAP, 0, 1, 500))
    assert isinstance(again, Opened) and again.share == 0.0


def test_agents_with_ever_other_options_leave_few_spare_ones(tmp_path: Path) -> None:
    worker = queue(tmp_path)
    for key in range(3 * MOST_SPARE_IDS):
        worker.take(Open(key, f"{HERE}:Forward:rows={key + 1}", MAP, 0, 1, 500))
        worker.take(Close(key))
    assert len(worker._spare) <= MOST_SPARE_IDS


def test_seats_are_admitted_by_what_was_measured_at_the_warm_up_not_by_a_guess() -> None:
    """Ten rooms are opened within a second: no decision was timed yet but those of the warm-up."""
    pool = AgentPool(1)
    pool._most = 0.8
    first = pool.open("bass@all", MAP, 0, 1, 500)
    first.take(Opened(first.key, share=0.25))
    pool.open("bass@all", MAP, 0, 1, 500), pool.open("bass@all", MAP, 0, 1, 500)
    with pytest.raises(AgentsBusyError, match="busy 100% of the time, and at most 80% is safe"):
        pool.open("bass@all", MAP, 0, 1, 500)


def test_the_service_seats_what_a_process_has_admitted_though_another_was_quicker() -> None:
    """A refusal would have ended the connection, and with it all agents of the process."""
    pool = ServicePool(1)
    pool.costs.measured("bass@all", 0.5)
    for key in (1, 2):
        rooms = RoomsLink(pool, lambda: None)
        rooms._take(Open(key, "bass@all", MAP, 0, 1, 500))
    assert [seat and seat.agent_id for seat in map(pool.seat, (1, 2))] == ["bass@all"] * 2
    assert pool.free().left[0] < 0.0


def test_the_service_does_not_refuse_as_too_slow_who_has_sat_down() -> None:
    pool = ServicePool(1)
    RoomsLink(pool, lambda: None)._take(Open(1, "idle", MAP, 0, 1, 500))
    seat = pool.seat(1)
    assert seat and seat._opening.must_keep_up
    seat.take(Opened(1))
    assert not seat._opening.must_keep_up


def test_a_process_seats_the_agents_of_rooms_that_come_back_before_the_service_answers() -> None:
    shared = SharedAgents()
    with pytest.raises(AgentsBusyError, match="all at work"):
        shared.open("idle", MAP, 0, 1, 500)
    with shared.without_limit():
        seat = shared.open("idle", MAP, 0, 1, 500)
    assert not seat.ready and not seat.failed
    with pytest.raises(AgentsBusyError, match="all at work"):
        shared.open("idle", MAP, 0, 1, 500)


def test_what_an_agent_costs_on_drawn_maps_decides_for_drawn_maps_alone(tmp_path: Path) -> None:
    pool = AgentPool(1, costs=AgentCosts(tmp_path / "costs.json"))
    pool._most = 0.8
    seat = pool.open("bass@all", DRAWN, 0, 1, 500)
    assert pool.load(seat._worker) == GUESS_TRAINED
    seat.take(Opened(seat.key, share=0.3))
    for tick in range(200):
        seat.take(answer_message(seat.key, tick, np.zeros((1, 4)), 1, 60.0, {}))
    assert pool.costs.of("bass@all") == GUESS_TRAINED
    assert pool.load(seat._worker) == pytest.approx(0.6, abs=0.01)
    with pytest.raises(AgentsBusyError, match="no room for one more 'bass@all': one agent process would be busy 120%"):
        pool.open("bass@all", DRAWN, 0, 1, 500)
    other = pool.open("bass@all", MAP, 0, 1, 500)
    other.take(Opened(other.key, share=0.07))
    pool.costs.save()
    kept = AgentCosts(tmp_path / "costs.json")
    assert [kept.of(cost_name("bass@all", one)) for one in (MAP, DRAWN)] == pytest.approx([0.07, 0.6], abs=0.01)
    assert kept.of(cost_name("bass@all", load_map("generated:awareness:21:mirror"))) == 0.07


def test_what_a_thread_still_writes_is_written_before_the_end_of_the_server_writes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    costs = AgentCosts(tmp_path / "costs.json")
    replace_file, at_the_end = Path.replace, threading.Thread(target=lambda: costs.save())

    def slowly(new: Path, target: Path) -> Path:
        if at_the_end.ident is None:
            costs.measured("scripted", 0.02)
            at_the_end.start()
            at_the_end.join(0.05)
        return replace_file(new, target)

    monkeypatch.setattr(Path, "replace", slowly)
    costs.measured("idle", 0.01)
    costs.save()
    at_the_end.join()
    assert not caplog.text, "one of them found no file to put in its place"
    assert [AgentCosts(tmp_path / "costs.json").of(name) for name in ("idle", "scripted")] == [0.01, 0.02]


def test_until_it_was_measured_an_agent_costs_as_much_on_drawn_maps_as_on_others() -> None:
    costs = AgentCosts()
    costs.measured("bass@all", 0.07)
    assert costs.of(cost_name("bass@all", DRAWN)) == 0.07


def test_what_an_agent_costs_among_many_walls_says_nothing_of_drawn_maps_with_few() -> None:
    few, some, many = (replace(DRAWN, walls=DRAWN.walls[:1] * number) for number in (16, 17, 33))
    costs = AgentCosts()
    costs.measured("bass@all", 0.04)
    costs.measured(cost_name("bass@all", many), 0.12)
    assert [costs.of(cost_name("bass@all", one)) for one in (few, some, many)] == [0.04, 0.04, 0.12]
    costs.measured(cost_name("bass@all", some), 0.08)
    assert [costs.of(cost_name("bass@all", one)) for one in (few, some, many)] == [0.04, 0.08, 0.12]


def test_what_agents_cost_is_known_after_a_restart_unless_they_were_trained_again(tmp_path: Path) -> None:
    kept = AgentCosts(tmp_path / "costs.json")
    kept.measured("bass@all", 0.07)
    kept.measured("bass@all", 0.2)  # another worker loads it: what is known stays
    kept.save()
    assert AgentCosts(tmp_path / "costs.json").of("bass@all") == 0.07
    rows = json.loads((tmp_path / "costs.json").read_text())
    (tmp_path / "costs.json").write_text(json.dumps({"bass@all": rows["bass@all"] | {"model": "older"}}))
    assert AgentCosts(tmp_path / "costs.json").of("bass@all") == GUESS_TRAINED


@pytest.mark.parametrize("text", ["", "[]", "[" * 100_000, '{"idle": {"share": "x"}}', '{"idle": 3}', "\0"])
def test_a_damaged_file_of_costs_stops_no_server(tmp_path: Path, text: str) -> None:
    (tmp_path / "costs.json").write_text(text)
    assert AgentCosts(tmp_path / "costs.json").of("idle") > 0.0


def test_ever_other_options_do_not_fill_the_costs() -> None:
    costs = AgentCosts()
    for seed in range(2 * MOST_KEPT):
        costs.note(f"scripted:seed={seed}", 0.01)
    assert len(costs._shares) == MOST_KEPT


def test_a_worker_that_decides_too_late_takes_no_more_seats_until_it_keeps_up() -> None:
    now = [100.0]
    late = LateDecisions(lambda: now[0])
    for _ in range(100):
        late.note(False)
    assert not late.too_many()
    for _ in range(20):
        late.note(True)
    assert late.too_many()
    now[0] += 30.0
    for _ in range(60):
        late.note(False)
    assert not late.too_many()


def test_the_agents_leave_the_rooms_their_core() -> None:
    assert per_worker(2, cores=2) == pytest.approx(0.65)
    assert per_worker(1, cores=1) == pytest.approx(0.3)
    assert per_worker(2, cores=16) == 0.8


def test_late_decisions_of_a_pool_are_noticed() -> None:
    async def scenario() -> None:
        pool = AgentPool(1)
        seat = pool.open("idle", MAP, 0, 1, 500)
        for tick in range(30):
            seat._due = tick
            seat.answer(tick)
        with pytest.raises(AgentsBusyError, match="too late"):
            pool.open("idle", MAP, 0, 1, 500)

    asyncio.run(scenario())
