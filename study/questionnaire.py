"""Questionnaires as data: 7-point Likert items, NASA-TLX scales, choices and free text; first of all the paper's.

Source of `PAPER`: the paper's appendix, section "Questionnaire", word for word and in its order. Its section "Human
Study Procedure" announces *eight* Likert items, while the list has nine; the list stands here, and `PAPER_EIGHT` is
its first eight, since the paper does not say which one was left out. The paper gives no wording for the free-response
question, so `comment` is ours.
Knows neither storage nor network: the server serves `as_json()` and checks what comes back with `check_answer`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from random import Random
from types import MappingProxyType
from typing import Final, Literal, get_args

from movingout.maps.errors import MovingOutError

LIKERT_MIN: Final = 1  # strongly disagree
LIKERT_MAX: Final = 7  # strongly agree
NO_ANSWER: Final = -1  # "I prefer not to answer", and the value of every text answer
TEXT_LIMIT: Final = 4000  # characters

TLX_MAX: Final = 20  # 21 gradations, 0 to 20, worth 5 points each of the usual 0 to 100

Kind = Literal["likert7", "tlx", "choice", "text"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)
USUAL_ENDS: Final[Mapping[Kind, tuple[str, str]]] = MappingProxyType(
    {"likert7": ("strongly disagree", "strongly agree"), "tlx": ("very low", "very high")}
)
"""What the two ends of a scale mean; the page says them in its language: form.low, form.high, and form.tlxLow, …"""


class AnswerError(MovingOutError):
    """An answer that does not fit its question."""


@dataclass(frozen=True)
class QuestionnaireItem:
    """One question: `label` is the paper's short name (for tables), `text` what the participant reads."""

    id: str
    kind: Kind
    label: str
    text: str
    options: tuple[str, ...] = ()  # of a choice; the value of an answer is the index
    ends: tuple[str, str] = ("", "")  # what the two ends of a scale mean, where they are not the usual ones
    expected: int | None = None  # an attention item: the one value that shows that it was read

    @property
    def is_rated(self) -> bool:
        """Whether its values are steps of a scale, so that their mean says something."""
        return self.kind in ("likert7", "tlx")

    @property
    def is_text(self) -> bool:
        """Whether it is answered in words, or not at all; everything else needs a value."""
        return self.kind == "text"

    def allowed(self) -> range:
        """The values that answer it; none for free text."""
        if self.kind == "likert7":
            return range(LIKERT_MIN, LIKERT_MAX + 1)
        return range({"tlx": TLX_MAX + 1, "choice": len(self.options), "text": 0}[self.kind])

    def as_json(self) -> dict[str, object]:
        """What the browser gets: never what is expected of an attention item."""
        document: dict[str, object] = {"id": self.id, "kind": self.kind, "label": self.label, "text": self.text}
        if self.options:
            document["options"] = list(self.options)
        if any(self.ends):
            document["ends"] = list(self.ends)
        return document


@dataclass(frozen=True)
class Questionnaire:
    """The questions in their order."""

    id: str
    title: str
    items: tuple[QuestionnaireItem, ...]

    def item(self, question: str) -> QuestionnaireItem:
        """The item with this id; `AnswerError` names the known ones."""
        for item in self.items:
            if item.id == question:
                return item
        known = ", ".join(item.id for item in self.items)
        raise AnswerError(f"unknown question {question!r}; known: {known}")

    def check_answer(self, question: str, value: int, text: str) -> None:
        """Raise `AnswerError` unless `value` (on its scale, or -1) and `text` (at most 4000 characters) fit."""
        item = self.item(question)
        allowed = item.allowed()
        if item.is_text and value != NO_ANSWER:
            raise AnswerError(f"{question} takes a text; its value is always -1, not {value}")
        if not item.is_text and value != NO_ANSWER and value not in allowed:
            raise AnswerError(f"{question} takes {allowed[0]} to {allowed[-1]}, or -1 for no answer, not {value}")
        if not item.is_text and text:
            raise AnswerError(f"{question} takes a number from {allowed[0]} to {allowed[-1]} and no text")
        if len(text) > TEXT_LIMIT:
            raise AnswerError(f"{question} takes at most {TEXT_LIMIT} characters, not {len(text)}")

    def shuffled(self, seed: str) -> "Questionnaire":
        """The same items in an order drawn from the seed; free text stays at the end, where it summarises."""
        scales = [item for item in self.items if not item.is_text]
        Random(f"{self.id} {seed}").shuffle(scales)
        return replace(self, items=(*scales, *(item for item in self.items if item.is_text)))

    def as_json(self) -> dict[str, object]:
        """What the browser gets."""
        return {"id": self.id, "title": self.title, "items": [item.as_json() for item in self.items]}


def _likert(id: str, text: str) -> QuestionnaireItem:
    return QuestionnaireItem(id, "likert7", id.capitalize(), text)


PAPER: Final = Questionnaire(
    id="movingout-paper-nine",
    title="About your partner",
    items=(
        _likert("teamwork", "The other agent and I worked together towards a goal."),
        _likert("humanlike", "The other agent’s actions were human-like."),
        _likert("reasonable", "The other agent always made reasonable actions throughout the game."),
        _likert("follow", "The other agent followed my lead when making decisions."),
        _likert(
            "physics",
            "The other agent understands how to work with me when objects have varying physical characteristics.",
        ),
        _likert(
            "helpfulness",
            "The other agent understands my intention and proactively helps me when I need assistance.",
        ),
        _likert(
            "collision",
            "When our movement paths conflict, the other agent and I can effectively coordinate to avoid collisions.",
        ),
        _likert("alignment", "When moving large items together, our target directions remain well-aligned."),
        _likert("future", "I would like to collaborate with the other agent in future Moving Out tasks."),
        QuestionnaireItem(
            "comment", "text", "Comment", "What else would you like to say about playing with the other agent?"
        ),
    ),
)
PAPER_EIGHT: Final = replace(
    PAPER, id="movingout-paper-eight", items=tuple(item for item in PAPER.items if item.id != "future")
)
