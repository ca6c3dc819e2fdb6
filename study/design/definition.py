"""The fields of study.yaml, checked strictly; nothing about how a study is run.

A study is a list of blocks. In each block every participant meets the block's partners one after another on its maps;
the order and the seats follow from the participant's slot (`.allocation`). Time limits are in ticks of
100 ms: 500 ticks are 50 s.
"""

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator

from movingout.maps import MapSpec
from movingout.maps.library import is_generated_or_shipped
from movingout.study.design.instruments import instrument
from movingout.study.design.localized_text import DEFAULT, Language, LocalizedText, shaped
from movingout.study.design.map_files import MapFiles
from movingout.study.design.sections.consent import Consent
from movingout.study.design.sections.pay import Pay
from movingout.study.design.sections.questionnaire_spec import QuestionnaireSpec
from movingout.study.design.sections.retention import Retention
from movingout.study.design.sections.rounds import Block, Practice
from movingout.study.design.sections.study_model import Name, StudyModel
from movingout.study.questionnaire import Questionnaire

Code = Annotated[str, shaped(r"[A-Za-z0-9-]{4,40}", "4 to 40 letters, digits and hyphens")]
Outcome = Literal["done", "partner-left", "no-partner", "withdrew", "dropped-out", "screened-out"]


class Partner(StudyModel):
    """An agent; participants and the experimenter's page only ever call it Partner A, B, ..."""

    id: Name
    agent: str


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
    map_texts: dict[str, MapText] = Field(default_factory=dict)  # by the map's name in `maps` or `practice`
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
