"""The fields of study.yaml, checked strictly; nothing about how a study is run.

A study is a list of blocks. In each block every participant meets the block's partners one after another on its maps;
the order and the seats follow from the participant's slot (`.allocation`). Time limits are in ticks of
100 ms: 500 ticks are 50 s.
"""

import math
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, StrictBool, ValidationInfo, field_validator, model_validator

from movingout.agents.built_in import TUTORIAL_PARTNER
from movingout.maps import TUTORIAL, MapError, MapSpec, map_names
from movingout.maps.library import is_generated_or_shipped
from movingout.maps.randomize import Split
from movingout.study.design.instruments import instrument, instrument_names
from movingout.study.design.localized_text import DEFAULT, Language, LocalizedText, shaped
from movingout.study.design.map_files import MapFiles
from movingout.study.questionnaire import KINDS, Kind, Questionnaire, QuestionnaireItem
from movingout.world.constants import LIMIT_TICKS, MAX_TICKS, TUTORIAL_TICKS

Name = Annotated[str, shaped(r"[a-z0-9][a-z0-9-]{0,47}", "small letters, digits and hyphens, at most 48")]
Code = Annotated[str, shaped(r"[A-Za-z0-9-]{4,40}", "4 to 40 letters, digits and hyphens")]
Period = Annotated[str, shaped(r"[1-9]\d{0,4}[dy]|forever", "days or years such as 30d or 3y, or forever")]
Outcome = Literal["done", "partner-left", "no-partner", "withdrew", "dropped-out", "screened-out"]
Seats = Literal["blue", "red", "alternate", "both"]
Order = Literal["fixed", "balanced", "random"]
Element = Literal[
    "research", "purpose", "procedures", "duration", "risks", "benefits", "alternatives",
    "confidentiality", "retention", "compensation", "withdrawal", "contact", "protocol", "age",
]  # fmt: skip


TUTORIAL_WORD = "tutorial"
_TUTORIAL = {"tutorial": True, "map": TUTORIAL, "limit_ticks": TUTORIAL_TICKS, "agent": TUTORIAL_PARTNER}


class StudyModel(BaseModel):
    """Unknown fields are errors, and values never change after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ChoiceBox(StudyModel):
    """An optional or required box in the consent, such as public release of the recordings."""

    id: Name
    text: LocalizedText
    required: bool = False


class Consent(StudyModel):
    """The text that must be agreed to before anything is recorded."""

    version: Annotated[str, Field(min_length=1, max_length=40)]
    text: LocalizedText  # Markdown, or {file: name.md} beside the study file
    boxes: tuple[ChoiceBox, ...] = ()
    covers: tuple[Element, ...] = ()  # what the text mentions, after 45 CFR 46.116; `check` names what is missing


_AFRICAN = ("BIF", "DJF", "GNF", "KMF", "RWF", "UGX", "XAF", "XOF")
_OTHERS = ("CLP", "ISK", "JPY", "KRW", "PYG", "UYI", "VND", "VUV", "XPF")
WHOLE_CURRENCIES = frozenset((*_AFRICAN, *_OTHERS))  # of ISO 4217, those without cents, which nobody can transfer


class Pay(StudyModel):
    """Pay per hour, pro-rated by minutes."""

    currency: Annotated[str, shaped(r"[A-Z]{3}", "three capital letters such as USD")] = "USD"
    per_hour: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    maximum: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None

    @property
    def decimals(self) -> int:
        """How many an amount may have."""
        return 0 if self.currency in WHOLE_CURRENCIES else 2


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


class Partner(StudyModel):
    """An agent; participants and the experimenter's page only ever call it Partner A, B, ..."""

    id: Name
    agent: str


class QuestionSpec(StudyModel):
    """A question of the study's own."""

    id: Annotated[str, shaped(r"[a-z][a-z0-9_]{0,39}", "a small letter, then small letters, digits and _, at most 40")]
    kind: Kind
    text: LocalizedText
    label: str = ""
    options: tuple[LocalizedText, ...] = ()
    ends: tuple[LocalizedText, LocalizedText] | None = None
    expected: int | StrictBool | None = None  # a truth value, which earlier versions took for 0 or 1, is warned of

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if (self.kind == "choice") != (len(self.options) >= 2):
            raise ValueError(
                f"a choice needs two or more options, and only a choice has any; kinds: {', '.join(KINDS)}"
            )
        item = self.build(DEFAULT)
        if self.expected is not None and self.expected not in item.allowed():
            raise ValueError(f"{_expectable(item)}, not {self.expected}")
        return self

    def build(self, language: str) -> QuestionnaireItem:
        ends = (self.ends[0].text(language), self.ends[1].text(language)) if self.ends else ("", "")
        options = tuple(option.text(language) for option in self.options)
        label = self.label or self.id.replace("_", " ").capitalize()
        expected = None if self.expected is None else int(self.expected)
        return QuestionnaireItem(self.id, self.kind, label, self.text.text(language), options, ends, expected)


