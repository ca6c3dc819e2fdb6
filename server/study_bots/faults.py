"""Faults on the participant's side of a rehearsal, drawn from a seed."""

from dataclasses import dataclass
from random import Random


@dataclass
class FaultInjection:
    """The probability of each fault; none by default."""

    random: Random
    reloads: float = 0.0  # per step: the page is reloaded
    twice: float = 0.0  # per step: a button is clicked twice
    drops: float = 0.0  # per tick: the connection of the game breaks
    late: float = 0.0  # per step: the participant is away for a while
    late_s: float = 0.0  # at most
    leaves: float = 0.0  # per step: the participant stops

    def happens(self, share: float) -> bool:
        return share > 0 and self.random.random() < share

    def absence_s(self) -> float:
        return self.random.uniform(0, self.late_s) if self.happens(self.late) else 0.0


def chaos(random: Random) -> FaultInjection:
    """Every fault, often."""
    return FaultInjection(random, reloads=0.15, twice=0.1, drops=0.004, late=0.1, late_s=2.0, leaves=0.001)
