"""Facts of many episodes, added up per map, as designed or varied, and population."""

import re
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from movingout.maps.files.map_versions import designed_identity, numbered_map, numbered_maps, variant_family
from movingout.maps.spec import MapSpec
from movingout.recordings.occupancy import CELLS
from movingout.recordings.report.facts import EpisodeFacts, Pair
from movingout.recordings.report.failures import CASES, Case, Failure
from movingout.recordings.report.track import Ints
from movingout.recordings.report.waiting import Wait
from movingout.recordings.storage.listing import Unreadable
from movingout.world.constants import TICK_SECONDS, TICKS_PER_SECOND
from movingout.world.estimates import Estimate, estimate_of_copies
from movingout.world.metrics import METRICS
from movingout.world.own_metrics import own_metrics
from movingout.world.state import Floats

_COMPUTED = tuple(metric.key for metric in (*METRICS, *own_metrics()))
_SCRIPTED = re.compile(r"(person:name=[A-C])\d\d\Z")
MEASURES = ("success", "seconds", *_COMPUTED)


Valued = tuple[str, float]
"""An episode, by what its copies share, and a value of it."""


class Strip(NamedTuple):
    """The waits of one episode."""

    id: str
    ticks: int
    waits: tuple[Wait, ...]


@dataclass(eq=False)
class Group:
    """The episodes of one population on one map as designed, or on variants of it."""

    map: MapSpec  # of the first episode
    population: Pair
    file: str = ""  # that of the first episode
    values: dict[str, list[Valued]] = field(default_factory=lambda: {name: [] for name in MEASURES})
    presence: Floats = field(default_factory=lambda: np.zeros((2, CELLS, CELLS)))  # seconds
    consistency: Floats = field(default_factory=lambda: np.zeros((0, 2)))  # per second: sum, count
    waiting: Floats = field(default_factory=lambda: np.zeros((0, 2)))  # per second and seat: episodes' ticks waited
    running: Floats = field(default_factory=lambda: np.zeros((0, 1)))  # per second: episodes' ticks played
    strips: list[Strip] = field(default_factory=list)
    variants: set[str] = field(default_factory=set)
    played: set[str] = field(default_factory=set)

    def add(self, facts: EpisodeFacts) -> None:
        """Add a finished episode."""
        played = _played(facts)
        self.values["success"].append((played, float(facts.outcome == "delivered")))
        self.values["seconds"].append((played, facts.ticks * TICK_SECONDS))
        for key in _COMPUTED:
            if (value := facts.metrics[key]) is not None:
                self.values[key].append((played, value))
        self.presence += facts.presence
        self.consistency = _sum(self.consistency, facts.consistency)
        self.waiting = _sum(self.waiting, _per_second([_ticks_waited(facts, seat) for seat in (0, 1)], facts.ticks))
        self.running = _sum(self.running, _per_second([np.arange(facts.ticks)], facts.ticks))
        self.strips.append(Strip(facts.id, facts.ticks, facts.waits))
        self.variants.add(facts.map.variant)
        self.played.add(played)

    @property
    def n(self) -> int:
        return len(self.strips)

    @property
    def challenge(self) -> int:
        return 2 if self.map.variant else 1

    @property
    def distinct(self) -> int:
        """How many of them differ: agents in which nothing is drawn play the same episode again."""
        return len(self.played)

    def estimate(self, measure: str) -> Estimate | None:
        return estimate_of_copies(self.values[measure])

    def consistency_over_time(self) -> Floats:
        """(S,) mean action consistency in each second, NaN where nothing was carried together."""
        sums, counts = self.consistency.T
        return np.where(counts > 0, sums / np.maximum(counts, 1.0), np.nan)

    def waiting_over_time(self) -> Floats:
        """(S, 2) share of the played time that blue and red waited, in each second."""
        share: Floats = self.waiting / np.maximum(self.running, 1.0)
        return share

    def longest_waits(self, count: int) -> list[Strip]:
        """The episodes with the most waiting, longest first; none without waiting."""
        waited = [strip for strip in self.strips if strip.waits]
        return sorted(waited, key=lambda strip: -sum(wait.seconds for wait in strip.waits))[:count]


class FailureFinding(NamedTuple):
    """A failure with the episode it happened in."""

    facts: EpisodeFacts
    failure: Failure

    @property
    def who(self) -> str:
        return self.facts.population[self.failure.seat]


