"""`movingout loadtest`: measure a server with clients that speak the real protocol from another process.

Lateness is measured by the server (how long after its due time each tick began), gaps and delays by the clients.
The figures are only meaningful on an otherwise idle machine.
"""

import argparse
import asyncio
import json
import re
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from movingout.maps import MovingOutError, map_names
from movingout.server.commands.load_client import LoadClient, LoadCounts
from movingout.server.commands.orderly_end import ended_by_sigterm
from movingout.server.commands.with_parent import PROGRAM
from movingout.server.rooms.lateness import Lateness
from movingout.world.constants import MAX_TICKS

if sys.platform == "win32":  # uvloop is not available there
    from asyncio import run as run_loop
else:
    from uvloop import run as run_loop

WARM_UP_S = 2.0
INPUTS_PER_S = 10.0  # of each client; a held key sends as many, a moving gamepad 20
START_LIMIT_S = 60.0
MOST = 100_000  # rooms, clients, seconds, inputs a second
TOKEN_ADVICE = " Give it by --admin-token; it is in the file admin-token of the server's data folder."
BUSY_LIMIT_S = 20.0  # that a server may be busy before a room is opened


class LoadTestError(MovingOutError):
    """The measurement could not be made."""


class ServerBusyError(LoadTestError):
    """No room can be opened now, because running games come first."""


class RunningServer(NamedTuple):
    """A running server."""

    base: str  # http://127.0.0.1:8000
    admin_token: str

    @property
    def host_and_port(self) -> tuple[str, int]:
        address = urlsplit(self.base)
        return address.hostname or "127.0.0.1", address.port or 80


Beside = Callable[[RunningServer], Coroutine[Any, Any, None]]


