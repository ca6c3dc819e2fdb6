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


_LANGUAGE = r"[a-z]{2,3}(-[A-Z]{2})?"
Language = Annotated[str, shaped(_LANGUAGE, "a language such as en, de or pt-BR")]
_Text = Annotated[str, Field(min_length=1, max_length=100_000)]


def nearest(wanted: str, offered: Sequence[str]) -> str | None:
    """The language itself, else it without its country, else that of another country: de of de-AT, and de-AT of de."""
    base = wanted.partition("-")[0]
    similar = [one for one in offered if one.partition("-")[0] == base]
    return next((one for one in (wanted, base, *similar) if one in offered), None)


def _place_without_quotes(value: Any) -> str:
    """What stands in the braces of a text such as {partners}, which YAML reads as fields without values; else ""."""
    if not isinstance(value, dict) or any(one is not None for one in value.values()):
        return ""
    return "" if any(re.fullmatch(_LANGUAGE, name) for name in value) else ", ".join(value)


class LocalizedText(RootModel[dict[Language, _Text]]):
    """A text per language; in the file a plain text counts as English."""

    model_config = ConfigDict(frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        for one in (value, *(value.values() if isinstance(value, dict) else ())):
            if names := _place_without_quotes(one):
                raise ValueError(f'a text in braces is put in quotes, or YAML reads a field: write "{{{names}}}"')
        if not isinstance(value, str | dict):
            quotes = f", not {value}: write it in quotes" if isinstance(value, bool | int | float | date) else ""
            raise ValueError(f"should be a text, or one per language: {{en: ..., de: ...}}{quotes}")
        return {DEFAULT: value} if isinstance(value, str) else value

    def text(self, language: str = DEFAULT) -> str:
        """The text in a language, else in that of another country, else in English, else in the first that there is."""
        found = nearest(language, tuple(self.root)) or DEFAULT
        return self.root.get(found) or next(iter(self.root.values()), "")
