"""A study under full load: 16 participants at once in 8 rooms, with the dashboard open.

Lateness is measured by the server over SECONDS in which all rooms play. Participants are simulated in this process,
each with its event stream, requests and game; the dashboard reads its stream as the page does. Run nothing else:
`canary` shows how late an idle loop wakes up.
"""

import asyncio
import contextlib
import json
import tempfile
from pathlib import Path
from typing import Any

import httpx

from bench.server import canary
from movingout.server.study_bots.cohort import Cohort
from movingout.server.study_bots.rehearsal_server import RehearsalServer, ServerAddress
from movingout.server.study_bots.simulation_plan import SimulationPlan
from movingout.study.design.templates import template_text

PAIRS = 8
SECONDS = 30.0
WARM_UP_S = 2.0
P99_MS = 5.0
START_LIMIT_S = 120.0
CHANGES = {
    "limit_ticks: 500": "limit_ticks: 3000",
    "practice: tutorial": "practice: {map: Simple, limit_ticks: 20}",
}  # long rounds, no practice


def main() -> None:
    print(f"canary: {json.dumps(canary())}")
    text = template_text("collect")
    for old, new in CHANGES.items():
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory(prefix="movingout-bench-") as folder:
        file = Path(folder) / "study.yaml"
        file.write_text(text, encoding="utf-8")
        with RehearsalServer(file, Path(folder) / "data", 1.0) as server:
            _print(asyncio.run(_measure(server.address)))


async def _measure(address: ServerAddress) -> dict[str, Any]:
    cohort = Cohort(address.base, SimulationPlan(2 * PAIRS, scripted=False))
    headers = {"Authorization": f"Bearer {address.admin_token}"}
    async with httpx.AsyncClient(base_url=address.base, headers=headers, timeout=30.0) as http:
        taking_part = asyncio.create_task(cohort.take_part())
        watching = asyncio.create_task(_watch(http))
        try:
            await _until_all_play(http, taking_part)
            await asyncio.sleep(WARM_UP_S)
            await http.post("/api/admin/measurements/reset", json={})
            before = await _state(http)
            await asyncio.sleep(SECONDS)
            after = await _state(http)
        finally:
            for task in (taking_part, watching):
                task.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await task
    seconds = after["uptime_s"] - before["uptime_s"]
    return {
        "participants": 2 * PAIRS,
        "rooms": PAIRS,
        "seconds": round(seconds, 1),
        "ticks": after["ticks"] - before["ticks"],
        "missed_ticks": after["missed_ticks"] - before["missed_ticks"],
        "late_ms": after["late_ms"],
        "cpu_percent": round(100 * (after["cpu_seconds"] - before["cpu_seconds"]) / seconds, 1),
        "rss_mb": after["rss_mb"],
    }


async def _watch(http: httpx.AsyncClient) -> None:
    """Read the dashboard's event stream until cancelled."""
    async with http.stream("GET", "/api/experimenter/live", timeout=None) as stream:
        async for _ in stream.aiter_lines():
            pass


async def _until_all_play(http: httpx.AsyncClient, taking_part: "asyncio.Task[Any]") -> None:
    async with asyncio.timeout(START_LIMIT_S):
        while not taking_part.done():
            rooms = (await _state(http))["rooms"]
            if len(rooms) == PAIRS and all(room["phase"] == "playing" for room in rooms):
                return
            await asyncio.sleep(0.5)
    await taking_part


async def _state(http: httpx.AsyncClient) -> dict[str, Any]:
    answer = await http.get("/api/admin/state")
    state: dict[str, Any] = answer.raise_for_status().json()
    return state


def _print(result: dict[str, Any]) -> None:
    reached = result["late_ms"]["p99"] < P99_MS and result["missed_ticks"] == 0
    print(f"study: {'reached' if reached else 'NOT reached'} (p99 < {P99_MS:g} ms, none missed)")
    print(f"  {json.dumps(result)}")
