"""Three populations of scripted people: A and B for training, C for evaluation only.

A person is one style, drawn once and kept for all episodes. The populations differ in strategy and not only in skill,
and no style of one lies in the range of another:

| | A | B | C |
|---|---|---|---|
| begins with | heavy, near | small, far | heavy, far or small, near |
| role | leads, every second an equal | follows, every second an equal | leads or follows |
| helps a partner that holds a heavy item | within half a second | after two to four seconds | after one or so |
| hands over in a lane | far from the goal | near the goal | about half way |
| grabs | from behind and pushes | from ahead and pulls | from the nearest side |
| stick | any direction | half of them on keys | half of them on keys |
| keeps away from walls | little | much | somewhat |
| holds a heavy item for | 6-9 s | 3-4.5 s | 4.6-5.9 s |
| speed | 0.95-1 | 0.80-0.88 | 0.89-0.94 |
| sees the partner late by | 0-1 ticks | 3-5 ticks | 2 ticks |
| steering noise | 0-0.03 rad | 0.08-0.15 rad | 0.04-0.07 rad |

No agent is trained with C.
"""

import hashlib
import json
from dataclasses import dataclass
from functools import cache
from random import Random

from movingout.agents.errors import DataError
from movingout.agents.scripted.style import Style

PEOPLE = 20  # per population
POPULATIONS = ("A", "B", "C")


@dataclass(frozen=True, slots=True)
class Region:
    """The styles of a population: closed ranges."""

    heavy_first: tuple[bool, bool]  # of people with odd and with even numbers
    far_first: tuple[bool, bool]
    role: tuple[str, str]
    stick: tuple[int, int]
    help_after: tuple[int, int]
    handover: tuple[float, float]
    side: tuple[float, float]
    detour: tuple[float, float]
    patience: tuple[int, int]
    speed: tuple[float, float]
    delay: tuple[int, int]
    noise: tuple[float, float]
    hesitation: tuple[float, float]


_REGIONS = {
    "A": Region(
        heavy_first=(True, True), far_first=(False, False), role=("leader", "equal"), stick=(0, 0),
        help_after=(0, 5), handover=(0.58, 0.7), side=(0.3, 1.0), detour=(0.0, 0.3), patience=(60, 90),
        speed=(0.95, 1.0), delay=(0, 1), noise=(0.0, 0.03), hesitation=(0.0, 0.001),
    ),
    "B": Region(
        heavy_first=(False, False), far_first=(True, True), role=("follower", "equal"), stick=(0, 8),
        help_after=(20, 40), handover=(0.3, 0.42), side=(-1.0, -0.3), detour=(0.7, 1.0), patience=(30, 45),
        speed=(0.80, 0.88), delay=(3, 5), noise=(0.08, 0.15), hesitation=(0.004, 0.01),
    ),
    "C": Region(
        heavy_first=(True, False), far_first=(True, False), role=("follower", "leader"), stick=(8, 0),
        help_after=(8, 15), handover=(0.45, 0.55), side=(-0.2, 0.2), detour=(0.4, 0.6), patience=(46, 59),
        speed=(0.89, 0.94), delay=(2, 2), noise=(0.04, 0.07), hesitation=(0.002, 0.003),
    ),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class ScriptedPerson:
    """One scripted person."""

    name: str  # A01 to A20
    style: Style

    @property
    def agent_id(self) -> str:
        """The agent id of this person."""
        return f"person:name={self.name}"

    @property
    def sha256(self) -> str:
        """A fingerprint of the style."""
        return hashlib.sha256(json.dumps(self.style.habits, sort_keys=True).encode()).hexdigest()


@cache
def population(name: str) -> tuple[ScriptedPerson, ...]:
    """The people of A, B or C. Raises DataError for another name."""
    if name not in _REGIONS:
        raise DataError(f"unknown population {name!r}; known: {', '.join(POPULATIONS)}")
    return tuple(ScriptedPerson(f"{name}{number + 1:02d}", _style(name, number)) for number in range(PEOPLE))


def scripted_person(name: str) -> ScriptedPerson:
    """The person of a name, A01 to C20. Raises DataError for another name."""
    found = {person.name: person for group in POPULATIONS for person in population(group)}
    if name not in found:
        raise DataError(f"there is no person {name!r}; people are A01 to A{PEOPLE}, B01 to B{PEOPLE}, C01 to C{PEOPLE}")
    return found[name]


def manifest() -> dict[str, object]:
    """All people with their styles and hashes, for a file that documents who was trained with."""
    people = {
        name: [{"name": p.name, "style": p.style.habits, "sha256": p.sha256} for p in population(name)]
        for name in POPULATIONS
    }
    whole = hashlib.sha256(json.dumps(people, sort_keys=True).encode()).hexdigest()
    return {"format": 1, "populations": people, "sha256": whole}


def _style(name: str, number: int) -> Style:
    region, random, turn = _REGIONS[name], Random(f"moving-out/{name}/{number}"), number % 2
    return Style(
        heavy_first=region.heavy_first[turn],
        far_first=region.far_first[turn],
        role=region.role[turn],
        stick=region.stick[number // 2 % 2],  # so that both roles occur with both sticks
        patience=random.randint(*region.patience),
        speed=round(random.uniform(*region.speed), 3),
        delay=random.randint(*region.delay),
        noise=round(random.uniform(*region.noise), 3),
        hesitation=round(random.uniform(*region.hesitation), 4),
        detour=round(random.uniform(*region.detour), 2),
        help_after=random.randint(*region.help_after),
        handover=round(random.uniform(*region.handover), 2),
        side=round(random.uniform(*region.side), 2),
    )
