"""The options of `movingout study simulate`; everything else is imported only when the command runs."""

import argparse
import importlib
from pathlib import Path
from typing import Any

from movingout.maps.extras import needs_extra
from movingout.server.options import add_options
from movingout.server.study_bots.simulation_plan import SimulationPlan


def configure(commands: Any) -> None:
    """Add `simulate` to the sub-commands of `movingout study`."""
    simulate = commands.add_parser(
        "simulate",
        help="rehearse the whole study with simulated participants: exit code 1 for lost data and faults of agents",
        example="movingout study simulate study.yaml --participants 4",
    )
    add = simulate.add_argument
    add("file", type=Path, metavar="FILE", help="the study file")
    add("--participants", type=int, metavar="N", help="how many (default: as many as the study plans)")
    add_options(simulate, SimulationPlan)
    add("--data", type=Path, metavar="DIR", help="a new folder (default: data/simulated/ID-TIME)")
    add("--kills", type=int, default=0, metavar="N", help="kill (kill -9) and restart the server N times")
    add("--url", default="", help="use this server, started with `serve --rehearse` (default: start one)")
    add("--json", action="store_true", help="print one JSON document")
    simulate.set_defaults(perform=_simulate)


def _simulate(args: argparse.Namespace) -> int:
    with needs_extra("simulate", "study simulate"):
        command = importlib.import_module("movingout.server.study_bots.commands.rehearsal_command")
    code: int = command.simulate(args)
    return code