def configure(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--rooms", type=number_of, default=100, metavar="N", help="rooms at the same time (%(default)s)")
    add(
        "--clients",
        type=number_of,
        default=2,
        metavar="N",
        help="clients per room; beyond two they watch (%(default)s)",
    )
    add("--seconds", type=above_0, default=30.0, metavar="S", help="how long to measure (%(default)s)")
    add(
        "--inputs",
        type=above_0,
        default=INPUTS_PER_S,
        metavar="HZ",
        help="inputs a second of each client (%(default)s)",
    )
    add(
        "--partner",
        default="idle",
        metavar="ID",
        help="agent in the other seat when a room has one client (%(default)s)",
    )
    add(
        "--url",
        type=base_address,
        help="a running server, which records what is played (seats: remote, name: bot): let it have a data folder of "
        "its own, as trainings without --seats human learn from these; without --url one is started for the test",
    )
    add("--admin-token", default="", metavar="TOKEN", help="admin token of the server at --url")
    add("--json", action="store_true", help="print one JSON document")


def number_of(text: str) -> int:
    """How many rooms, or clients in each. Raises ArgumentTypeError."""
    if not text.isdecimal() or not 1 <= int(text) <= MOST:
        raise argparse.ArgumentTypeError(f"a whole number from 1 to {MOST:,} is possible, not {text}")
    return int(text)


def above_0(text: str) -> float:
    """A time in seconds, or a rate per second. Raises ArgumentTypeError."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0.0 < number <= MOST:
        raise argparse.ArgumentTypeError(f"a number above 0 and up to {MOST:,} is possible, not {text}")
    return number


def base_address(text: str) -> str:
    """The address of a server, without a path. Raises ArgumentTypeError."""
    try:
        parts = urlsplit(text)
        is_address = parts.scheme == "http" and bool(parts.hostname) and parts.port != 0
    except ValueError:
        is_address = False
    if not is_address or parts.path.strip("/") or parts.query or parts.fragment:
        raise argparse.ArgumentTypeError(f"a server's address looks like http://127.0.0.1:8000, not {text!r}")
    return text.rstrip("/")


def run(args: argparse.Namespace) -> int:
    if args.url:
        target = RunningServer(args.url, args.admin_token)
        result = measure(target, args.rooms, args.clients, args.seconds, args.inputs, partner=args.partner)
    else:
        with running_server(args.rooms, args.clients, partner=args.partner) as target:
            result = measure(target, args.rooms, args.clients, args.seconds, args.inputs, partner=args.partner)
    print(json.dumps(result) if args.json else _table(result))
    return 0


def measure(
    target: RunningServer,
    rooms: int,
    clients: int,
    seconds: float,
    inputs_per_s: float = INPUTS_PER_S,
    beside: Beside | None = None,
    partner: str = "idle",
) -> dict[str, Any]:
    """Play in `rooms` rooms and return the fields of the load test.

    `beside` runs during the measurement (an abusive client, say) and is then cancelled. Raises LoadTestError.
    """
    try:
        return run_loop(_measure(target, rooms, clients, seconds, inputs_per_s, beside, partner))
    except OSError as error:
        reason = getattr(error, "reason", error)  # urllib wraps what happened
        raise LoadTestError(f"the server at {target.base} does not answer as expected: {reason}") from error


@contextmanager
def running_server(rooms: int, clients: int, processes: int = 1, partner: str = "") -> Iterator[RunningServer]:
    """A temporary server on a free port, with temporary data, and all rooms in so many processes.

    Its rooms may have `partner` in a seat, also when that is somebody's own code or file. Raises LoadTestError
    where it does not start.
    """
    with tempfile.TemporaryDirectory(prefix="movingout-loadtest-") as folder:
        sockets = str(rooms * clients + 100)
        command = [*PROGRAM, "play", "--port", "0", "--data", folder]
        command += ["--max-rooms", str(rooms + 10), "--max-sockets", sockets, "--processes", str(processes)]
        command += ["--partner", partner] if partner else []
        pipe = subprocess.PIPE
        with ended_by_sigterm(), subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
            try:
                yield _wait_until_ready(process)
            finally:
                process.terminate()
                process.wait(60)


def _wait_until_ready(process: "subprocess.Popen[str]") -> RunningServer:
    assert process.stdout is not None
    base = ""
    for line in process.stdout:
        if found := re.search(r"Play\s+(\S+)/", line):
            base = found[1]
        if found := re.search(r"Admin token\s+in (.+)", line):
            return RunningServer(base, Path(found[1]).read_text(encoding="ascii").strip())
    raise LoadTestError("the server did not start; `movingout play` says why")


async def _measure(
    target: RunningServer,
    rooms: int,
    clients: int,
    seconds: float,
    inputs_per_s: float,
    beside: Beside | None,
    partner: str,
) -> dict[str, Any]:
    tally = LoadCounts()
    opened: list[str] = []
    bots: list[LoadClient] = []
    other: asyncio.Task[None] | None = None
    await asyncio.to_thread(_call, target, "/api/admin/state")  # refused now rather than after the warm-up
    try:
        await _open_rooms(target, rooms, clients, partner, opened)
        await _fill_rooms(target, opened, clients, inputs_per_s, tally, bots)
        await _wait_for_play(bots, tally)
        await asyncio.sleep(WARM_UP_S)
        await asyncio.to_thread(_call, target, "/api/admin/measurements/reset", {})
        before = await asyncio.to_thread(_call, target, "/api/admin/state")
        _refuse_several_nodes(target, opened, before)
        for bot in bots:
            bot.measure()
        other = asyncio.create_task(beside(target)) if beside else None
        await asyncio.sleep(seconds)
        for bot in bots:
            bot.check()
        after = await asyncio.to_thread(_call, target, "/api/admin/state")
        _refuse_several_nodes(target, opened, after)
    finally:
        for bot in bots:
            bot.cancel()
        if other is not None:
            other.cancel()
        await asyncio.sleep(0.1)  # for the connections to close
        await asyncio.to_thread(_close_rooms, target, opened)
    return _result(rooms, clients, before, after, tally)


def _refuse_several_nodes(target: RunningServer, rooms: list[str], state: Any) -> None:
    """Raise LoadTestError if the answering node does not have all the rooms: figures are of one node only."""
    cluster = state.get("cluster")
    if cluster is None or {room[:1] for room in rooms} == {cluster["home"]}:
        return
    nodes = ", ".join(f"http://{node['address']}" for node in cluster["nodes"] if node["state"] == "serving")
    raise LoadTestError(
        f"at {target.base} are several nodes of a cluster, each with figures of its own; measure one of them: "
        f"--url with one of {nodes}"
    )


async def _open_rooms(target: RunningServer, rooms: int, clients: int, partner: str, opened: list[str]) -> None:
    """Open the rooms and append each to `opened`, which keeps the earlier ones if one is refused."""
    names = map_names()
    for index in range(rooms):
        opened.append(await _opened_room(target, names[index % len(names)], clients, partner))


def _close_rooms(target: RunningServer, rooms: list[str]) -> None:
    """A server goes on after its test, and would wait for the players of each room that was left open."""
    for room in rooms:
        try:
            _call(target, f"/api/admin/rooms/{room}/close", {})
        except LoadTestError:  # it is closed already
            continue
        except OSError:  # the server has gone: no other call would reach it
            return


async def _opened_room(target: RunningServer, name: str, clients: int, partner: str) -> str:
    """Open a room; asks again if the server is busy for a moment."""
    loop = asyncio.get_running_loop()
    deadline = loop.time() + BUSY_LIMIT_S
    while True:
        try:
            return await asyncio.to_thread(open_room, target, name, clients, partner)
        except ServerBusyError:
            if loop.time() > deadline:
                raise
        await asyncio.sleep(0.5)


async def _fill_rooms(
    target: RunningServer,
    rooms: list[str],
    clients: int,
    inputs_per_s: float,
    tally: LoadCounts,
    bots: list[LoadClient],
) -> None:
    """Connect the clients and append them to `bots`."""
    host, port = target.host_and_port
    loop = asyncio.get_running_loop()
    for room in rooms:
        for client in range(clients):
            bot = LoadClient(
                room=room,
                mode="play" if client < 2 else "watch",
                tally=tally,
                host=f"{host}:{port}",
                inputs_per_s=inputs_per_s,
            )
            await loop.create_connection(lambda bot=bot: bot, host, port)  # type: ignore[misc]
            bots.append(bot)


def open_room(target: RunningServer, name: str, clients: int, partner: str = "idle") -> str:
    """Open a room for load clients; a single client plays with the agent `partner`.

    Their seats are those of programs: what the server records of them is never taken for what people do.
    """
    other = {"kind": "remote"} if clients > 1 else {"kind": "agent", "agent": partner}
    body = {"maps": [name], "limit_ticks": MAX_TICKS, "seats": [{"kind": "remote"}, other]}
    room: str = _call(target, "/api/rooms", body)["room"]
    return room


async def _wait_for_play(bots: list[LoadClient], tally: LoadCounts) -> None:
    deadline = asyncio.get_running_loop().time() + START_LIMIT_S
    while tally.playing < len(bots):
        if asyncio.get_running_loop().time() > deadline:
            raise LoadTestError(f"only {tally.playing} of {len(bots)} clients came to play; closed: {tally.closed}")
        await asyncio.sleep(0.1)


def _call(target: RunningServer, path: str, body: object = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    headers = {"content-type": "application/json", "authorization": f"Bearer {target.admin_token}"}
    request = urllib.request.Request(target.base + path, data, headers)
    try:
        with urllib.request.urlopen(request, timeout=30) as answer:
            return json.load(answer)
    except urllib.error.HTTPError as error:
        text = error.read().decode(errors="replace")
        kind = ServerBusyError if '"refusal":"busy"' in text else LoadTestError
        advice = TOKEN_ADVICE if error.code in (401, 403) else ""
        raise kind(f"{path} answers {error.code}: {_reason(text)}{advice}") from None


def _reason(text: str) -> str:
    """The sentence in a refusal; the whole answer if it has none."""
    try:
        return str(json.loads(text)["error"]["message"])
    except (ValueError, TypeError, KeyError):
        return text


def _result(rooms: int, clients: int, before: Any, after: Any, tally: LoadCounts) -> dict[str, Any]:
    seconds = after["uptime_s"] - before["uptime_s"]
    delays = Lateness()
    for delay in tally.delays_ms:
        delays.add(max(0.0, delay), 0)
    return {
        "rooms": rooms,
        "clients": clients,
        "seconds": round(seconds, 1),
        "ticks": after["ticks"] - before["ticks"],
        "missed_ticks": after["missed_ticks"] - before["missed_ticks"],
        "late_ms": after["late_ms"],
        "bytes_per_client_s": round((after["bytes_sent"] - before["bytes_sent"]) / (rooms * clients * seconds)),
        "cpu_percent": round(100 * (after["cpu_seconds"] - before["cpu_seconds"]) / seconds, 1),
        "busiest_percent": after["cpu_percent"],  # of the process with rooms that has most to do, at the end
        "rss_mb": after["rss_mb"],
        "deadline_misses": after["deadline_misses"] - before["deadline_misses"],
        "bundles": tally.bundles,
        "client_gaps": tally.gaps,
        "client_delay_ms": delays.report(),
        "closed": tally.closed,
    }


def _table(result: dict[str, Any]) -> str:
    return "\n".join(f"{name:20} {value}" for name, value in result.items())
