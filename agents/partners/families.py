"""The families of partners: who can be trained with and measured with, and the names by which commands take them.

| name | means |
|---|---|
| `people:A` | the twenty scripted people of a population |
| `family:greedy` | the members of a family; also of one that an installed package adds |
| `families` | the members of every family for training, each family as often as the others |
| `families:without-greedy` | the same but for one: to measure an agent with a family that it was not trained with |
| `@FILE` | the partners of a list of one's own: a text file with an id, or one of the names above, per line |

Members differ within a family in options and seeds; families differ in how they are built. A family of learned partners
has the members whose checkpoints are here.
"""

import hashlib
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cache
from itertools import cycle, islice
from pathlib import Path
from types import MappingProxyType

from movingout.agents.checkpoint.checkpoint import checkpoint_folders, folder_name, model_roots
from movingout.agents.errors import AgentError
from movingout.agents.fault_place import located
from movingout.agents.partners.identity import person_behind
from movingout.agents.scripted.populations import POPULATIONS, population
from movingout.maps.extras import FAMILIES, installed, package_of
from movingout.maps.files.ctrl_c import FOREIGN_CODE_RAISES, is_ctrl_c, noticing_ctrl_c
from movingout.maps.files.list_file import LIST, listed_lines
from movingout.maps.suggestion import known_names

MEMBERS = 20  # of each family
LONGEST_NAME = 50  # of a partner in a list
CLONE_SEEDS = 3  # trainings of each age
SELF_PLAY_SEEDS = 4  # trainings
LATENT_MODEL = "latent@families"  # `movingout train latent`
PEOPLE, FAMILY, ALL, WITHOUT = "people:", "family:", "families", "families:without-"


@dataclass(frozen=True, slots=True)
class FamilyMember:
    """One partner: a short name for files and tables, and the agent id."""

    name: str
    agent_id: str

    @property
    def sha256(self) -> str:
        """A fingerprint of what the id names, as far as the id says it."""
        return hashlib.sha256(self.agent_id.encode()).hexdigest()


@dataclass(frozen=True, slots=True)
class Family:
    """Partners that are built alike."""

    name: str
    about: str  # how they are built
    ids: tuple[str, ...]  # agent ids
    trains: bool = True  # False: for measuring only

    @property
    def members(self) -> tuple[FamilyMember, ...]:
        """Those whose checkpoints are here; their names do not depend on which others are."""
        trained = any("@" in agent_id for agent_id in self.ids)
        here = {folder.name for folder in checkpoint_folders(*model_roots())} if trained else set()
        numbered = (FamilyMember(f"{self.name}{number:02d}", agent_id) for number, agent_id in enumerate(self.ids, 1))
        return tuple(one for one in numbered if _is_here(one.agent_id, here))


@cache
def families() -> Mapping[str, Family]:
    """Every family by name, in the order of tables."""
    return MappingProxyType({family.name: family for family in _make()})


def installed_families() -> Iterator[str]:
    """Names of the families that installed packages add, where none of ours has the name."""
    return (name for name in installed(FAMILIES) if name not in families())


def is_own(name: str) -> bool:
    """Whether a group is somebody's own: a list, or a family of an installed package."""
    return name.startswith(LIST) or (name.startswith(FAMILY) and name.removeprefix(FAMILY) in installed_families())


def is_group(name: str) -> bool:
    """Whether a name stands for several agents rather than one."""
    return name == ALL or name.startswith((PEOPLE, FAMILY, WITHOUT, LIST))


def group(name: str) -> tuple[FamilyMember, ...]:
    """The partners that a name stands for; one alone for the id of an agent.

    Raises AgentError for an unknown population or family, for a family without any checkpoint here, and for a list that
    cannot be read or names nobody. Ids of agents are not looked up.
    """
    if name.startswith(LIST):
        return _listed(name.removeprefix(LIST))
    if name.startswith(PEOPLE):
        return _people(name.removeprefix(PEOPLE))
    if name == ALL:
        return _in_turn(_training_families(""))
    if name.startswith(WITHOUT):
        return _in_turn(_training_families(_training_family(name.removeprefix(WITHOUT)).name))
    if not name.startswith(FAMILY):
        return (FamilyMember(name, name),)
    family = family_of(name.removeprefix(FAMILY))
    if not family.members:
        raise AgentError(
            f"family {family.name!r} has no trained members here: {', '.join(family.ids[:3])}, … are missing"
        )
    return family.members


