"""The processes behind the editor: one answer per address, a few at once, a death survived, a time limit."""

import asyncio
import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import pytest

from movingout.maps import MapSpec, load_map, map_to_json
from movingout.server.own_maps import solving, workers
from movingout.server.own_maps.workers import Busy, MapWorkers

SPEC = load_map("Simple")


def _die(path: Path) -> None:
    os._exit(1)


def run(work: object) -> None:
    asyncio.run(work)  # type: ignore[arg-type]


@pytest.mark.slow
def test_one_address_solves_one_map_at_a_time_and_others_a_few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "MOST_SOLVES", 2)

    async def work() -> None:
        pool = MapWorkers()
        try:
            first = asyncio.create_task(pool.solve(SPEC, "here"))
            other = asyncio.create_task(pool.solve(SPEC, "there"))
            await asyncio.sleep(0)
            with pytest.raises(Busy, match="your address"):
                await pool.solve(SPEC, "here")
            with pytest.raises(Busy, match="other maps"):
                await pool.solve(SPEC, "elsewhere")
            assert (await first)["solved"] and (await other)["solved"]
            assert (await pool.solve(SPEC, "here"))["solved"], "and then again"
        finally:
            await pool.close()

    run(work())


@pytest.mark.slow
def test_checks_that_pile_up_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "MOST_OF_ONE", 1)

    async def work() -> None:
        pool = MapWorkers()
        try:
            first = asyncio.create_task(pool.check(map_to_json(SPEC), "here"))
            await asyncio.sleep(0)
            with pytest.raises(Busy):
                await pool.check({}, "here")
            assert await first == (SPEC, (), ())
        finally:
            await pool.close()

    run(work())


@pytest.mark.slow
def test_a_process_that_died_is_replaced(tmp_path: Path) -> None:
    async def work() -> None:
        pool = MapWorkers()
        try:
            await pool.check({}, "here")
            (process,) = pool._pools["checks"]._processes.values()
            assert process.pid is not None
            os.kill(process.pid, signal.SIGKILL)
            assert await pool.check(map_to_json(SPEC), "here") == (SPEC, (), ())
        finally:
            await pool.close()

    run(work())


@pytest.mark.slow
def test_who_asks_while_the_process_dies_again_is_refused_and_the_next_one_is_served(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def check() -> None:
        pool = MapWorkers()
        try:
            with monkeypatch.context() as patched:
                patched.setattr(solving, "read_file", _die)
                assert "my.json cannot be looked at" in str(await pool.read_file(Path("my.json")))
            with pytest.raises(Busy, match="cannot look at maps at the moment"):
                await pool._run("checks", os._exit, 1)
            assert await pool.check(map_to_json(SPEC), "here") == (SPEC, (), ())
        finally:
            await pool.close()

    asyncio.run(check())


def test_a_map_that_takes_too_long_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, "SOLVE_S", 0.1)
    monkeypatch.setattr(solving, "rollout", lambda *_, **__: time.sleep(60))
    with pytest.raises(solving.TooSlow, match="longer than"):
        solving.solve(load_map("HandOff"))


def test_a_variant_that_cannot_be_found_in_time_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solving, "randomize", lambda *_: time.sleep(60))
    with pytest.raises(solving.TooSlow, match=r"longer than 0\.1 s"):
        solving.variant(SPEC, 3, "train", 0.1)


def test_only_maps_that_are_not_shipped_are_at_the_expense_of_an_address() -> None:
    charged: list[str] = []
    own = replace(SPEC, name="Garage")

    async def work() -> list[MapSpec]:
        pool = MapWorkers(lambda address, seconds: charged.append(address))
        try:
            return [await pool.variant(spec, 3, "train", "here") for spec in (SPEC, own)]
        finally:
            await pool.close()

    assert [spec.variant for spec in asyncio.run(work())] == ["challenge2-train-3"] * 2
    assert charged == ["here"]


def test_after_close_no_process_is_started_anew() -> None:
    async def ends() -> int:
        workers = MapWorkers()
        await workers.close()
        with pytest.raises(Busy):
            await workers.check({}, "")
        return len(workers._pools)

    assert asyncio.run(ends()) == 0
