"""Players who come, play, drop, come back and leave at random, beside floods, while processes with rooms are killed."""

import asyncio
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import httpx
import numpy as np
import psutil
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.typing import Subprotocol

from movingout.recordings import verify
from movingout.recordings.storage.index import list_recordings
from movingout.server import messages as m
from movingout.server.frames import Bundle
from tests.server.support import make_input

ROUND_TICKS = 60
START_S, STOP_S = 120.0, 30.0  # a service manager kills a server that has not ended 30 s after SIGTERM
FINISH_S = 1800.0  # in which all rounds become recordings, after a long soak of a machine with other work
REFUSED = "refused"  # in place of a token
BACK_S = 90.0  # in which whoever was dropped must be back in the seat
SMALL_FLOODS = ("pongs", "fragments", "inputs", "connects")


@contextmanager
def server_at(
    data: Path, processes: int, environment: Mapping[str, str] | None = None
) -> Iterator[tuple[str, str, psutil.Process]]:
    """`movingout play` on a free port: its address, its admin token and its process. Its log is beside the data."""
    around = {**os.environ, **(environment or {})}
    log = data.parent / f"{data.name}.log"
    command = [sys.executable, "-P", "-m", "movingout.server.cli", "play", "--port", "0", "--data", str(data)]
    command += ["--processes", str(processes), "--countdown", "0.3"]
    with log.open("wb") as out, subprocess.Popen(command, stdout=out, stderr=out, env=around) as process:
        try:
            base, token = _printed(log, process)
            yield base, token, psutil.Process(process.pid)
        finally:
            process.terminate()
            process.wait(STOP_S)


def _printed(log: Path, process: "subprocess.Popen[bytes]") -> tuple[str, str]:
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline and process.poll() is None:
        text = log.read_text(encoding="utf-8")
        base, token = re.search(r"Play\s+(\S+)/", text), re.search(r"Admin token\s+in (.+)\n", text)
        if base and token:
            return base[1], Path(token[1]).read_text(encoding="ascii").strip()
        time.sleep(0.1)
    raise RuntimeError(f"the server did not start:\n{log.read_text(encoding='utf-8')}")


def collecting_often(folder: Path) -> dict[str, str]:
    """An environment in which all processes collect garbage every 10 s: what still grows then is a leak."""
    lines = [
        "import movingout.server.garbage_collection as collection",
        "collection.BUSY_S, collection.GROWTH_OBJECTS = 10.0, 0",
    ]
    folder.mkdir()
    (folder / "sitecustomize.py").write_text("\n".join(lines), encoding="utf-8")
    return {"PYTHONPATH": os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])}


def wait_for_recordings(recordings: Path) -> None:
    """Until a server that is still there has finished all journals, which it does when nothing else has to be done."""
    deadline = time.monotonic() + FINISH_S
    while next(recordings.glob("*.journal"), None) is not None and time.monotonic() < deadline:
        time.sleep(0.5)


def faults_of(recordings: Path) -> list[str]:
    """What is wrong with the recordings of a server that has ended: all are finished, and all verify."""
    found, damaged = list_recordings(recordings)
    faults = [f"{one.path.name}: {one.problem}" for one in damaged]
    faults += [f"{path.name} is not finished" for path in recordings.glob("*.journal")]
    return faults + [f"{one.path.name} diverges" for one in found if not verify(one.path).identical]


@dataclass
class Tally:
    """What happened, and what must not."""

    rounds: int = 0
    drops: int = 0
    leaves: int = 0
    kills: int = 0
    floods: int = 0
    lost: list[str] = field(default_factory=list)  # seats that nobody came back to, and games that did not end
    rss_mb: list[float] = field(default_factory=list)  # of all processes of the server, once a second
    open_files: list[int] = field(default_factory=list)
    at_s: list[float] = field(default_factory=list)  # when these were measured

    def mb_per_minute(self, from_s: float) -> float:
        """How memory grows from then on: the median slope between two readings, which single peaks do not change."""
        at, mb = np.array(self.at_s), np.array(self.rss_mb)
        at, mb = at[at >= from_s] / 60.0, mb[at >= from_s]
        half = len(at) // 2
        return float(np.median((mb[half : 2 * half] - mb[:half]) / (at[half : 2 * half] - at[:half])))


