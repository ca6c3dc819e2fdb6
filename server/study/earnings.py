"""What the time of a participant is paid."""

from typing import Any

from movingout.study.design.definition import Study
from movingout.study.design.review import earned
from movingout.study.store.store import Participant


def earnings(study: Study, participant: Participant) -> dict[str, Any] | None:
    """Minutes, amount and currency; None where nothing is paid, and before the end."""
    if study.pay is None or participant.finished_ms is None:
        return None
    minutes = max(0, participant.finished_ms - participant.arrived_ms) / 60_000
    return {"minutes": round(minutes, 1), "amount": earned(study, minutes), "currency": study.pay.currency}
