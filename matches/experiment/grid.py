"""A grid as written in YAML: agents x partners x maps x seeds x challenges, in one or more conditions.

name: cross-play
agents: [scripted, "scripted:patience=20"]      # every pair of these, as no partners are given
maps: all
seeds: 20
"""

import hashlib
import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from movingout.agents.errors import AgentError
from movingout.agents.partners.families import group, is_group
from movingout.maps import load_map
from movingout.maps.errors import MapError
from movingout.maps.selection import selected_maps
from movingout.maps.suggestion import known_names
from movingout.matches.experiment.grid_file import read_grid_file
from movingout.matches.experiment.paper_reference import paper_tables
from movingout.matches.experiment.shipped_grids import grid_path
from movingout.matches.match import Challenge
from movingout.world.constants import LIMIT_TICKS, MAX_SEED, MAX_TICKS

AgentId = Annotated[str, Field(min_length=1, max_length=300)]
SeatName = Literal["both", "blue", "red"]
MAX_SEEDS = 1_000_000
_WORDS: dict[str, Any] = {
    **dict.fromkeys(("name", "about"), True),
    "agents": {"__all__": {"needs"}},
    "conditions": {"__all__": {"agents": {"__all__": {"needs"}}}},
}
"""What changes nothing that is played."""
_PLAYED = "played"
"""Validation context of a grid that was played: the files of its maps may have gone since."""


