"""What a simulated participant answers: drawn, within the scale, with a leaning that lasts."""

from dataclasses import dataclass, field
from random import Random
from typing import Any

from movingout.study.questionnaire import LIKERT_MAX, LIKERT_MIN, NO_ANSWER, TLX_MAX

REFUSES = 0.03  # share of questions that are not answered
LEANING = 0.2  # standard deviation of the leaning towards a partner, as a share of the scale
SPREAD = 0.15  # of single answers around it
COMMENTS = (
    "",
    "It was easy to play together.",
    "Sometimes we were in each other’s way.",
    "I did not know where it wanted to go.",
    "Sehr hilfsbereit – 很好! 🙂",
)


@dataclass
class AnswerModel:
    """One participant's; the same partner is liked alike in all questions."""

    random: Random
    _leanings: dict[str, float] = field(default_factory=dict)

    def answer(self, item: dict[str, Any], partner: str) -> tuple[int, str]:
        """Value and text for a question as the server put it."""
        if item["kind"] == "text":
            return NO_ANSWER, self.random.choice(COMMENTS)
        if self.random.random() < REFUSES:
            return NO_ANSWER, ""
        low, high = scale(item)
        if item["kind"] == "choice":
            return self.random.randint(low, high), ""
        centre = 0.55 + self._leanings.setdefault(partner, self.random.gauss(0, LEANING))
        share = min(1.0, max(0.0, self.random.gauss(centre, SPREAD)))
        return low + round(share * (high - low)), ""


def scale(item: dict[str, Any]) -> tuple[int, int]:
    """The smallest and the largest value of a question that has any."""
    if item["kind"] == "likert7":
        return LIKERT_MIN, LIKERT_MAX
    return 0, (TLX_MAX if item["kind"] == "tlx" else len(item["options"]) - 1)
