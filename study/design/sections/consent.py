"""`consent` in a study file."""

from typing import Annotated, Literal

from pydantic import Field

from movingout.study.design.localized_text import LocalizedText
from movingout.study.design.sections.study_model import Name, StudyModel

Element = Literal[
    "research", "purpose", "procedures", "duration", "risks", "benefits", "alternatives",
    "confidentiality", "retention", "compensation", "withdrawal", "contact", "protocol", "age",
]  # fmt: skip


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