def test_people_caution(names: Iterable[str]) -> str:
    """A sentence for whoever trains with population C, when some of it are among these groups; else empty.

    Raises AgentError as `group`.
    """
    if not any(name == "C" or are_for_tests(one.agent_id for one in group(name)) for name in names):
        return ""
    return "people of C are for tests: who is trained with them is measured too well"


def are_for_tests(names: Iterable[str]) -> bool:
    """Whether people of population C are among those of these names and ids, with whatever habits and hands."""
    return not {one.name for one in population("C")}.isdisjoint(map(person_behind, names))


def is_scripted_person(name: str) -> bool:
    """Whether somebody of that name is one of populations A, B and C, or `person:delay=3`, with whatever hands."""
    behind = person_behind(name)
    is_built_alike = behind.partition(":")[0] == "person"
    return is_built_alike or behind in {one.name for letter in POPULATIONS for one in population(letter)}


def member(name: str, number: int) -> str:
    """The agent id that a name stands for in episode `number`: another member for each, or the id itself."""
    partners = group(name)
    return partners[number % len(partners)].agent_id


def to_try(name: str) -> tuple[str, ...]:
    """The agent ids to make before anything is played: one of a family of ours, whose members are alike; else all."""
    partners = group(name)
    return tuple(dict.fromkeys(one.agent_id for one in (partners if is_own(name) else partners[:1])))


def _listed(file: str) -> tuple[FamilyMember, ...]:
    if not file:
        raise AgentError("@ is followed by the path of a list of partners, as in @partners.txt")
    try:
        lines = listed_lines(Path(file))
    except UnicodeDecodeError:
        raise AgentError(f"the list of partners {file} is no text in UTF-8") from None
    except OSError as error:
        raise AgentError(f"cannot read the list of partners {file}: {error.strerror or error}") from error
    if not lines:
        raise AgentError(f"the list of partners {file} names nobody; write the id of an agent per line")
    return tuple(one for number, said in lines for one in _on_line(file, number, said))


def _on_line(file: str, number: int, said: str) -> tuple[FamilyMember, ...]:
    if not is_group(said):
        return (FamilyMember(name_of(said), said),)
    if said.startswith(LIST):
        raise AgentError(f"{file}, line {number}: a list names no other list, such as {said}")
    try:
        return group(said)
    except AgentError as error:
        raise AgentError(f"{file}, line {number}: {error}") from error


def name_of(agent_id: str) -> str:
    """A short name of an id, the same in every list; `@` tells a trained agent from a person."""
    name = re.sub(r"[^A-Za-z0-9@.]", "-", agent_id.removeprefix("person:name="))  # sign by sign: x=-1 is not x=1
    return name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}-{FamilyMember(name, agent_id).sha256[:8]}"


def _people(name: str) -> tuple[FamilyMember, ...]:
    if name not in POPULATIONS:
        raise AgentError(f"unknown population {name!r}; {known_names(name, POPULATIONS)}")
    return tuple(FamilyMember(person.name, person.agent_id) for person in population(name))


def _known(name: str) -> Family:
    known = families()
    if name not in known:
        raise AgentError(f"unknown family {name!r}; {known_names(name, [*known, *installed_families()])}")
    return known[name]


def _training_family(name: str) -> Family:
    """One to leave out of `families`. Raises AgentError for one that is not among them."""
    if name in installed_families():
        whose = package_of(installed(FAMILIES)[name])
        raise AgentError(f"family {name} is of the package {whose} and no part of `{ALL}`; say `{ALL}`, which lacks it")
    return _known(name)


