"""The paper's questionnaire as data: nine 7-point Likert items and one free-response question.

Source: the paper's appendix, section "Questionnaire", word for word and in its order. Its section "Human Study
Procedure" announces *eight* Likert items, while the list has nine; the list stands here, and whoever wants eight
says which one to leave out. The paper gives no wording for the free-response question, so `comment` is ours.
Knows neither storage nor network: the server serves `as_json()` and checks what comes back with `check_answer`.
"""

from dataclasses import dataclass
from typing import Final, Literal

from maps.errors import MovingOutError

LIKERT_MIN: Final = 1  # strongly disagree
LIKERT_MAX: Final = 7  # strongly agree
NO_ANSWER: Final = -1  # "I prefer not to answer", and the value of every text answer
TEXT_LIMIT: Final = 4000  # characters

Kind = Literal["likert7", "text"]


class AnswerError(MovingOutError):
    """An answer that does not fit its question."""


@dataclass(frozen=True)
class Item:
    """One question: `label` is the paper's short name (for tables), `text` what the participant reads."""

    id: str
    kind: Kind
    label: str
    text: str


@dataclass(frozen=True)
class Questionnaire:
    """The questions in their order."""

    id: str
    title: str
    items: tuple[Item, ...]

    def item(self, question: str) -> Item:
        """The item with this id; `AnswerError` names the known ones."""
        for item in self.items:
            if item.id == question:
                return item
        known = ", ".join(item.id for item in self.items)
        raise AnswerError(f"unknown question {question!r}; known: {known}")

    def check_answer(self, question: str, value: int, text: str) -> None:
        """Raise `AnswerError` unless `value` (1-7 or -1) and `text` (at most 4000 characters) fit the question."""
        item = self.item(question)
        if item.kind == "likert7" and value != NO_ANSWER and not LIKERT_MIN <= value <= LIKERT_MAX:
            raise AnswerError(f"{question} takes 1 to 7, or -1 for no answer, not {value}")
        if item.kind == "text" and value != NO_ANSWER:
            raise AnswerError(f"{question} takes a text; its value is always -1, not {value}")
        if item.kind == "likert7" and text:
            raise AnswerError(f"{question} takes a number from 1 to 7 and no text")
        if len(text) > TEXT_LIMIT:
            raise AnswerError(f"{question} takes at most {TEXT_LIMIT} characters, not {len(text)}")

    def as_json(self) -> dict[str, object]:
        """What the browser gets."""
        items = [{"id": item.id, "kind": item.kind, "label": item.label, "text": item.text} for item in self.items]
        return {"id": self.id, "title": self.title, "items": items}


def _likert(id: str, text: str) -> Item:
    return Item(id, "likert7", id.capitalize(), text)


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
        Item("comment", "text", "Comment", "What else would you like to say about playing with the other agent?"),
    ),
)
