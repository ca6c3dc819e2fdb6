"""What is simulated in a rehearsal: how many participants there are and how they behave. Also the command's options."""

import argparse
from dataclasses import dataclass

from movingout.server.options import option

MAX_SPEED = 20.0  # a tick of 5 ms; the server cannot keep up with less


def speed_factor(text: str) -> float:
    """A speed from the command line: a number, or "max". Raises ArgumentTypeError."""
    speed = MAX_SPEED if text == "max" else float(text)
    if not 0.1 <= speed <= MAX_SPEED:
        raise argparse.ArgumentTypeError(f"the speed must be from 0.1 to {MAX_SPEED:g}, or max")
    return speed


@dataclass(frozen=True)
class SimulationPlan:
    """How many participants there are, how they behave, and whether their server lets slow agents play."""

    participants: int
    speed: float = option(1.0, "how many times as fast as people (default: 1)", metavar="N|max", parse=speed_factor)
    seed: int = option(0, "seed of answers, players and faults (%(default)s)", parse=int)
    at_once: int = option(16, "participants at the same time (%(default)s)", metavar="N", parse=int)
    chaos: bool = option(
        False, "add reloads, broken connections, double clicks, absences and participants who stop", parse=None
    )
    slow_agents: bool = option(
        False,
        "start the server with --slow-agents: partners that decide too slowly here play and miss ticks",
        parse=None,
    )
    scripted: bool = True  # seats are played by scripted people, else by robots that drive in circles
    run: str = ""  # part of the names, so that two rehearsals have different participants
    group: int = 1  # participants per unit
