"""`blocks` and `practice` in a study file: which rounds are played, on which maps."""

from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from movingout.agents.built_in import TUTORIAL_PARTNER
from movingout.maps import TUTORIAL, MapError, map_names
from movingout.maps.randomize import Split
from movingout.study.design.map_files import MapFiles
from movingout.study.design.sections.study_model import Name, StudyModel
from movingout.world.constants import LIMIT_TICKS, MAX_TICKS, TUTORIAL_TICKS

Seats = Literal["blue", "red", "alternate", "both"]
Order = Literal["fixed", "balanced", "random"]

TUTORIAL_WORD = "tutorial"
_TUTORIAL = {"tutorial": True, "map": TUTORIAL, "limit_ticks": TUTORIAL_TICKS, "agent": TUTORIAL_PARTNER}


class Practice(StudyModel):
    """A practice round, which is not data; it ends at its limit or when everybody is ready.

    `practice: tutorial` stands for the tutorial, which has its own map and partner and ends when all is learned.
    """

    tutorial: bool = False
    map: str = "Simple"
    limit_ticks: Annotated[int, Field(ge=1, le=MAX_TICKS)] = 1200
    agent: str = "scripted"  # unused where people play in pairs

    _known = field_validator("map")(lambda cls, name, info: known_map(name, info))

    @model_validator(mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        if value == TUTORIAL_WORD:
            return _TUTORIAL
        if isinstance(value, dict) and value.get("tutorial") and value != _TUTORIAL:
            raise ValueError(f"the tutorial has no further fields; say practice: {TUTORIAL_WORD}")
        if isinstance(value, str):
            raise ValueError(f"practice is {TUTORIAL_WORD}, or map, limit_ticks and agent")
        return value


class Block(StudyModel):
    """Partners times maps times seats."""

    id: Name
    partners: tuple[Name, ...] = ()  # empty where two people play together
    partner_order: Order = "balanced"
    maps: tuple[str, ...] = map_names()
    map_order: Order = "balanced"
    challenge: Literal[1, 2] = 1  # 1: the maps as designed; 2: randomised variants of them
    split: Split = "evaluation"  # of the shapes that variants may have
    variants: Literal["shared", "fresh"] = "shared"  # the same for everybody and every partner, or new each time
    seats: Seats = "alternate"  # of the participant (of the first of two): see the guide
    rounds: Annotated[int, Field(ge=1, le=60)] = 1  # per map and seat
    limit_ticks: Annotated[int, Field(ge=1, le=MAX_TICKS)] = LIMIT_TICKS
    limit_minutes: Annotated[float, Field(gt=0, le=240)] | None = None  # then the block ends after the running round
    pings: Literal["on", "off"] = "off"  # whether people may say "help here" at a place or an item
    break_after_maps: Annotated[int, Field(ge=1)] | None = None
    after_round: tuple[str, ...] = ()  # questionnaires
    after_partner: tuple[str, ...] = ()

    @field_validator("pings", mode="before")
    @classmethod
    def _switch(cls, pings: Any) -> Any:
        return ("off", "on")[pings] if isinstance(pings, bool) else pings  # as YAML 1.1 reads the words

    @field_validator("maps", mode="before")
    @classmethod
    def _all(cls, maps: Any) -> Any:
        return map_names() if maps == "all" else maps

    @field_validator("maps")
    @classmethod
    def _known(cls, maps: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        if not maps or len(set(maps)) < len(maps):
            raise ValueError("a block needs one or more maps, each once; to play each three times, say rounds: 3")
        return tuple(known_map(name, info) for name in maps)


def known_map(name: str, info: ValidationInfo) -> str:
    """The name, when there is such a map. Raises ValueError where there is none."""
    files: MapFiles = info.context or MapFiles()
    try:
        files.load(name)
    except MapError as error:
        raise ValueError(str(error)) from None
    return name
