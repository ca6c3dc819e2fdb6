"""What a ready-made questionnaire says in one language; a language is one module of these."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from movingout.study.questionnaire import Questionnaire, QuestionnaireItem


@dataclass(frozen=True, slots=True)
class ItemText:
    """The texts of one question; options in the order of the original, `ends` of a scale that names its own."""

    text: str
    options: tuple[str, ...] = ()
    ends: tuple[str, str] = ("", "")


@dataclass(frozen=True, slots=True)
class InstrumentText:
    """The texts of one questionnaire, by item."""

    title: str
    items: Mapping[str, ItemText]

    def translate(self, original: Questionnaire) -> Questionnaire:
        """The questionnaire with these texts; ids, kinds, scales and labels stay as they are."""
        items = tuple(_translated(item, self.items[item.id]) for item in original.items)
        return replace(original, title=self.title, items=items)


def _translated(item: QuestionnaireItem, text: ItemText) -> QuestionnaireItem:
    return replace(item, text=text.text, options=text.options, ends=text.ends)