class _GridModel(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Contestant(_GridModel):
    """An agent to evaluate."""

    agent: AgentId
    label: Annotated[str, Field(max_length=60)] = ""  # its name in tables; default: its id
    partners: Annotated[list[AgentId], Field(min_length=1)] | Literal["self"] | None = None  # else the condition's
    needs: Annotated[str, Field(max_length=300)] = ""  # how to get the agent, for when it is missing

    @property
    def name(self) -> str:
        return self.label or self.agent


class Condition(_GridModel):
    """Agents and the partners they play with."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    agents: Annotated[list[AgentId | Contestant], Field(min_length=1)]
    partners: Annotated[list[AgentId], Field(min_length=1)] | Literal["self"] | None = None
    against: Annotated[str, Field(max_length=60)] = ""  # the condition that changes in % are relative to
    paper: Annotated[str, Field(max_length=120)] = ""  # "table: rows" of the paper to compare with

    @property
    def contestants(self) -> list[Contestant]:
        return [Contestant(agent=one) if isinstance(one, str) else one for one in self.agents]

    def partners_of(self, one: Contestant) -> list[str]:
        """Agent ids: the agent's own partners, else the condition's, else all agents of the condition (cross-play)."""
        chosen = one.partners or self.partners
        if chosen == "self":
            return [one.agent]
        return chosen or [other.agent for other in self.contestants]


class Seeds(_GridModel):
    """Seeds first, first + 1, ..."""

    first: Annotated[int, Field(ge=0, le=MAX_SEED)] = 0
    count: Annotated[int, Field(ge=1, le=MAX_SEEDS)]


class Grid(_GridModel):
    """The whole file."""

    format: Literal[1] = 1
    name: Annotated[str, Field(min_length=1, max_length=80)]
    about: Annotated[str, Field(max_length=2000)] = ""
    agents: Annotated[list[AgentId | Contestant], Field(min_length=1)] | None = None
    partners: Annotated[list[AgentId], Field(min_length=1)] | Literal["self"] | None = None
    conditions: Annotated[list[Condition], Field(min_length=1)] | None = None
    maps: list[str] | Literal["all"] = "all"
    challenge: Challenge | Annotated[list[Challenge], Field(min_length=1, max_length=2)] = 1
    split: Literal["train", "evaluation"] = "evaluation"
    seeds: Annotated[int, Field(ge=1, le=MAX_SEEDS)] | Seeds = 20
    seats: SeatName = "both"
    ticks: Annotated[int, Field(ge=1, le=MAX_TICKS)] = LIMIT_TICKS
    agent_limit_s: Annotated[float, Field(gt=0, le=3600, strict=False)] = 20.0

    @field_validator("maps")
    @classmethod
    def _known_maps(cls, maps: str | list[str], info: ValidationInfo) -> str | list[str]:
        for word in maps if isinstance(maps, list) else []:
            try:
                for name in selected_maps(word):
                    if info.context != _PLAYED:
                        load_map(name)
            except MapError as error:
                raise ValueError(str(error)) from error
        if isinstance(maps, list):
            _refuse_doubles(maps, "map")
        if not maps:
            raise ValueError("name at least one map, or write all")
        return maps

    @field_validator("challenge")
    @classmethod
    def _once_each(cls, challenge: Challenge | list[Challenge]) -> Challenge | list[Challenge]:
        if isinstance(challenge, list):
            _refuse_doubles(challenge, "challenge")
        return challenge

    @model_validator(mode="after")
    def _whole(self) -> "Grid":
        if (self.agents is None) == (self.conditions is None):
            raise ValueError("a grid has either 'agents' (and 'partners') or 'conditions'")
        if self.conditions is not None and self.partners is not None:
            raise ValueError("'partners' has no effect with 'conditions'; give each condition its own")
        names = [condition.name for condition in self.all_conditions]
        _refuse_doubles(names, "condition")
        for condition in self.all_conditions:
            pairs = [(one.agent, partner) for one in condition.contestants for partner in condition.partners_of(one)]
            _refuse_doubles([f"{agent} with {partner}" for agent, partner in pairs], "the pair")
            if condition.paper and condition.paper not in paper_tables():
                known = known_names(condition.paper, sorted(paper_tables()))
                raise ValueError(f"paper {condition.paper!r} is not a known table; {known}")
            if condition.against and (condition.against not in names or condition.against == condition.name):
                raise ValueError(
                    f"condition {condition.name!r} is against {condition.against!r}, not another one of this grid"
                )
            for agent_id in [a for one in condition.contestants for a in (one.agent, *condition.partners_of(one))]:
                if is_group(agent_id):
                    _check_group(agent_id)
        return self

    @property
    def all_conditions(self) -> list[Condition]:
        if self.conditions is not None:
            return self.conditions
        assert self.agents is not None
        return [Condition(name=self.name[:60], agents=self.agents, partners=self.partners)]

    @property
    def map_list(self) -> list[str]:
        words = [self.maps] if isinstance(self.maps, str) else self.maps
        return list(dict.fromkeys(name for word in words for name in selected_maps(word)))

    @property
    def challenges(self) -> list[Challenge]:
        return list(self.challenge) if isinstance(self.challenge, list) else [self.challenge]

    @property
    def seed_range(self) -> range:
        seeds = Seeds(count=self.seeds) if isinstance(self.seeds, int) else self.seeds
        return range(seeds.first, seeds.first + seeds.count)

    @property
    def sha256(self) -> str:
        """A fingerprint of what is played; name, description and how to get an agent do not count."""
        asked = self.model_dump(mode="json", exclude=_WORDS)
        return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()


def read_grid(path: Path | str) -> Grid:
    """Read and validate a grid file, or the shipped grid of a name such as `idle-control`.

    Raises MatchError with the line and the path of each fault, or with the names there are.
    """
    return read_grid_file(grid_path(Path(path)), Grid)


def played_grid(written: Any) -> Grid:
    """The grid of a results folder, also where files of its maps have gone. Raises ValidationError."""
    return Grid.model_validate_json(json.dumps(written), context=_PLAYED)


def _refuse_doubles(values: list[Any], what: str) -> None:
    for value in values:
        if values.count(value) > 1:
            raise ValueError(f"{what} {value} is listed twice")


def _check_group(name: str) -> None:
    """Raises ValueError for a population or family that does not exist."""
    try:
        group(name)
    except AgentError as error:
        raise ValueError(str(error)) from error
