"""`retention` in a study file."""

import math
from typing import Annotated

from movingout.study.design.localized_text import shaped
from movingout.study.design.sections.study_model import StudyModel

Period = Annotated[str, shaped(r"[1-9]\d{0,4}[dy]|forever", "days or years such as 30d or 3y, or forever")]


def period_days(period: str) -> float:
    """How long a period is, infinity for one that does not end."""
    return math.inf if period == "forever" else float(period[:-1]) * (365 if period[-1] == "y" else 1)


class Retention(StudyModel):
    """How long each kind of data is kept once a participant has finished: 30d, 3y or forever."""

    identity: Period = "30d"
    trials: Period = "5y"
    released: Period = "forever"  # who ticked `release`

    def shortest(self, other: "Retention") -> "Retention":
        """Of each kind the shorter period of the two."""
        mine, others = self.model_dump(), other.model_dump()
        return Retention(**{kind: min(mine[kind], others[kind], key=period_days) for kind in mine})
