"""The answers of a simulated participant: random, within the scale, and consistent for each partner."""

from dataclasses import dataclass, field
from random import Random
from typing import Any

from movingout.study.questionnaire import NO_ANSWER, QuestionnaireItem

NO_ANSWER_SHARE = 0.03  # share of questions left unanswered
PARTNER_SD = 0.2  # standard deviation of the mean rating between partners, as a share of the scale
ANSWER_SD = 0.15  # standard deviation of single answers around that mean
COMMENTS = (
    "",
    "It was easy to play together.",
    "Sometimes we were in each other’s way.",
    "I did not know where it wanted to go.",
    "Sehr hilfsbereit – 很好! 🙂",
)


@dataclass
class AnswerModel:
    """The answers of one participant; a partner is rated alike in all questions."""

    random: Random
    _partner_bias: dict[str, float] = field(default_factory=dict)

    def answer(self, item: dict[str, Any], partner: str) -> tuple[int, str]:
        """Value and text for an item as the server sends it."""
        asked = QuestionnaireItem(item["id"], item["kind"], "", "", tuple(item.get("options", ())))
        if asked.is_text:
            return NO_ANSWER, self.random.choice(COMMENTS)
        if self.random.random() < NO_ANSWER_SHARE:
            return NO_ANSWER, ""
        low, high = asked.allowed()[0], asked.allowed()[-1]
        if not asked.is_rated:
            return self.random.randint(low, high), ""
        centre = 0.55 + self._partner_bias.setdefault(partner, self.random.gauss(0, PARTNER_SD))
        share = min(1.0, max(0.0, self.random.gauss(centre, ANSWER_SD)))
        return low + round(share * (high - low)), ""
