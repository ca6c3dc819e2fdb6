"""A partner who is there and keeps somebody waiting: the experimenter hears of it once."""

import pytest

from tests.server.study.support import Served, Visitor
from tests.server.study.test_pairs import paired

TOLD_S = 301.0


@pytest.fixture
def half_ready(pair: Served, monkeypatch: pytest.MonkeyPatch) -> tuple[Visitor, Visitor]:
    """A pair at the practice, of whom the first is ready; an alert may be repeated at once."""
    monkeypatch.setattr("movingout.server.study.alerts.REPEAT_S", 0.0)
    first, second = paired(pair)
    first.next()
    return first, second


def waits(study: Served, waiting: Visitor, *here: Visitor) -> int:
    """Both pages have been there, or silent, for so long; how often the experimenter has heard of who waits now."""
    study.later(TOLD_S)
    for unit in study.running.units:
        unit.ready_at -= TOLD_S
    for visitor in here:
        study.running.participants[visitor.pid].last_seen_at += TOLD_S
    study.look()
    return told(study, waiting)


def told(study: Served, waiting: Visitor) -> int:
    alerts = study.running.alerts.to_json()
    return sum(one["about"] == "slow" and one["values"]["pid"] == waiting.pid for one in alerts)


def test_that_a_partner_keeps_somebody_waiting_is_said_once(pair: Served, half_ready: tuple[Visitor, Visitor]) -> None:
    first, second = half_ready
    assert [waits(pair, first, first, second) for _ in range(3)] == [1, 1, 1]


def test_who_is_away_is_no_partner_who_is_not_ready(pair: Served, half_ready: tuple[Visitor, Visitor]) -> None:
    first, second = half_ready
    assert waits(pair, first) == 0, "both have closed their pages"
    second.look()
    first.look()
    pair.look()
    assert told(pair, first) == 0, "the partner has only just come back"
    assert waits(pair, first, first, second) == 1
