"""What honest rooms lose beside floods: ticks missed and lateness, in pairs with and without each flood.

Options: `--rooms N` (20), `--seconds S` (8), `--floods NAME ...` (all). The floods come from processes of their own and
from another loopback address, and take a core of the same machine: on few cores, part of what is measured is the
attacker's own appetite.
"""

import argparse
from typing import Any

from movingout.server.commands.loadtest import running_server
from tests.attacks.beside import measured
from tests.attacks.floods import FLOODS


def main(options: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="python -m bench attacks", description=__doc__)
    parser.add_argument("--floods", nargs="+", choices=sorted(FLOODS), default=sorted(FLOODS))
    parser.add_argument("--rooms", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=8.0)
    args = parser.parse_args(options)
    print("| flood | ticks | missed | gaps | p50 | p99 | p99.9 (ms late) | p99 without | CPU of a core |")
    print("|---|---|---|---|---|---|---|---|---|")
    for flood in args.floods:
        with running_server(args.rooms, 2) as target:
            alone = measured(target, "", args.rooms, args.seconds)
        with running_server(args.rooms, 2) as target:
            beside = measured(target, flood, args.rooms, args.seconds)
        print(_row(flood, alone, beside), flush=True)


def _row(flood: str, alone: dict[str, Any], beside: dict[str, Any]) -> str:
    late = beside["late_ms"]
    cells = [flood, beside["ticks"], f"{beside['missed_ticks']} ({alone['missed_ticks']})", beside["client_gaps"]]
    cells += [late["p50"], late["p99"], late["p999"], alone["late_ms"]["p99"], f"{beside['cpu_percent']} %"]
    return "| " + " | ".join(str(cell) for cell in cells) + " |"
