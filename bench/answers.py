"""Arrivals and answers per second of a study in one server, with SQLite on this machine's disk.

Options: `--people N` (200), `--seconds S` (10). People are simulated in this process, AT_ONCE at a time, each waiting
for the confirmation of its last request. Beside the rate, which a busy machine lowers, the CPU time of the server.
"""

import argparse
import asyncio
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterable
from pathlib import Path
from typing import Any

import httpx

from bench import print_table
from movingout.server.study_bots.rehearsal_server import RehearsalServer, ServerAddress
from movingout.server.study_bots.study_client import StudyClient, View
from movingout.study.design.templates import template_text

AT_ONCE = 16
SPEED = 50.0  # of the rehearsal, which raises the limits of an address with it


class Page(StudyClient):
    """The page of somebody who has said what the study asks first."""

    def __init__(self, http: httpx.AsyncClient, number: int) -> None:
        super().__init__(http)
        self._number = number
        self.step: dict[str, Any] = {}

    async def come(self) -> None:
        """Open the link."""
        self._at(await self.arrive({"PROLIFIC_PID": f"bench{self._number}", "STUDY_ID": "bench"}, "en"))

    async def consent(self) -> None:
        self._at(await self.next(self.step["key"], boxes=[box["id"] for box in self.step["boxes"]]))

    async def answer_once(self) -> None:
        item = next(each for each in self.step["items"] if each["kind"] == "choice")
        await self.answer(self.step["key"], item["id"], 0, "", 1000.0)

    def _at(self, view: View) -> None:
        self.step = view["step"]


def main(options: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench answers", description=__doc__)
    parser.add_argument("--people", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=10.0)
    args = parser.parse_args(options)
    with tempfile.TemporaryDirectory(prefix="movingout-bench-") as folder:
        file = Path(folder) / "study.yaml"
        file.write_text(template_text("collect"), encoding="utf-8")
        with RehearsalServer(file, Path(folder) / "data", SPEED) as server:
            rows = asyncio.run(_measure(server.address, args.people, args.seconds))
    print_table(
        f"A study in one server, {AT_ONCE} requests at once", ["", "number", "per s", "server CPU ms each"], rows
    )


async def _measure(address: ServerAddress, people: int, seconds: float) -> list[list[str]]:
    limits = httpx.Limits(max_connections=AT_ONCE)
    async with httpx.AsyncClient(base_url=address.base, limits=limits, timeout=60.0) as http:
        pages = [Page(http, number) for number in range(people)]
        rows = [await _timed("arrivals", address, http, (page.come for page in pages))]
        await asyncio.gather(*(page.consent() for page in pages))
        rows.append(await _timed("answers", address, http, _until(seconds, pages)))
    return rows


def _until(seconds: float, pages: list[Page]) -> Iterable[Callable[[], Awaitable[None]]]:
    """Answers of one after the other, until the time is up."""
    ends = time.monotonic() + seconds
    while True:
        for page in pages:
            if time.monotonic() > ends:
                return
            yield page.answer_once


async def _timed(
    what: str, address: ServerAddress, http: httpx.AsyncClient, requests: Iterable[Callable[[], Awaitable[None]]]
) -> list[str]:
    """A row: how many there were, in a second, and what each costs the server."""
    left, done = iter(requests), 0

    async def ask() -> None:
        nonlocal done
        for request in left:
            await request()
            done += 1

    cpu_s, begun = await _cpu_s(address, http), time.monotonic()
    await asyncio.gather(*(ask() for _ in range(AT_ONCE)))
    took_s = time.monotonic() - begun
    used_s = await _cpu_s(address, http) - cpu_s
    return [what, f"{done:,}", f"{done / took_s:.0f}", f"{1e3 * used_s / done:.2f}"]


async def _cpu_s(address: ServerAddress, http: httpx.AsyncClient) -> float:
    answer = await http.get("/api/admin/state", headers={"Authorization": f"Bearer {address.admin_token}"})
    return float(answer.raise_for_status().json()["cpu_seconds"])
