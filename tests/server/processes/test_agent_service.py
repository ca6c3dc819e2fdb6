"""What the agent service tells the processes with rooms, which admit their agents by themselves."""

import asyncio
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from movingout.agents.errors import AgentsBusyError
from movingout.agents.worker.messages import frame
from movingout.maps import load_map
from movingout.server.agent_workers.capacity import AgentCosts
from movingout.server.processes.agent_messages import Free
from movingout.server.processes.agent_service import AgentService, StartAgents
from movingout.server.processes.shared_agents import SharedAgents

MAP = load_map("HandOff")


def open_idle(process: SharedAgents) -> None:
    """Seat an agent that needs 0.3 of a core, as the service knows."""
    process.open("idle", MAP, 0, 1, 500)


async def joined(service: AgentService) -> SharedAgents:
    """A process with rooms that has heard what is free."""
    ours, theirs = socket.socketpair()
    service.join(ours)
    process = SharedAgents()
    process.join(theirs)
    await process.joined(5.0)
    return process


async def until(there: Callable[[], bool]) -> None:
    while not there():
        await asyncio.sleep(0.001)


def test_what_one_process_has_taken_no_other_takes_for_free(tmp_path: Path) -> None:
    """Nothing is told in the background here: it would come half a second later."""

    async def run() -> None:
        service, processes = AgentService(StartAgents(1, tmp_path / "costs.json", "text", 1.0)), []
        service.pool._most = 0.8
        service.pool.costs.measured("idle", 0.3)
        for _ in range(4):
            processes.append(await joined(service))
        for process, left in zip(processes[:2], (0.5, 0.2), strict=True):
            open_idle(process)
            await until(lambda left=left: all(one._shares_left == [pytest.approx(left)] for one in processes))  # type: ignore[misc]
        for process in processes[2:]:
            with pytest.raises(AgentsBusyError, match="all at work"):
                open_idle(process)
        await processes[0].close()  # its seat is free again, which the others hear
        await until(lambda: processes[3]._shares_left == [pytest.approx(0.5)])
        open_idle(processes[3])
        await asyncio.gather(*(process.close() for process in processes[1:]))

    asyncio.run(asyncio.wait_for(run(), 20.0))


def test_workers_without_seats_take_one_costly_agent_each_and_then_what_is_safe() -> None:
    """Until the service answers, a process counts what it has admitted itself."""
    process = SharedAgents()
    process.heard(frame(Free((1e6, 0.1, 1e6), 0.8, {"bass@all": 0.9, "idle": 0.1}))[4:])
    for _ in range(2):
        process.open("bass@all", MAP, 0, 1, 500)
    with pytest.raises(AgentsBusyError, match="all at work"):
        process.open("bass@all", MAP, 0, 1, 500)
    process.open("idle", MAP, 0, 1, 500)
    with pytest.raises(AgentsBusyError, match="all at work"):
        process.open("idle", MAP, 0, 1, 500)


def test_a_process_that_has_just_started_admits_by_the_costs_that_the_service_has_kept(tmp_path: Path) -> None:
    async def run() -> None:
        costs = AgentCosts(tmp_path / "costs.json")
        costs.measured("bass@all", 0.5)
        costs.save()
        service = AgentService(StartAgents(1, tmp_path / "costs.json", "text", 1.0))
        service.pool._most = 0.8
        first, started = await joined(service), await joined(service)
        first.open("bass@all", MAP, 0, 1, 500)
        await until(lambda: started._shares_left == [pytest.approx(0.3)])
        with pytest.raises(AgentsBusyError, match="all at work"):
            started.open("bass@all", MAP, 0, 1, 500)
        await asyncio.gather(first.close(), started.close())

    asyncio.run(asyncio.wait_for(run(), 20.0))
