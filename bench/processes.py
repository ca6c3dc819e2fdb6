"""Rooms in two processes beside the same rooms in one: how late ticks are, and what the busiest event loop has to do.

The runs alternate, so that other load on the machine meets both. Bots play from this process.
"""

import json
import statistics
from collections.abc import Callable
from typing import Any

from bench.server import canary
from movingout.server.commands.loadtest import measure, running_server

ROOMS = 100
CLIENTS = 2
SECONDS = 15.0
PAIRS = 3


def main() -> None:
    print(f"canary: {json.dumps(canary())}")
    found: dict[int, list[dict[str, Any]]] = {1: [], 2: []}
    for _ in range(PAIRS):
        for processes, results in found.items():
            with running_server(ROOMS, CLIENTS, processes) as target:
                results.append(measure(target, ROOMS, CLIENTS, SECONDS))
    print(f"\n{ROOMS} rooms x {CLIENTS}, medians of {PAIRS} runs of {SECONDS:g} s each\n")
    print("| | one process | two processes |\n|---|---|---|")
    for name, value in ROWS.items():
        medians = [statistics.median(value(result) for result in found[processes]) for processes in (1, 2)]
        print(f"| {name} | {medians[0]:.2f} | {medians[1]:.2f} |")


ROWS: dict[str, Callable[[dict[str, Any]], float]] = {
    "late p50 [ms]": lambda result: result["late_ms"]["p50"],
    "late p99 [ms]": lambda result: result["late_ms"]["p99"],
    "ticks missed [%]": lambda result: 100 * result["missed_ticks"] / (result["ticks"] + result["missed_ticks"]),
    "share of a core, busiest process with rooms [%]": lambda result: result["busiest_percent"],
    "share of a core, all processes with rooms [%]": lambda result: result["cpu_percent"],
    "CPU per tick [ms]": lambda result: 10 * result["cpu_percent"] * result["seconds"] / result["ticks"],
    "gaps at clients": lambda result: result["client_gaps"],
}
