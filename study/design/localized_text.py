"""Text that participants read, in one or several languages."""

import re
from collections.abc import Sequence
from datetime import date
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field, RootModel, model_validator

DEFAULT = "en"


def shaped(pattern: str, meaning: str) -> AfterValidator:
    """A text of this shape; `meaning` tells people what is right."""

    def check(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise ValueError(f"should be {meaning}")
        return text

    return AfterValidator(check)


Language = Annotated[str, shaped(r"[a-z]{2,3}(-[A-Z]{2})?", "a language such as en, de or pt-BR")]
_Text = Annotated[str, Field(min_length=1, max_length=100_000)]


def nearest(wanted: str, offered: Sequence[str]) -> str | None:
    """The language itself, else it without its country, else that of another country: de of de-AT, and de-AT of de."""
    base = wanted.partition("-")[0]
    similar = [one for one in offered if one.partition("-")[0] == base]
    return next((one for one in (wanted, base, *similar) if one in offered), None)


class LocalizedText(RootModel[dict[Language, _Text]]):
    """A text per language; in the file a plain text counts as English."""

    model_config = ConfigDict(frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        if not isinstance(value, str | dict):
            quotes = f", not {value}: write it in quotes" if isinstance(value, bool | int | float | date) else ""
            raise ValueError(f"should be a text, or one per language: {{en: ..., de: ...}}{quotes}")
        return {DEFAULT: value} if isinstance(value, str) else value

    def text(self, language: str = DEFAULT) -> str:
        """The text in a language, else in that of another country, else in English, else in the first that there is."""
        found = nearest(language, tuple(self.root)) or DEFAULT
        return self.root.get(found) or next(iter(self.root.values()), "")
