"""Scripted people in three populations that play in different ways: A and B to learn from, C to be tested with.

A participant is one style, drawn once and kept for all its episodes. The populations differ in strategy, not only in
skill, and no style of one lies in the region of another:

| | what first | which item | speed | sees the partner late by | steering noise | keeps off walls |
|---|---|---|---|---|---|---|
| A | what needs two | the nearest | 0.95-1 | 0-1 ticks | 0-0.03 rad | little |
| B | what one can carry | the farthest | 0.80-0.88 | 3-5 ticks | 0.08-0.15 rad | much |
| C | like A, every second like B | like B, every second like A | 0.89-0.94 | 2 ticks | 0.04-0.07 rad | somewhat |

C is never trained on.
"""

import hashlib
import json
from dataclasses import dataclass
from random import Random

from agents.errors import DataError
from agents.scripted.style import Style

PEOPLE = 20  # per population
POPULATIONS = ("A", "B", "C")


@dataclass(frozen=True, slots=True)
class Region:
    """Where a population's styles lie: closed ranges."""

    speed: tuple[float, float]
    delay: tuple[int, int]
    noise: tuple[float, float]
    hesitation: tuple[float, float]
    detour: tuple[float, float]
    patience: tuple[int, int]


_REGIONS = {
    "A": Region((0.95, 1.0), (0, 1), (0.0, 0.03), (0.0, 0.001), (0.0, 0.3), (60, 90)),
    "B": Region((0.80, 0.88), (3, 5), (0.08, 0.15), (0.004, 0.01), (0.7, 1.0), (30, 45)),
    "C": Region((0.89, 0.94), (2, 2), (0.04, 0.07), (0.002, 0.003), (0.4, 0.6), (46, 59)),
}


@dataclass(frozen=True, slots=True)
class Participant:
    """One scripted person."""

    name: str  # A01 to A20
    style: Style

    @property
    def agent_id(self) -> str:
        """The id under which this person takes a seat anywhere."""
        return f"person:name={self.name}"

    @property
    def sha256(self) -> str:
        """A fingerprint of the style."""
        return hashlib.sha256(json.dumps(self.style.habits, sort_keys=True).encode()).hexdigest()


def population(name: str) -> tuple[Participant, ...]:
    """The people of A, B or C; always the same."""
    if name not in _REGIONS:
        raise DataError(f"unknown population {name!r}; known: {', '.join(POPULATIONS)}")
    return tuple(Participant(f"{name}{number + 1:02d}", _style(name, number)) for number in range(PEOPLE))


def participant(name: str) -> Participant:
    """The person of a name, A01 to C20."""
    found = {person.name: person for group in POPULATIONS for person in population(group)}
    if name not in found:
        raise DataError(
            f"there is nobody called {name!r}; people are A01 to A{PEOPLE}, B01 to B{PEOPLE}, C01 to C{PEOPLE}"
        )
    return found[name]


def manifest() -> dict[str, object]:
    """All people with their styles and hashes, for a file that says who was trained on and who was not."""
    people = {
        name: [{"name": p.name, "style": p.style.habits, "sha256": p.sha256} for p in population(name)]
        for name in POPULATIONS
    }
    whole = hashlib.sha256(json.dumps(people, sort_keys=True).encode()).hexdigest()
    return {"format": 1, "populations": people, "sha256": whole}


def _style(name: str, number: int) -> Style:
    region, random = _REGIONS[name], Random(f"moving-out/{name}/{number}")
    return Style(
        heavy_first={"A": True, "B": False, "C": number % 2 == 0}[name],
        far_first={"A": False, "B": True, "C": number % 2 == 0}[name],
        patience=random.randint(*region.patience),
        speed=round(random.uniform(*region.speed), 3),
        delay=random.randint(*region.delay),
        noise=round(random.uniform(*region.noise), 3),
        hesitation=round(random.uniform(*region.hesitation), 4),
        detour=round(random.uniform(*region.detour), 2),
    )