@dataclass(eq=False)
class ReportTally:
    """Everything that a report shows."""

    groups: dict[tuple[Hashable, Pair], Group] = field(default_factory=dict)
    found: list[FailureFinding] = field(default_factory=list)
    unreadable: list[Unreadable] = field(default_factory=list)
    tutorials: int = 0  # recordings of tutorials, of which nothing else is shown
    uncounted: int = 0  # recordings that their study does not count
    copies: int = 0  # of recordings that are shown
    simulated: int = 0  # recordings of rehearsals, whose participants were programs
    unfinished: int = 0  # episodes that were neither delivered nor ran out of time
    first: str = ""  # start of the earliest and of the latest recording
    last: str = ""
    appearances: dict[str, int] = field(default_factory=dict)  # seats taken in finished episodes
    agents: dict[str, set[str]] = field(
        default_factory=dict
    )  # in finished episodes: whom a member of a population names
    _affected: dict[tuple[str, Case], list[Valued]] = field(default_factory=dict)  # 1.0 or 0.0 for each of them

    @classmethod
    def of(cls, all_facts: Iterable[EpisodeFacts | Unreadable], uncounted: int = 0, copies: int = 0) -> "ReportTally":
        """What is shown of these; `uncounted` and `copies` were left out before."""
        tally = cls(uncounted=uncounted, copies=copies)
        for facts in all_facts:
            if isinstance(facts, Unreadable):
                tally.unreadable.append(facts)
            elif facts.tutorial:
                tally.tutorials += 1
            else:
                tally._add(facts)
        return tally

    @property
    def episodes(self) -> int:
        """How many episodes enter averages."""
        return sum(group.n for group in self.groups.values())

    @property
    def has_alike(self) -> bool:
        """Whether some episodes are equal to others, action by action."""
        return any(group.distinct < group.n for group in self.groups.values())

    @property
    def populations(self) -> list[Pair]:
        return sorted({population for _, population in self.groups})

    @property
    def challenges(self) -> set[int]:
        """1 for maps as designed, 2 for varied ones."""
        return {group.challenge for group in self.groups.values()}

    @property
    def maps_of_one_name(self) -> dict[str, list[str]]:
        """Of each name that different maps have, the first files of each: `by_map` calls them NAME.1, NAME.2, …."""
        return self._numbered()[1]

    def by_map(self) -> list[tuple[MapSpec, list[Group]]]:
        """The groups of each map, as designed and then varied: the paper's twelve in their order, then others by name.

        A map is that of a first episode; of different maps of one name it has the number in its name and title.
        """
        order = {pair: place for place, pair in enumerate(self.populations)}
        found: dict[tuple[str, int], list[Group]] = {}
        specs: dict[tuple[str, int], MapSpec] = {}
        for group, number in zip(self.groups.values(), self._numbered()[0], strict=True):
            spec = numbered_map(group.map, number)
            specs.setdefault((spec.name, group.challenge), spec)
            found.setdefault((spec.name, group.challenge), []).append(group)
        keys = sorted(specs, key=lambda key: (specs[key].number == 0, specs[key].number, key))
        return [(specs[key], sorted(found[key], key=lambda group: order[group.population])) for key in keys]

    def _numbered(self) -> tuple[list[str], dict[str, list[str]]]:
        return numbered_maps((group.map, group.file) for group in self.groups.values())

    def overall(self, measure: str) -> Estimate | None:
        return estimate_of_copies([one for group in self.groups.values() for one in group.values[measure]])

    def failures_of(self, case: Case) -> list[FailureFinding]:
        """The findings of a case, the longest first."""
        return sorted((one for one in self.found if one.failure.case == case), key=lambda one: -one.failure.seconds)

    @property
    def people(self) -> list[str]:
        """The labels of all who took a seat."""
        return sorted(self.appearances)

    @property
    def pooled(self) -> dict[str, list[str]]:
        """Those who stand for several agents, such as `onnx` for policies of several files, and the ids of these.

        Scripted people of one population are one agent here: who names `people:A` asks for all of them.
        """
        several = {who for who, ids in self.agents.items() if len({_SCRIPTED.sub(r"\1", one) for one in ids}) > 1}
        return {who: sorted(self.agents[who]) for who in sorted(several)}

    def rate(self, who: str, case: Case) -> Estimate | None:
        """The share of its appearances (an episode and a seat) with such a failure."""
        return estimate_of_copies(self._affected[who, case])

    def _add(self, facts: EpisodeFacts) -> None:
        self.first = min(self.first or facts.started, facts.started)
        self.last = max(self.last, facts.started)
        self.simulated += facts.simulated
        self.found += [FailureFinding(facts, failure) for failure in facts.failures]
        if not facts.finished:
            self.unfinished += 1
            return
        played_on = ("varied", variant_family(facts.map)) if facts.map.variant else designed_identity(facts.map)
        group = Group(facts.map, facts.population, facts.path.name)
        self.groups.setdefault((played_on, facts.population), group).add(facts)
        self._count_failures(facts)

    def _count_failures(self, facts: EpisodeFacts) -> None:
        for seat, who in enumerate(facts.population):
            self.appearances[who] = self.appearances.get(who, 0) + 1
            self.agents.setdefault(who, set()).update(filter(None, [facts.agents[seat]]))
            for case in CASES:
                affected = any(failure.case == case and failure.seat == seat for failure in facts.failures)
                appearance = f"{_played(facts)} {seat}", float(affected)
                self._affected.setdefault((who, case), []).append(appearance)


def _played(facts: EpisodeFacts) -> str:
    """What copies of an episode share."""
    return facts.played or facts.id


def _ticks_waited(facts: EpisodeFacts, seat: int) -> Ints:
    """The ticks in which a seat waited."""
    stretches = [np.arange(wait.start, wait.end) for wait in facts.waits if wait.seat == seat]
    return np.concatenate([np.zeros(0, dtype=np.int64), *stretches])


def _per_second(ticks: Sequence[Ints], length: int) -> Floats:
    """(S, C) how many of the ticks of each column fall into each second."""
    bins = -(-length // TICKS_PER_SECOND)
    counts = [np.bincount(column // TICKS_PER_SECOND, minlength=bins) for column in ticks]
    return np.array(counts, dtype=np.float64).T


def _sum(one: Floats, other: Floats) -> Floats:
    """The sum of two tables of different length, the shorter one filled up with zeros."""
    longer, shorter = (one, other) if len(one) >= len(other) else (other, one)
    total = longer.copy()
    total[: len(shorter)] += shorter
    return total
