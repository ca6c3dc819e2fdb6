"""Text that participants read, in one or several languages."""

from typing import Annotated, Any

from pydantic import ConfigDict, Field, RootModel, model_validator

DEFAULT = "en"
Language = Annotated[str, Field(pattern=r"^[a-z]{2,3}(-[A-Z]{2})?$")]
_Text = Annotated[str, Field(min_length=1, max_length=100_000)]


class Words(RootModel[dict[Language, _Text]]):
    """A text per language; in the file a plain text counts as English."""

    model_config = ConfigDict(frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        return {DEFAULT: value} if isinstance(value, str) else value

    def text(self, language: str = DEFAULT) -> str:
        """The text in a language, else in English, else in the first that there is."""
        return self.root.get(language) or self.root.get(DEFAULT) or next(iter(self.root.values()), "")
