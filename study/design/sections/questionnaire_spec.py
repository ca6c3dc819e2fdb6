"""`questionnaires` in a study file: questions of its own, and what it changes in ready-made ones."""

from typing import Annotated, Self

from pydantic import StrictBool, model_validator

from movingout.study.design.instruments import instrument, instrument_names
from movingout.study.design.localized_text import DEFAULT, LocalizedText, shaped
from movingout.study.design.sections.study_model import Name, StudyModel
from movingout.study.questionnaire import KINDS, Kind, Questionnaire, QuestionnaireItem


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
