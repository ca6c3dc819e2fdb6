"""What stands in a cell of our tables: the mean over matches, a measurement, or a reason why it is empty.

A cell is a value; it says which agents it needs and which matches, and finds its number once they are there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import NamedTuple, Protocol

from movingout.maps import map_names
from movingout.matches.match import Challenge, Match, MatchResult
from movingout.matches.paper.budgets import Budget
from movingout.matches.paper.methods import with_seed
from movingout.matches.paper.pooling import between, fields, pooled
from movingout.matches.paper.workspace import Measured, Workspace
from movingout.matches.results.table import MEASURES, OFFICIAL_AC, WAITING, of_matches
from movingout.world.estimates import Estimate

PLAYED = {measure.key: measure for measure in (*MEASURES, WAITING, OFFICIAL_AC)}


class Found(NamedTuple):
    """Our number in a cell."""

    estimate: Estimate | None  # None where what was played has no such value, as AC where nobody carried together
    distinct: int | None = None  # different episodes among those played; None where nothing was played, or unknown
    between: Estimate | None = None  # over the means of trainings, where there are several
    defined: float | str | None = None  # a setting, which is not measured


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


@dataclass(frozen=True, slots=True)
class DefinedCell:
    """A setting of this project, beside the paper's."""

    value: float | str
    agents: tuple[str, ...] = ()

    def found(self, space: Workspace) -> Found | None:
        return Found(None, defined=self.value)


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
        """Per pair, map and training as many as the budget says, in both seats where the two differ."""
        return [match for training in range(space.budget.trainings) for match in self.of_training(training, space)]

    def of_training(self, training: int, space: Workspace) -> list[Match]:
        """The matches of one training.

        Officially, who learned from varied maps is evaluated on the maps as designed.
        """
        varied = self.challenge == 2 and space.evaluation == "held-out"
        challenge: Challenge = 2 if varied else 1
        pairs = [seats for play in self.plays for seats in play.seats]
        budget = space.budget
        return [
            Match(name, with_seed(blue, training), with_seed(red, training), seed, challenge, budget.ticks)
            for (blue, red), name, seed in product(pairs, self.maps or map_names(), range(budget.seeds))
        ]

    def found(self, space: Workspace) -> Found | None:
        return _found([self], space)


@dataclass(frozen=True, slots=True)
class PooledCell:
    """The mean over the matches of several cells: where every map has agents of its own."""

    parts: tuple[PlayedCell, ...]

    @property
    def agents(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(agent for part in self.parts for agent in part.agents))

    def found(self, space: Workspace) -> Found | None:
        return _found(self.parts, space)


def _found(parts: Sequence[PlayedCell], space: Workspace) -> Found | None:
    """The mean over all matches, and over the means of trainings; None where one has not been played."""
    measure = PLAYED[parts[0].measure]
    groups: list[list[MatchResult]] = []
    for training in range(space.budget.trainings):
        matches = [match for part in parts for match in part.of_training(training, space)]
        groups.append([result for match in matches if (result := space.result(match)) is not None])
        if len(groups[-1]) < len(matches):
            return None
    estimate, count = of_matches([result for group in groups for result in group], measure)
    return Found(estimate, count, between(of_matches(group, measure)[0] for group in groups))


@dataclass(frozen=True, slots=True)
class Measurement:
    """Something that is measured once, or of every training, and kept under a name."""

    name: str  # of its file, for the first training
    about: str  # for people who wait for it
    perform: Callable[[Workspace, int], Measured] = field(compare=False)  # of a training, counted from 0
    agents: tuple[str, ...] = ()
    data: tuple[str, ...] = ()  # the episodes that it reads: names of `methods.DATA_SETS`
    seconds: Callable[[Budget], float] = field(default=lambda budget: 60.0, compare=False)  # of one core, roughly
    repeated: bool = False  # whether every training is measured, else the first alone
    pool: Callable[[Sequence[Estimate]], Estimate] = field(default=pooled, compare=False)  # of trainings

    episodes: Callable[[Budget], int] = field(default=lambda budget: 0, compare=False)  # where they grow with --seeds
    samples: Callable[[Budget], int | None] = field(default=lambda budget: None, compare=False)  # that are drawn

    def trainings(self, budget: Budget) -> range:
        return range(budget.trainings if self.repeated else 1)

    def name_of(self, training: int) -> str:
        return f"{self.name}-{training}" if training else self.name

    def about_of(self, training: int) -> str:
        return f"{self.about}, training {training + 1}" if training else self.about

    def agents_of(self, training: int) -> tuple[str, ...]:
        return tuple(with_seed(agent_id, training) for agent_id in self.agents)

    def measured(self, training: int, space: Workspace) -> Measured | None:
        """What was found with the present weights, versions and numbers of episodes and samples."""
        return space.measured(self.name_of(training), self.agents_of(training), *self._sizes(space.budget))

    def measure(self, training: int, space: Workspace) -> None:
        """Find it, and keep it."""
        numbers = self.perform(space, training)
        space.keep(self.name_of(training), numbers, self.agents_of(training), *self._sizes(space.budget))

    def _sizes(self, budget: Budget) -> tuple[int, int | None]:
        return self.episodes(budget), self.samples(budget)

    def of_all(self, space: Workspace) -> list[Measured] | None:
        """What was found of every training; None where one has not been measured."""
        found = [self.measured(training, space) for training in self.trainings(space.budget)]
        there = [numbers for numbers in found if numbers is not None]
        return there if len(there) == len(found) else None


@dataclass(frozen=True, slots=True)
class MeasuredCell:
    """One number of a measurement."""

    measurement: Measurement
    field: str
    may_lack: bool = False  # whether it has no value where what it counts never happened
    of_first: bool = False  # whether it is the same for every training, so that only the first counts

    @property
    def agents(self) -> tuple[str, ...]:
        return self.measurement.agents

    def found(self, space: Workspace) -> Found | None:
        measured = self.measurement.of_all(space)
        if measured is None:
            return None
        measured = measured[:1] if self.of_first else measured
        parts = fields(measured, self.field)
        if not parts or (len(parts) < len(measured) and not self.may_lack):
            return Found(None) if self.may_lack else None
        return Found(self.measurement.pool(parts), between=between(parts))