@dataclass
class Soak:
    """`run` plays for so many seconds with so many players, then lets every game end."""

    base: str
    admin_token: str
    server: psutil.Process
    random: Random
    tally: Tally = field(default_factory=Tally)
    _over: bool = False

    async def run(self, players: int, seconds: float, kill_every_s: float, kills_for_s: float = float("inf")) -> Tally:
        """Kills are over after `kills_for_s`: a process that has just begun hides what the one before has leaked."""
        async with httpx.AsyncClient(base_url=self.base, timeout=60.0) as http:
            games = [asyncio.create_task(self._play_on(f"127.0.1.{1 + number}")) for number in range(players)]
            beside = [self._kill(http, kill_every_s, kills_for_s), self._flood(), self._measure()]
            others = [asyncio.create_task(each) for each in beside]
            await asyncio.sleep(seconds)
            self._over = True
            for each in others:
                each.cancel()
            await asyncio.gather(*others, return_exceptions=True)
            await asyncio.gather(*games)
        return self.tally

    # ---- players ------------------------------------------------------------------------------------------------

    async def _play_on(self, address: str) -> None:
        """Rounds of one stranger, whose address has limits of its own."""
        transport = httpx.AsyncHTTPTransport(local_address=address)
        async with httpx.AsyncClient(base_url=self.base, timeout=60.0, transport=transport) as http:
            while not self._over:
                body = {"maps": ["HandOff"], "seats": [{"kind": "here"}, {"kind": "agent", "agent": "idle"}],
                        "limit_ticks": ROUND_TICKS}  # fmt: skip
                with contextlib.suppress(httpx.HTTPError):
                    answer = await http.post("/api/rooms", json=body)
                    if answer.status_code == 200:
                        room = answer.json()
                        await self._game(room["room"], room["tokens"][0], address)
                        await self._close(http, room["room"])
                        continue
                await asyncio.sleep(0.5)

    async def _close(self, http: httpx.AsyncClient, room: str) -> None:
        """A room without people stays for a quarter of an hour: as if that were over, so that the number is level."""
        headers = {"authorization": f"Bearer {self.admin_token}"}
        await http.post(f"/api/admin/rooms/{room}/close", json={}, headers=headers)

    async def _game(self, room: str, token: str, address: str) -> None:
        """One round, over as many connections as it takes."""
        loop = asyncio.get_running_loop()
        leaves, tokens, until = self.random.random() < 0.1, [token], loop.time() + BACK_S
        while loop.time() < until:
            with contextlib.suppress(OSError, InvalidHandshake, ConnectionClosed, TimeoutError):
                async with connect(
                    f"{self.base.replace('http', 'ws')}/ws/{room}",
                    subprotocols=[Subprotocol(m.SUBPROTOCOL)],
                    local_addr=(address, 0),
                ) as link:
                    await link.send(json.dumps({"type": "join", "room": room, "tokens": tokens[-1:]}))
                    if await self._connected(link, tokens, leaves):
                        self.tally.rounds += 1
                        return
                    until = loop.time() + BACK_S
            if tokens[-1].startswith(REFUSED):
                break
            await asyncio.sleep(self.random.uniform(0.05, 1.0))
        self.tally.lost.append(f"{room}: {tokens[-1] if tokens[-1].startswith(REFUSED) else 'not over in time'}")

    async def _connected(self, link: ClientConnection, tokens: list[str], leaves: bool) -> bool:
        """Play on this connection; True when the round is over, False when it was dropped."""
        drop_at, seq = self.random.randint(5, 4 * ROUND_TICKS), 0
        while True:
            frame = await asyncio.wait_for(link.recv(), 30.0)
            if isinstance(frame, str):
                if self._over_by(json.loads(frame), tokens):
                    return True
                if json.loads(frame)["type"] == "welcome":
                    await link.send(json.dumps({"type": "ready", "seat": 0, "ready": True}))
            elif frame[0] == m.BUNDLE:
                tick, seq = Bundle.decode(frame).tick, seq + 1
                if leaves and tick > ROUND_TICKS // 2:
                    self.tally.leaves += 1
                    await link.send(json.dumps({"type": "leave", "seat": 0}))
                    return True
                if seq == drop_at:
                    self.tally.drops += 1
                    link.transport.abort()
                await link.send(make_input(seq=seq, ack_tick=tick, seen_tick=tick, heading=tick / 5).encode())

    def _over_by(self, told: dict[str, Any], tokens: list[str]) -> bool:
        if told["type"] == "welcome":
            tokens += [grant["token"] for grant in told["seats"]]
            if not told["seats"]:
                tokens.append(f"{REFUSED}: no seat")
        if told["type"] == "bye" and told["code"] in (m.CLOSE_NOT_FOUND, m.CLOSE_BAD_MESSAGE, m.CLOSE_UNAUTHORISED):
            tokens.append(f"{REFUSED}: {told['code']} {told['message']}")
        return bool(told["type"] == "result")

    # ---- beside them --------------------------------------------------------------------------------------------

    async def _kill(self, http: httpx.AsyncClient, every_s: float, for_s: float) -> None:
        headers, ends = {"authorization": f"Bearer {self.admin_token}"}, time.monotonic() + for_s
        while time.monotonic() + every_s < ends:
            await asyncio.sleep(every_s)
            state = (await http.get("/api/admin/state", headers=headers)).json()
            chosen = self.random.choice([row for row in state["processes"] if row["ready"]] or [None])
            if chosen is not None:
                os.kill(chosen["pid"], signal.SIGKILL)
                self.tally.kills += 1

    async def _flood(self) -> None:
        while True:
            await asyncio.sleep(self.random.uniform(2.0, 5.0))
            name = self.random.choice(SMALL_FLOODS)
            arguments = ["-m", "tests.attacks.floods", name, self.base, "nosuchroom22"]
            flood = await asyncio.create_subprocess_exec(sys.executable, *arguments)
            self.tally.floods += 1
            try:
                await asyncio.sleep(1.0)
            finally:
                flood.kill()
                await flood.wait()

    async def _measure(self) -> None:
        begun = time.monotonic()
        while True:
            rss, files = 0.0, 0
            for process in [self.server, *self.server.children(recursive=True)]:
                with contextlib.suppress(psutil.Error):
                    rss += process.memory_info().rss / 1e6
                    files += process.num_fds()
            self.tally.at_s.append(time.monotonic() - begun)
            self.tally.rss_mb.append(rss)
            self.tally.open_files.append(files)
            await asyncio.sleep(1.0)