def _expectable(item: QuestionnaireItem) -> str:
    """Which values an attention item may expect, in words."""
    values = item.allowed()
    if not values:
        return "a text has no value that could be expected"
    if item.kind == "choice":
        first, last = (f"{value} ({item.options[value]!r})" for value in (values[0], values[-1]))
        return f"expected must be the place of an option, which counts from 0: {first} to {last}"
    return f"expected must be a value of the scale, {values[0]} to {values[-1]}"


class QuestionnaireSpec(StudyModel):
    """A questionnaire of the study's own, or a ready-made one with items left out or added (attention items, say)."""

    id: Name
    title: LocalizedText | None = None
    base: str = ""
    without: tuple[str, ...] = ()
    items: tuple[QuestionSpec, ...] = ()
    shuffle: bool = False  # a new order for each participant and time; free text stays last

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.id in instrument_names():
            raise ValueError(f"{self.id!r} is ready-made; give yours another id and say base: {self.id}")
        if self.base and self.base not in instrument_names():
            raise ValueError(f"unknown base {self.base!r}; ready-made: {', '.join(instrument_names())}")
        known = [item.id for item in instrument(self.base).items] if self.base else []
        for name in self.without:
            if name not in known:
                raise ValueError(f"cannot leave out {name!r}; {self.base or 'no base'} has: {', '.join(known)}")
        ids = [*(name for name in known if name not in self.without), *(item.id for item in self.items)]
        if not ids or len(set(ids)) < len(ids):
            raise ValueError("a questionnaire needs at least one item, and every item its own id")
        return self

    def build(self, language: str) -> Questionnaire:
        ready = instrument(self.base, language) if self.base else None
        kept = [item for item in ready.items if item.id not in self.without] if ready else []
        own = [item.build(language) for item in self.items]
        texts = [item for item in (*kept, *own) if item.is_text]
        title = self.title.text(language) if self.title else ready.title if ready else UNTITLED.text(language)
        return Questionnaire(self.id, title, (*(item for item in (*kept, *own) if not item.is_text), *texts))


UNTITLED = LocalizedText({"en": "Questions", "de": "Fragen"})


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


class MapText(StudyModel):
    """What participants read of a map of one's own, which the pages have no words for."""

    title: LocalizedText
    description: LocalizedText


ALLOCATION = 3  # the newest rule of `.allocation`, by which studies begin; earlier ones keep theirs
SUBSTITUTE = "agent"  # the partner, in data, where an agent plays in the place of one who never came
NOTICED_S = 25.0  # after which a page that says nothing counts as closed: it asks every 10 s


class Pairing(StudyModel):
    """How pairs are formed, and what happens when a partner is missing."""

    wait_s: Annotated[int, Field(ge=10, le=3600)] = 300
    otherwise: Literal["code", "agent"] = "code"
    agent: str = "scripted"
    return_s: Annotated[int, Field(ge=5, le=600)] = 60  # how long a partner waits for somebody who lost the connection
    one_screen: Literal["on", "off"] = "on"  # whether a second person may be added at the screen of the first

    @field_validator("one_screen", mode="before")
    @classmethod
    def _switch(cls, one_screen: Any) -> Any:
        return ("off", "on")[one_screen] if isinstance(one_screen, bool) else one_screen  # as YAML 1.1 reads the words


class Requirements(StudyModel):
    """What a participant's machine must provide."""

    rtt_ms: Annotated[int, Field(ge=1, le=2000)] = 150  # median round trip
    gamepad: bool = False


def period_days(period: str) -> float:
    """How long a period is, infinity for one that does not end."""
    return math.inf if period == "forever" else float(period[:-1]) * (365 if period[-1] == "y" else 1)


class Retention(StudyModel):
    """How long each kind of data is kept once a participant has finished: 30d, 3y or forever."""

    identity: Period = "30d"
    trials: Period = "5y"
    released: Period = "forever"  # who ticked `release`

    def shortest(self, other: "Retention") -> "Retention":
        """Of each kind the shorter period of the two."""
        mine, others = self.model_dump(), other.model_dump()
        return Retention(**{kind: min(mine[kind], others[kind], key=period_days) for kind in mine})


