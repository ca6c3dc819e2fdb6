"""What stands in a cell of our tables: the mean over matches, a measurement, or a reason why it is empty.

A cell is a value; it says which agents it needs and which matches, and finds its number once they are there.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import product
from typing import NamedTuple, Protocol

from movingout.maps import map_names
from movingout.matches.match import Challenge, Match
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.methods import with_seed
from movingout.matches.paper.workspace import Measured, Workspace
from movingout.matches.results.table import MEASURES, Measure, distinct, estimate_of
from movingout.world.estimates import Estimate

WAITING = Measure("waiting_share", "WT [share]", False, lambda result: result.waiting_share, "Waiting time")
PLAYED = {measure.key: measure for measure in (*MEASURES, WAITING)}


class Found(NamedTuple):
    """Our number in a cell."""

    estimate: Estimate | None  # None where what was played has no such value, as AC where nobody carried together
    distinct: int | None = None  # different episodes among those played; None where nothing was played, or unknown


class PaperCell(Protocol):
    """A cell of our tables."""

    @property
    def agents(self) -> tuple[str, ...]:
        """Ids of trained agents, without options and seeds."""

    def found(self, space: Workspace) -> Found | None:
        """The number; None where not everything has been played or measured yet."""


@dataclass(frozen=True, slots=True)
class EmptyCell:
    """Nothing is measured here, and why."""

    reason: str
    agents: tuple[str, ...] = ()

    def found(self, space: Workspace) -> Found | None:
        return None


class Play(NamedTuple):
    """Who plays with whom, by ids of trained agents with options."""

    agent: str
    partner: str = ""  # empty: another instance of itself

    @property
    def seats(self) -> list[tuple[str, str]]:
        """Blue and red; both orders where the two differ."""
        if not self.partner:
            return [(self.agent, self.agent)]
        return [(self.agent, self.partner), (self.partner, self.agent)]


@dataclass(frozen=True, slots=True)
class PlayedCell:
    """The mean of a measure over matches; all plays, maps, seats, seeds and trainings are pooled."""

    plays: tuple[Play, ...]
    challenge: int
    measure: str
    maps: tuple[str, ...] = ()  # empty: the twelve

    @property
    def agents(self) -> tuple[str, ...]:
        ids = (agent_id.partition(":")[0] for play in self.plays for agent_id in play.seats[0])
        return tuple(dict.fromkeys(ids))

    def matches(self, space: Workspace) -> list[Match]:
        """Per pair, map and training as many as the budget says, in both seats where the two differ.

        Officially, who learned from varied maps is evaluated on the maps as designed.
        """
        varied = self.challenge == 2 and space.evaluation == "held-out"
        challenge: Challenge = 2 if varied else 1
        pairs = [seats for play in self.plays for seats in play.seats]
        budget = space.budget
        sizes = range(budget.trainings), self.maps or map_names(), range(budget.seeds)
        return [
            Match(name, with_seed(blue, training), with_seed(red, training), seed, challenge, budget.ticks)
            for (blue, red), training, name, seed in product(pairs, *sizes)
        ]

    def found(self, space: Workspace) -> Found | None:
        matches = self.matches(space)
        results = [result for match in matches if (result := space.result(match)) is not None]
        if len(results) < len(matches):
            return None
        return Found(estimate_of(results, PLAYED[self.measure]), distinct(results))


@dataclass(frozen=True, slots=True)
class PooledCell:
    """The mean over the matches of several cells: where every map has agents of its own."""

    parts: tuple[PlayedCell, ...]

    @property
    def agents(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(agent for part in self.parts for agent in part.agents))

    def found(self, space: Workspace) -> Found | None:
        matches = [match for part in self.parts for match in part.matches(space)]
        results = [result for match in matches if (result := space.result(match)) is not None]
        if len(results) < len(matches):
            return None
        return Found(estimate_of(results, PLAYED[self.parts[0].measure]), distinct(results))


@dataclass(frozen=True, slots=True)
class Measurement:
    """Something that is measured once and kept under a name."""

    name: str  # of its file
    about: str  # for people who wait for it
    perform: Callable[[Workspace], Measured] = field(compare=False)
    agents: tuple[str, ...] = ()
    data: tuple[str, ...] = ()  # the episodes that it reads: names of `methods.DATA_SETS`
    seconds: Callable[[Budget], float] = field(default=lambda budget: 60.0, compare=False)  # of one core, roughly


@dataclass(frozen=True, slots=True)
class MeasuredCell:
    """One number of a measurement."""

    measurement: Measurement
    field: str
    may_lack: bool = False  # whether it has no value where what it counts never happened

    @property
    def agents(self) -> tuple[str, ...]:
        return self.measurement.agents

    def found(self, space: Workspace) -> Found | None:
        numbers = space.measured(self.measurement.name)
        if numbers is None or (self.field not in numbers and not self.may_lack):
            return None
        return Found(numbers.get(self.field))