def family_of(name: str) -> Family:
    """A family of ours or of an installed package. Raises AgentError for one that is unknown or cannot be loaded."""
    if name not in installed_families():
        return _known(name)
    entry = installed(FAMILIES)[name]
    whose = f"the family {name!r} of {package_of(entry)}"
    with noticing_ctrl_c():
        try:
            with redirect_stdout(sys.stderr):
                ids = entry.load()
        except FOREIGN_CODE_RAISES as error:
            if is_ctrl_c(error):
                raise
            raise AgentError(located(f"cannot load {whose}: {type(error).__name__}: {error}", error)) from error
    if not isinstance(ids, list | tuple) or not ids or not all(isinstance(one, str) for one in ids):
        raise AgentError(f"{whose}: {entry.value} is no list of agent ids")
    return Family(name, f"of the package {package_of(entry)}", tuple(ids))


def _training_families(without: str) -> list[Family]:
    return [family for family in families().values() if family.trains and family.name != without and family.members]


def _in_turn(chosen: list[Family]) -> tuple[FamilyMember, ...]:
    """`MEMBERS` of each family, the families in turn."""
    columns = [list(islice(cycle(family.members), MEMBERS)) for family in chosen]
    return tuple(partner for row in zip(*columns, strict=True) for partner in row)


def _is_here(agent_id: str, folders: set[str]) -> bool:
    policy = agent_id.partition("policy=")[2].partition(",")[0] or agent_id.partition(":")[0]
    return "@" not in policy or folder_name(policy) in folders


def _make() -> Iterator[Family]:
    planners = [person.agent_id for name in "AB" for person in population(name)[: MEMBERS // 2]]
    yield Family(
        "planner", "searches poses for what it carries and packs the goals (people of A and B)", tuple(planners)
    )
    yield Family("greedy", "takes the nearest item the shortest way, without a plan", tuple(_greedy()))
    yield Family("porter", "an order and a goal of its own, straight and stubborn", tuple(_porters()))
    yield Family("novice", "makes a beginner's mistakes and learns within the episode", tuple(_novices()))
    yield Family("late", "late and jittery hands on a planner, a greedy walker or a novice", tuple(_late()))
    yield Family("clone", "trained policies with noise and delay", tuple(_clones()))
    latents = tuple(f"{LATENT_MODEL}:seed={number}" for number in range(MEMBERS))
    yield Family("latent", "drawn from a generative model of the families above, another one in each episode", latents)
    yield Family(
        "self-play", "learned by playing with itself what to do next; how to do it is fixed", tuple(_self_play())
    )


def _greedy() -> Iterator[str]:
    for number in range(MEMBERS):
        order, patience = ("near", "heavy", "light", "far")[number % 4], 40 + 5 * (number // 2 % 9)
        yield f"greedy:seed={number},order={order},patience={patience}"


def _porters() -> Iterator[str]:
    for number in range(MEMBERS):
        yield f"porter:seed={number},patience={(300, 150, 80)[number % 3]}"


def _novices() -> Iterator[str]:
    for number in range(MEMBERS):
        yield f"novice:seed={number},learns_in={(100, 250, 500)[number % 3]}"


def _late() -> Iterator[str]:
    for number in range(MEMBERS):
        inner = (f"greedy:seed={number}", f"person:name=A{number % 10 + 11}", f"novice:seed={number + MEMBERS}")[
            number % 3
        ]
        jitter, keys = (0.1, 0.2, 0.3)[number % 3], number % 4 == 3
        yield f"late:agent={inner},seed={number},delay={2 + number % 4},jitter={jitter},keys={int(keys)}"


def _clones() -> Iterator[str]:
    shipped = ("dp@all", "gru@all", "mlp@all")
    aged = [aged_clone(seed, age) for seed in range(CLONE_SEEDS) for age in ("young", "old")]
    for number in range(MEMBERS):
        policy = shipped[number % 3] if number < MEMBERS // 2 else aged[number % len(aged)]
        yield f"clone:policy={policy},seed={number},delay={number % 3},jitter={(0.02, 0.1, 0.2)[number % 3]}"


def _self_play() -> Iterator[str]:
    for number in range(MEMBERS):
        training, age = number % SELF_PLAY_SEEDS, ("old", "young")[number // SELF_PLAY_SEEDS % 2]
        yield f"self-play-{training}@families:seed={number},age={age},temperature={(1.0, 0.5, 0.25)[number % 3]}"


def aged_clone(seed: int, age: str) -> str:
    """The id of a policy of a seed and an age, as `agents.curriculum.partners` trains it."""
    return f"clone-{seed}-{age}@families"
