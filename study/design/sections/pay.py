"""`pay` in a study file."""

from typing import Annotated

from pydantic import Field

from movingout.study.design.localized_text import shaped
from movingout.study.design.sections.study_model import StudyModel

_AFRICAN = ("BIF", "DJF", "GNF", "KMF", "RWF", "UGX", "XAF", "XOF")
_OTHERS = ("CLP", "ISK", "JPY", "KRW", "PYG", "UYI", "VND", "VUV", "XPF")
WHOLE_CURRENCIES = frozenset((*_AFRICAN, *_OTHERS))  # of ISO 4217, those without cents, which nobody can transfer


class Pay(StudyModel):
    """Pay per hour, pro-rated by minutes."""

    currency: Annotated[str, shaped(r"[A-Z]{3}", "three capital letters such as USD")] = "USD"
    per_hour: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    maximum: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None

    @property
    def decimals(self) -> int:
        """How many an amount may have."""
        return 0 if self.currency in WHOLE_CURRENCIES else 2
