"""What the time of a participant is paid."""

from typing import Any

from movingout.study.design.definition import Study
from movingout.study.design.review import earned
from movingout.study.store.store import Participant


def earnings(study: Study, participant: Participant) -> dict[str, Any] | None:
    """Minutes, amount and currency; None where nothing is paid, and before the end."""
    minutes = minutes_here(participant)
    if study.pay is None or minutes is None:
        return None
    return {"minutes": round(minutes, 1), "amount": earned(study, minutes), "currency": study.pay.currency}


def minutes_here(participant: Participant) -> float | None:
    """From arrival to the end, without long absences; None before the end."""
    if participant.finished_ms is None:
        return None
    return max(0, participant.finished_ms - participant.arrived_ms - participant.away_ms) / 60_000