class Debrief(StudyModel):
    """What participants are told at the end."""

    text: LocalizedText
    ask_to_keep: bool = True  # whether the data may still be kept, now that all is known


class Study(StudyModel):
    """study.yaml. Validated with `MapFiles` as the context, where it has a file and so maps beside it."""

    _map_files: MapFiles = MapFiles()
    _allocation: int = ALLOCATION

    format: Literal[1]
    id: Name
    title: LocalizedText
    protocol: str = ""  # number given by the review board
    languages: Annotated[tuple[Language, ...], Field(min_length=1)] = (DEFAULT,)
    participants: Annotated[int, Field(ge=1, le=10_000)]
    group: Literal[1, 2] = 1  # people who play together
    seed: Annotated[int, Field(ge=0)] = 1
    minutes: Annotated[int, Field(ge=1, le=480)] = 60  # what participants were told
    consent: Consent
    pay: Pay | None = None
    gate: Requirements = Requirements()
    sounds: Literal["on", "off"] = "off"  # short sounds in rounds; each participant may switch them off
    demographics: str = "demographics"  # a questionnaire, or "" for none
    practice: Practice | None = None
    partners: tuple[Partner, ...] = ()
    shuffle_letters: bool = True  # so that "Partner A" is not simply the first in this file
    blocks: Annotated[tuple[Block, ...], Field(min_length=1, max_length=50)]
    map_texts: dict[str, MapText] = {}  # by the map's name in `maps` or `practice`
    questionnaires: tuple[QuestionnaireSpec, ...] = ()
    at_end: tuple[str, ...] = ()
    pairing: Pairing = Pairing()
    debrief: Debrief | None = None
    codes: Literal["unique"] | dict[Outcome, Code] = "unique"
    retention: Retention = Retention()

    @field_validator("sounds", mode="before")
    @classmethod
    def _switch(cls, sounds: Any) -> Any:
        return ("off", "on")[sounds] if isinstance(sounds, bool) else sounds  # as YAML 1.1 reads the words

    def model_post_init(self, context: Any, /) -> None:
        self._map_files = context or MapFiles()

    @property
    def units(self) -> int:
        """How many participants or pairs are wanted."""
        return -(-self.participants // self.group)

    def questionnaire(self, name: str, language: str = DEFAULT) -> Questionnaire:
        """One of this file's questionnaires, or a ready-made one. Raises StudyError."""
        for spec in self.questionnaires:
            if spec.id == name:
                return spec.build(language)
        return instrument(name, language)

    @property
    def place(self) -> Path | None:
        """The folder of its file, beside which its maps lie; None of a text."""
        return self._map_files.folder

    @property
    def own_maps(self) -> tuple[str, ...]:
        """The maps of one's own, in blocks and practice, as the file names them."""
        names = {name for block in self.blocks for name in block.maps} | {self.practice.map if self.practice else ""}
        return tuple(name for name in sorted(names) if name and not is_generated_or_shipped(name))

    @property
    def allocation(self) -> int:
        """The rule by which slots are drawn (`.allocation`)."""
        return self._allocation

    def allocated_by(self, rule: int) -> Self:
        """The same study whose slots are drawn by another rule: that by which it has begun."""
        study = self.model_copy()
        study._allocation = rule
        return study

    def map_source(self, name: str) -> str:
        """What commands and `load_map` call a map that the file names."""
        return self._map_files.source(name)

    def load_map(self, name: str) -> MapSpec:
        """A map that the file names. Raises MapError where it has gone since."""
        return self._map_files.load(name)

    def map_text(self, name: str, language: str) -> tuple[str, str] | None:
        """Title and description of a map that the file has texts for."""
        text = self.map_texts.get(name)
        return None if text is None else (text.title.text(language), text.description.text(language))

    def shares(self, code: str | None) -> bool:
        """Whether a completion code is one that the file fixes: others have the same."""
        return self.codes != "unique" and code in self.codes.values()

    def shuffles(self, name: str) -> bool:
        return any(spec.id == name and spec.shuffle for spec in self.questionnaires)

    def partner(self, name: str) -> Partner:
        return next(partner for partner in self.partners if partner.id == name)


def known_map(name: str, info: ValidationInfo) -> str:
    """The name, when there is such a map. Raises ValueError where there is none."""
    files: MapFiles = info.context or MapFiles()
    try:
        files.load(name)
    except MapError as error:
        raise ValueError(str(error)) from None
    return name
