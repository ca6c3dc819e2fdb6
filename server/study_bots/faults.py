"""What goes wrong on the participant's side of a rehearsal, drawn from a seed."""

from dataclasses import dataclass
from random import Random


@dataclass
class FaultInjection:
    """How often each thing happens; all zero: nothing goes wrong."""

    random: Random
    reloads: float = 0.0  # per step: the page is loaded again
    twice: float = 0.0  # per step: a button is clicked twice
    drops: float = 0.0  # per tick: the connection of the game breaks
    late: float = 0.0  # per step: nobody sits there for a while
    late_s: float = 0.0  # at most, for so long
    leaves: float = 0.0  # per step: the participant stops

    def happens(self, share: float) -> bool:
        return share > 0 and self.random.random() < share

    def absence_s(self) -> float:
        return self.random.uniform(0, self.late_s) if self.happens(self.late) else 0.0


def chaos(random: Random) -> FaultInjection:
    """Everything, and often."""
    return FaultInjection(random, reloads=0.15, twice=0.1, drops=0.004, late=0.1, late_s=2.0, leaves=0.001)
